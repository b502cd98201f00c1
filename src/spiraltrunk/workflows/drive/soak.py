"""Hours of simulated operation: random strategies and random faults on the twin, and what they leave behind.

The trunk is `SpringTrunk`; what runs is the real driver on the twin's bus. A strategy is played by its commands, which
were recorded from a run in simulation, because a scene in MuJoCo is too slow for hours.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np

from spiraltrunk import strategies
from spiraltrunk.control.messages import Command
from spiraltrunk.design.toml import format_design
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import RunError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.files.results import Progress, ignore_progress, read_versions
from spiraltrunk.hardware.log import LogMetadata, LogWriter
from spiraltrunk.hardware.log.recording import log_warning
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.hardware.twin.clock import STEP
from spiraltrunk.hardware.twin.faults import build_fault
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.workflows.drive.recorder import Recorder
from spiraltrunk.workflows.drive.robot import RENEWAL
from spiraltrunk.workflows.drive.selftest import SCENARIOS, build_cell_file
from spiraltrunk.workflows.drive.twin.twin_robot import TwinOptions, TwinRobot
from spiraltrunk.workflows.grasp.trial import run_trial

FAULTS = (
    "frame_loss_20_percent", "20_missed_cycles", "bus_off", "delay", "reorder", "duplicate", "frozen_feedback",
    "power_cycle", "over_temperature", "stall", "cable_break", "cable_slip", "tangled_drum",
)  # fmt: skip
"""Faults of the self-test that are drawn."""

CELL_FAULTS = tuple(name for name, scenario in SCENARIOS.items() if scenario.has_cells)
"""Those that are drawn, too, where the twin has load cells."""

FAULT_PERIOD = 300.0
"""Mean time between two faults [s] (ours)."""

FAULT_TIME = 4.0
"""Time after which a fault that stopped nothing ends [s]."""

REST = 2.0
"""Time that a robot is left alone after a fault, before a person clears it [s]."""

COOL = 60.0
"""Temperature down to which a person lets the motors cool before homing [degC] (ours)."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class FaultRecord:
    """One fault of a soak."""

    name: str
    """What was injected; "" for a fault that nothing caused."""
    injected: float | None
    """When [s]."""
    noticed: float | None
    """When the driver stopped [s]; None where it went on, as it may."""
    kind: str | None
    """What the driver called it."""
    reaction: float | None
    """Time from then until every motor was without torque [s]."""
    turned: float | None = None
    """Cable that the drum concerned winds to and fro within `FAULT_TIME` where nothing is wrong, from the latest run of
    this strategy without a fault [m]; None where there was none, near its end, and for a fault of no drum."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class SoakResult:
    """What hours of operation showed."""

    simulated: float
    """Simulated time [s]."""
    n_strategy: int
    """Strategies played to their end [-]."""
    n_command: int
    """Commands given [-]."""
    n_lost: int
    """Commands that did not reach the driver's targets, while it was armed [-]."""
    drift: float
    """Largest error of a measured length against the true one since homing [m]."""
    faults: tuple[FaultRecord, ...]
    """Every fault."""
    memory: tuple[tuple[float, float], ...]
    """Simulated time [s] and resident memory [bytes], every ten minutes."""


def describe_soak(design: TrunkDesign, seed: int) -> LogMetadata:
    """Metadata of a soak's log."""
    return LogMetadata(
        design=format_design(design), bus="virtual", is_twin=True, seed=seed, versions=read_versions("numpy"),
        provenance="soak of the driver on its twin",
    )  # fmt: skip


def describe_injection(name: str) -> str:
    """The warning by which a soak's log tells an injected fault."""
    return f"injected: {name}"


def record_commands(design: TrunkDesign, names: Sequence[str], seed: int = 0) -> Mapping[str, tuple[Command, ...]]:
    """Commands of each strategy in a run in simulation, with the twin's time step."""
    found = {}
    for name in names:
        strategy = strategies.get(name)
        shape = parse_object(strategy.objects[0])
        found[name] = run_trial(design, shape, strategy=strategy, seed=seed, timestep=STEP).log.commands
    return found


