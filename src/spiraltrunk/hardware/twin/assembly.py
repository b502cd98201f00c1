"""Assembly of a twin: bus, motors, trunk, watchdog and faults, and the driver's end of the bus."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import final

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.bus.memory_bus import build_memory_pair
from spiraltrunk.hardware.clock import Clock
from spiraltrunk.hardware.motors.load_cell import LoadCellSettings
from spiraltrunk.hardware.twin.board import BoardTwin
from spiraltrunk.hardware.twin.cable_load import CableLoad
from spiraltrunk.hardware.twin.clock import RealTimeTwin, TwinClock
from spiraltrunk.hardware.twin.device import TwinDevice
from spiraltrunk.hardware.twin.faults import FaultInjector, FaultyBus
from spiraltrunk.hardware.twin.load_cells import LoadCellTwin
from spiraltrunk.hardware.twin.motor import MotorParameters, MotorTwin
from spiraltrunk.hardware.twin.motors import FeedbackNoise, MotorTwins
from spiraltrunk.hardware.twin.trunk.spring_trunk import SpringTrunk


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class AssemblyOptions:
    """What a twin consists of."""

    motor: MotorParameters | Sequence[MotorParameters] = field(default_factory=MotorParameters)
    """Numbers of every motor and its drum, or of each."""
    motor_ids: Sequence[int] | None = None
    """Id of each motor; 1 upwards by default."""
    feedback_period: float = 1e-3
    """Time between two answers of a motor [s]."""
    is_watched: bool = True
    """Whether a board with a watchdog stands between bus and motors."""
    fails_at_driver: bool = True
    """Whether faults of the bus happen at the driver's end, or at the motors'."""
    noise: FeedbackNoise = field(default_factory=FeedbackNoise)
    """Noise of the motors' feedback."""
    seed: int = 0
    """Seed of the faults and of the noise."""


@final
@dataclass(frozen=True, kw_only=True)
class TwinAssembly:
    """Parts of a twin; the driver gets ``bus`` and ``clock``, and nothing else."""

    clock: Clock
    """The driver's clock: with a `TwinClock` the twin advances while the driver sleeps."""
    bus: FaultyBus
    """The driver's end of the bus."""
    motors: MotorTwins
    """Motors, drums and cables."""
    load: CableLoad
    """What the cables pull on."""
    board: BoardTwin | None
    """The watchdog's board, or None."""
    injector: FaultInjector
    """Where faults are injected."""
    devices: tuple[TwinDevice, ...]
    """What is advanced, in this order: faults, what stands beside the motors, motors, load cells."""

    def in_real_time(self) -> RealTimeTwin:
        """The thread that advances a twin whose clock is the computer's."""
        return RealTimeTwin(*self.devices, clock=self.clock)


def build_twin(
    design: TrunkDesign,
    options: AssemblyOptions | None = None,
    *,
    clock: Clock | None = None,
    load: CableLoad | None = None,
    beside: Sequence[TwinDevice] = (),
    load_cells: LoadCellSettings | None = None,
) -> TwinAssembly:
    """A twin of the design's motors.

    Args:
        design: the trunk; it has one motor per cable.
        options: what the twin consists of.
        clock: time; a `TwinClock` of its own by default. With another one, `TwinAssembly.in_real_time` advances it.
        load: what the cables pull on; a hanging `SpringTrunk` by default.
        beside: further devices, such as the gripper's servo.
        load_cells: load cells at the cables, see `MotorTwins.cells`; None for none.
    """
    options = AssemblyOptions() if options is None else options
    clock = TwinClock() if clock is None else clock
    load = SpringTrunk(design) if load is None else load
    driver_end, motor_end = build_memory_pair(clock)
    bus = FaultyBus(driver_end, clock, is_driver=True, seed=options.seed)
    far = FaultyBus(motor_end, clock, is_driver=False, seed=options.seed)
    board = BoardTwin() if options.is_watched else None
    numbers = [options.motor] * design.n_cable if isinstance(options.motor, MotorParameters) else options.motor
    twins = MotorTwins(
        far, load, [MotorTwin(one) for one in numbers], motor_ids=options.motor_ids,
        feedback_period=options.feedback_period, board=board, noise=options.noise, seed=options.seed,
    )  # fmt: skip
    injector = FaultInjector(twins, bus if options.fails_at_driver else far)
    devices: tuple[TwinDevice, ...] = (injector, *beside, twins)
    if load_cells is not None:
        twins.cells = LoadCellTwin(load_cells, lambda: twins.tensions, seed=options.seed)
        devices = (*devices, twins.cells)
    if isinstance(clock, TwinClock):
        for device in devices:
            clock.attach(device)
    return TwinAssembly(clock=clock, bus=bus, motors=twins, load=load, board=board, injector=injector, devices=devices)
