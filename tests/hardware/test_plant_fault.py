"""A fault that the driver's thread latches at any moment of a step ends the run with its text."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from spiraltrunk import strategies
from spiraltrunk.control.messages import Command
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DriveError, RunError
from spiraltrunk.hardware.plant import HardwarePlant
from spiraltrunk.hardware.safety.fault import Fault, FaultKind
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.hardware.twin.clock import TwinClock
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.workflows.drive.hardware_trial import build_announced_task

STALL = Fault(kind=FaultKind.STALL, time=0.0, cable=1, text="motor 2 stands at its largest torque")


class RefusingDriver:
    """Refuses every target, because of a fault that was latched just before or for the target itself."""

    def __init__(self, latched: tuple[Fault, ...]) -> None:
        self.clock, self.mode, self.faults, self._latched = TwinClock(), Mode.ARMED, (), latched
        self.cables = [SimpleNamespace(pull=0.0, tension=0.0)] * PAPER.n_cable

    def set_targets(self, *_: object, **__: object) -> None:
        self.faults = self._latched
        raise DriveError("no targets are taken")

    def snapshot(self) -> SimpleNamespace:
        return SimpleNamespace(cables=self.cables)


class Still:
    """An arm at rest in its home posture, and its kinematics."""

    home = np.zeros(7)

    def read(self) -> SimpleNamespace:
        return SimpleNamespace(position=self.home, velocity=self.home, acceleration=self.home, torque=self.home)

    def follow(self, q: np.ndarray, *_: object) -> np.ndarray:
        return q

    def estimate_wrench(self, *_: object) -> tuple[np.ndarray, np.ndarray]:
        return np.eye(4), np.zeros(6)


@pytest.mark.parametrize(
    ("latched", "told"), [((STALL,), "^stall after 0.00 s: motor 2 stands"), ((), "^no targets are taken$")]
)
def test_a_refused_target_ends_the_run_with_the_fault(latched, told):
    task = build_announced_task(PAPER, parse_object("cylinder-60"), strategies.get("wrap-vertical"))
    still = Still()
    plant = HardwarePlant(RefusingDriver(latched), still, still, task)
    plant.reset()
    with pytest.raises(RunError, match=told):
        plant.step(Command(T_world_base=np.eye(4), cable_tension=np.full(PAPER.n_cable, 2.0)))