def run_soak(
    design: TrunkDesign,
    commands: Mapping[str, tuple[Command, ...]],
    *,
    duration: float,
    seed: int = 0,
    fault_period: float = FAULT_PERIOD,
    progress: Progress = ignore_progress,
    is_enough: Callable[[], bool] = lambda: False,
    log: Path | None = None,
    has_cells: bool = False,
) -> SoakResult:
    """Play random strategies for ``duration`` [s] of simulated time.

    Args:
        design: the robot.
        commands: commands of the strategies, see `record_commands`.
        duration: simulated time [s].
        seed: seed of everything that is drawn.
        fault_period: mean time between two faults [s]; infinite for none.
        progress: called after every strategy.
        is_enough: asked after every strategy whether to end before ``duration``.
        log: MCAP file to write, which `soak_log.check_log` compares with the result; None for none.
        has_cells: whether the twin has load cells, and their faults are drawn, too.

    Raises:
        RunError: where the twin cannot be homed again.
        OutputError: where the log exists.
    """
    soak = _Soak(design, seed, fault_period, has_cells=has_cells)
    with ExitStack() as closing:
        if log is not None:
            origin = soak.robot.clock.now()
            soak.record(closing.enter_context(LogWriter(log, origin, describe_soak(design, seed), waits=True)))
        return _run(soak, commands, duration, progress, is_enough)


def _run(
    soak: _Soak, commands: Mapping[str, tuple[Command, ...]], duration: float, progress: Progress,
    is_enough: Callable[[], bool],
) -> SoakResult:  # fmt: skip
    soak.home()
    while soak.robot.clock.now() < duration and not is_enough():
        name = str(soak.rng.choice(sorted(commands)))
        if soak.play(name, commands[name]):
            soak.n_strategy += 1
        progress(name, round(soak.robot.clock.now()), round(duration))
    soak.robot.close()
    return SoakResult(
        simulated=soak.robot.clock.now(), n_strategy=soak.n_strategy, n_command=soak.n_command, n_lost=soak.n_lost,
        drift=soak.drift, faults=tuple(soak.records), memory=tuple(soak.memory),
    )  # fmt: skip


