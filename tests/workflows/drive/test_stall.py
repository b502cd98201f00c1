"""A drum that something holds while it ought to take in slack, which its own torque does not tell."""

import numpy as np

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


def test_slack_that_a_stuck_drum_does_not_take_in_is_a_stall(monkeypatch):
    """Also of a drum that is not stirred, which is told sooner otherwise."""
    monkeypatch.setattr(winding, "_has_changed", lambda before, now: False)
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
        assert fault.kind is FaultKind.STALL
        assert "slack" in fault.text


def test_a_drum_that_is_stuck_at_an_even_torque_is_stirred_and_told():
    """Cable 1 is at the floor all the time, while the others bend the trunk across it; without a stir nothing tells."""
    noticed = {}
    for is_stuck in (True, False):
        with TwinRobot(PAPER, options=TwinOptions(seed=0)) as robot:
            robot.prepare()
            pull(robot, 0.0, 0.0, 1.0)
            began = robot.clock.now()
            if is_stuck:
                robot.faults.inject(build_fault("stall", {"cable": 0}), at=began)
            pull(robot, 0.0, 20.0, 3.0)
            pull(robot, 20.0, 0.0, 3.0)
            noticed[is_stuck] = [(fault.kind, fault.cable, fault.time - began) for fault in robot.driver.faults[:1]]
    print(f"noticed after {noticed[True][0][2]:.2f} s")
    assert noticed[False] == []
    assert noticed[True][0][:2] == (FaultKind.STALL, 0)
