"""A plant's start beside the home posture, and faults, which the driver's thread latches at any moment of a step."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from spiraltrunk import strategies
from spiraltrunk.control.messages import Command
from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DriveError, RunError
from spiraltrunk.hardware.plant import BESIDE, HardwarePlant
from spiraltrunk.hardware.safety.fault import Fault, FaultKind
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.hardware.twin.clock import TwinClock
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.robot.panda import PANDA
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

    def __init__(self, beside: float = 0.0) -> None:
        self.position = self.home + beside

    def read(self) -> SimpleNamespace:
        return SimpleNamespace(position=self.position, velocity=self.home, acceleration=self.home, torque=self.home)

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


class TakingDriver(RefusingDriver):
    """Takes every target, and notes the arm's."""

    def __init__(self) -> None:
        super().__init__(())
        self.sent: list[np.ndarray] = []

    def set_targets(self, *_: object, arm_position: np.ndarray, **__: object) -> None:
        self.sent.append(arm_position)

    def wait(self) -> None:
        self.clock.sleep_until(self.clock.now() + 0.002)

    def tick(self) -> None: ...


def test_an_arm_beside_its_home_posture_goes_there_without_a_jump():
    """A PD law of 600 N m/rad would turn a jump of 2 deg into 21 N m at once, above a Panda's collision threshold."""
    task = build_announced_task(PAPER, parse_object("cylinder-60"), strategies.get("wrap-vertical"))
    driver, still, beside = TakingDriver(), Still(np.radians(1.9)), np.radians(1.9)
    plant = HardwarePlant(driver, still, still, task)
    plant.reset()
    for _ in range(60):
        plant.step(Command(T_world_base=np.eye(4), cable_tension=np.full(PAPER.n_cable, 2.0)))
    sent = np.array(driver.sent)
    assert sent[0] == pytest.approx(np.full(7, beside), abs=1e-12)
    assert (sent[50:] == 0.0).all()
    assert np.abs(np.diff(sent, axis=0)).max() / CONTROL_PERIOD == pytest.approx(1.875 * beside, rel=0.01)
    acceleration = np.abs(np.diff(np.vstack([sent[:1], sent[:1], sent]), 2, axis=0)).max() / CONTROL_PERIOD**2
    assert acceleration == pytest.approx(5.77 * beside, rel=0.02)
    assert acceleration < 0.05 * PANDA.limits.acceleration.min()


@pytest.mark.parametrize("beside", [1.01 * BESIDE, -1.01 * BESIDE, np.nan])
def test_an_arm_elsewhere_is_refused(beside):
    task = build_announced_task(PAPER, parse_object("cylinder-60"), strategies.get("wrap-vertical"))
    still = Still(beside)
    with pytest.raises(RunError, match="not in its home posture, within 2 deg of each joint"):
        HardwarePlant(TakingDriver(), still, still, task).reset()