@final
class _Soak:
    """A robot in operation, and what was seen of it."""

    def __init__(self, design: TrunkDesign, seed: int, fault_period: float, *, has_cells: bool = False) -> None:
        file = build_cell_file(design) if has_cells else None
        self.robot = TwinRobot(design, options=TwinOptions(seed=seed, file=file))
        self._names = (*FAULTS, *CELL_FAULTS) if has_cells else FAULTS
        self.rng = np.random.default_rng(seed)
        self.n_strategy = self.n_command = self.n_lost = 0
        self.drift = 0.0
        self.records: list[FaultRecord] = []
        self.memory: list[tuple[float, float]] = []
        self._period = fault_period
        self._next = self._draw_next()
        self._active: tuple[str, float] | None = None
        self._turned: float | None = None
        self._wound: dict[str, np.ndarray] = {}
        self._zero: list[float] = []
        self._log: LogWriter | None = None

    def record(self, log: LogWriter) -> None:
        """Write what the driver measures, its faults, and what is injected."""
        self._log, self.robot.watch = log, Recorder(log)

    def _draw_next(self) -> float:
        if math.isinf(self._period):
            return math.inf
        return self.robot.clock.now() + float(self.rng.exponential(self._period))

    def home(self) -> None:
        """Home and arm; the true lengths at the drums' zeros are noted for the drift."""
        self.robot.home()
        readings = self.robot.driver.snapshot().cables
        self._zero = [m.wound - c.pull for m, c in zip(self.robot.motors.motors, readings, strict=True)]
        self.robot.driver.arm()

    def play(self, name: str, commands: Sequence[Command]) -> bool:
        """Play the commands of a strategy; False where a fault ended it."""
        n_fault, wound = len(self.records), []
        for index, command in enumerate(commands):
            self._give(command)
            self._inject(name, index)
            self.robot.run(RENEWAL)
            self._end_harmless()
            if self.robot.driver.mode is not Mode.ARMED:
                self._recover()
                return False
            wound.append([motor.wound for motor in self.robot.motors.motors])
        self._look()
        if self._active is None and len(self.records) == n_fault:
            self._wound[name] = np.array(wound)
        return True

    def _give(self, command: Command) -> None:
        driver = self.robot.driver
        before = driver.snapshot().n_refused
        driver.set_targets(command.cable_tension, command.cable_pull, valid_for=RENEWAL)
        shown = [cable.tension_target for cable in driver.snapshot().cables]
        self.n_command += 1
        is_taken = driver.snapshot().n_refused == before and np.allclose(shown, command.cable_tension)
        self.n_lost += not is_taken

    def _inject(self, strategy: str, index: int) -> None:
        now = self.robot.clock.now()
        if now < self._next or self._active is not None:
            return
        name = str(self.rng.choice(self._names))
        scenario = SCENARIOS[name]
        assert scenario.fault is not None
        fault = build_fault(scenario.fault, scenario.settings)
        self.robot.faults.inject(fault, at=now)
        self._active = name, now
        if self._log is not None:
            log_warning(self._log, now, describe_injection(name))
        until, cable = index + round(FAULT_TIME / RENEWAL), getattr(fault, "cable", None)
        wound = self._wound.get(strategy)
        if cable is not None and wound is not None and len(wound) >= until:
            self._turned = float(np.ptp(wound[index:until, cable]))

    def _end_harmless(self) -> None:
        """End a fault that control got over."""
        now, driver = self.robot.clock.now(), self.robot.driver
        if self._active is None or now < self._active[1] + FAULT_TIME or driver.mode is not Mode.ARMED:
            return
        name, injected = self._active
        self.records.append(
            FaultRecord(name=name, injected=injected, noticed=None, kind=None, reaction=None, turned=self._turned)
        )
        self._clear()

    def _clear(self) -> None:
        self.robot.faults.clear()
        self._active = self._turned = None
        self._next = self._draw_next()

    def _recover(self) -> None:
        """Note the fault, and do what a person would: mend it, clear it, home, arm."""
        robot, fault = self.robot, self.robot.driver.faults[0]
        name, injected = self._active or ("", None)
        off = None
        while off is None and robot.clock.now() < fault.time + REST:
            robot.run(robot.options.driver.period)
            if all(abs(motor.torque) < 1e-3 for motor in robot.motors.motors):
                off = robot.clock.now() - fault.time
        self.records.append(
            FaultRecord(
                name=name,
                injected=injected,
                noticed=fault.time,
                kind=fault.kind.value,
                reaction=off,
                turned=self._turned,
            )
        )
        self._clear()
        robot.run(REST)
        while max(motor.temperature for motor in robot.motors.motors) > COOL:
            robot.run(REST)
        robot.driver.clear_fault("soak")
        robot.run(0.2)
        for _ in range(3):
            try:
                self.home()
                return
            except RunError:
                if robot.driver.mode is Mode.FAULT:
                    robot.run(REST)
                    robot.driver.clear_fault("soak")
        raise RunError(f"the twin cannot be homed after {name or fault.kind.value}")

    def _look(self) -> None:
        """Compare measured with true lengths, and note the memory."""
        now, cables = self.robot.clock.now(), self.robot.driver.snapshot().cables
        if self._active is None:
            errors = [
                abs(cable.pull - (motor.wound - zero))
                for cable, motor, zero in zip(cables, self.robot.motors.motors, self._zero, strict=True)
            ]
            self.drift = max(self.drift, *errors)
        if not self.memory or now > self.memory[-1][0] + 600.0:
            self.memory.append((now, _read_memory()))


def _read_memory() -> float:
    """Resident memory of this process [bytes]; NaN where the system does not report it."""
    try:
        fields = Path("/proc/self/statm").read_text(encoding="ascii").split()
    except OSError:
        return math.nan
    return 4096.0 * int(fields[1])
