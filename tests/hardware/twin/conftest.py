"""Twins as most of the tests need them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.hardware.bus.frame_bus import Frame
from spiraltrunk.hardware.motors.gm6020 import TORQUE_PER_RAW, CommandMode, Feedback, decode_feedback, encode_command
from spiraltrunk.hardware.motors.load_cell import LoadCellSettings
from spiraltrunk.hardware.twin.assembly import AssemblyOptions, build_twin
from spiraltrunk.hardware.twin.board import BoardTwin
from spiraltrunk.hardware.twin.cable_load import CableLoad
from spiraltrunk.hardware.twin.clock import TwinClock
from spiraltrunk.hardware.twin.faults import FaultInjector, FaultyBus
from spiraltrunk.hardware.twin.motor import MotorParameters
from spiraltrunk.hardware.twin.motors import NO_NOISE, FeedbackNoise, MotorTwins
from spiraltrunk.hardware.twin.trunk.anchor import Anchor


@dataclass
class Setup:
    """Three motors on a bus in memory, with both ends able to fail."""

    clock: TwinClock
    bus: FaultyBus
    motors: MotorTwins
    injector: FaultInjector
    board: BoardTwin | None

    def command(self, *torques: float) -> None:
        """Send torques [N m]."""
        values = [round(torque / TORQUE_PER_RAW) for torque in torques] + [0] * (4 - len(torques))
        self.bus.send(Frame(CommandMode.CURRENT.value, encode_command(values, CommandMode.CURRENT)))
        self.bus.flush()

    def run(self, duration: float) -> list[Frame]:
        """Let time pass, and return what arrived meanwhile."""
        frames, end = [], self.clock.now() + duration
        while self.clock.now() < end - 1e-9:
            self.clock.sleep_until(self.clock.now() + 1e-3)
            frames += self.bus.receive()
        return frames


def feedback_of(frames: Sequence[Frame], motor_id: int = 1) -> list[Feedback]:
    """Feedback of one motor, as its codec reads it."""
    read = [decode_feedback(frame.data) for frame in frames if frame.id == 0x204 + motor_id]
    return [feedback for feedback in read if feedback is not None]


@pytest.fixture
def build() -> Callable[..., Setup]:
    """Builder of twins; the driver's end gets the injector's faults, or the motors' with ``at_motors``."""

    def build_setup(
        load: CableLoad | None = None,
        *,
        at_motors: bool = False,
        seed: int = 0,
        feedback_period: float = 1e-3,
        is_watched: bool = False,
        noise: FeedbackNoise = NO_NOISE,
        **parameters: Any,
    ) -> Setup:
        options = AssemblyOptions(
            motor=MotorParameters(**parameters), feedback_period=feedback_period, is_watched=is_watched,
            fails_at_driver=not at_motors, noise=noise, seed=seed,
        )  # fmt: skip
        load = Anchor(0.0, 0.0, 0.0) if load is None else load
        cells = LoadCellSettings(port="cells", cables=(0, 1, 2), offsets=(0.0,) * 3, scales=(1.0,) * 3)
        twin = build_twin(PAPER, options, load=load, load_cells=cells)
        assert isinstance(twin.clock, TwinClock)
        return Setup(twin.clock, twin.bus, twin.motors, twin.injector, twin.board)

    return build_setup
