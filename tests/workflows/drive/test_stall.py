"""A drum that something holds while it ought to take in slack, which its own torque does not tell."""

import itertools
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

pytestmark = pytest.mark.usefixtures("prepared_once")


def pull(robot: TwinRobot, start: float, end: float, duration: float) -> None:
    """Cables 2 and 3 go from one tension to another [N]; cable 1 is at the floor."""
    for share in np.linspace(0.0, 1.0, round(duration / RENEWAL)):
        if robot.driver.mode is Mode.ARMED:
            robot.driver.set_targets([0.0, *[start + share * (end - start)] * 2], valid_for=RENEWAL)
        robot.run(RENEWAL)


def test_slack_that_a_stuck_drum_does_not_take_in_is_a_stall():
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


def test_a_drum_that_is_stuck_at_an_even_tension_is_stirred_and_told(monkeypatch):
    """Cable 1 holds 15 N all the time, while the others let the trunk bend; without a stir nothing tells."""
    noticed, length = {}, winding.STIR_LENGTH
    for stir_length in (length, math.inf):
        monkeypatch.setattr(winding, "STIR_LENGTH", stir_length)
        with TwinRobot(PAPER, options=TwinOptions(seed=0)) as robot:
            robot.prepare()
            for share in (*np.linspace(0.0, 1.0, 100), *[1.0] * 50):
                robot.driver.set_targets([15.0 * share] * 3, valid_for=RENEWAL)
                robot.run(RENEWAL)
            began = robot.clock.now()
            robot.faults.inject(build_fault("stall", {"cable": 0}), at=began)
            for share in np.linspace(0.0, 1.0, 150):
                if robot.driver.mode is Mode.ARMED:
                    robot.driver.set_targets([15.0, 15.0 + 15.0 * share, 15.0 - 13.0 * share], valid_for=RENEWAL)
                robot.run(RENEWAL)
            noticed[stir_length] = [(fault.kind, fault.cable) for fault in robot.driver.faults[:1]]
            moved = [round(1e3 * cable.pull, 1) for cable in robot.driver.snapshot().cables]
            print(noticed[stir_length], moved)
    assert noticed == {length: [(FaultKind.STALL, 0)], math.inf: []}


@pytest.mark.parametrize("delay", [0.02, pytest.param(0.2, marks=pytest.mark.slow)])
def test_a_cable_that_breaks_while_its_drum_is_stirred_is_noticed_in_time(monkeypatch, delay):
    """Cable 1 holds 12 N at rest, and is stirred whenever that is asked for; the bar is that of the self-test."""
    asked = itertools.chain([True], itertools.repeat(False))
    with TwinRobot(PAPER, options=TwinOptions(seed=0)) as robot:
        robot.prepare()
        targets = [12.0, 12.0, 12.0]
        for _ in range(100):
            robot.driver.set_targets(targets, valid_for=RENEWAL)
            robot.run(RENEWAL)
        monkeypatch.setattr(winding.Winding, "_find_stirred", lambda self, motors: [next(asked), False, False])
        began = robot.clock.now() + delay
        robot.faults.inject(build_fault("cable_break", {"cable": 0}), at=began)
        for _ in range(25):
            if robot.driver.mode is Mode.ARMED:
                robot.driver.set_targets(targets, valid_for=RENEWAL)
            robot.run(RENEWAL)
        (fault, *_) = robot.driver.faults
        print(f"noticed after {1e3 * (fault.time - began):.0f} ms: {fault.text}")
        assert 0.0 < fault.time - began < 0.2
