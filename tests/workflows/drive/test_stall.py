"""A drum that something holds while it ought to take in slack, which its own torque does not tell."""

import math

import numpy as np
import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.hardware.driver import winding
from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.hardware.twin.faults import build_fault
from spiraltrunk.workflows.drive.robot import RENEWAL
from spiraltrunk.workflows.drive.twin.twin_robot import TwinOptions, TwinRobot


def pull(robot: TwinRobot, start: float, end: float, duration: float) -> None:
    """Cables 2 and 3 go from one tension to another [N]; cable 1 is at the floor."""
    for share in np.linspace(0.0, 1.0, round(duration / RENEWAL)):
        if robot.driver.mode is Mode.ARMED:
            robot.driver.set_targets([0.0, *[start + share * (end - start)] * 2], valid_for=RENEWAL)
        robot.run(RENEWAL)


@pytest.mark.parametrize(
    ("stir_length", "told", "most"), [(math.inf, "slack", 4.0), (winding.STIR_LENGTH, "does not turn", 1.5)]
)
def test_slack_that_a_stuck_drum_does_not_take_in_is_a_stall(monkeypatch, stir_length, told, most):
    """The torque is even, at the floor; a stir tells it sooner than the slack does."""
    monkeypatch.setattr(winding, "STIR_LENGTH", stir_length)
    with TwinRobot(PAPER, options=TwinOptions(seed=0)) as robot:
        robot.prepare()
        pull(robot, 0.0, 20.0, 3.0)
        pull(robot, 20.0, 20.0, 0.5)
        assert robot.driver.snapshot().cables[0].pull < -0.05
        robot.faults.inject(build_fault("stall", {"cable": 0}), at=robot.clock.now())
        began = robot.clock.now()
        pull(robot, 20.0, 0.0, 2.0)
        pull(robot, 0.0, 0.0, 2.0)
        (fault, *_) = robot.driver.faults
        print(f"noticed after {fault.time - began:.2f} s: {fault.text}")
        assert (fault.kind, told in fault.text) == (FaultKind.STALL, True)
        assert fault.time - began < most
