"""A robot file on the twin: its ids, directions, limits and slack are the twin's, too."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DesignError
from spiraltrunk.hardware.motors.gm6020 import compute_feedback_id
from spiraltrunk.hardware.setup.cable_setup import CableSetup
from spiraltrunk.hardware.setup.robot_file import MotorSetup, RobotFile
from spiraltrunk.hardware.winder.slack import compensate_slack
from spiraltrunk.workflows.drive.robot import RENEWAL
from spiraltrunk.workflows.drive.twin.twin_robot import TwinOptions, TwinRobot

MOTORS = MotorSetup(family="gm6020", ids=(4, 2, 7), directions=(1, -1, -1))
FILE = RobotFile(name="bench", bus="board:/dev/absent", watchdog="board", motors=MOTORS)


def open_twin(**changes) -> TwinRobot:
    return TwinRobot(PAPER, options=TwinOptions(seed=3, file=replace(FILE, **changes)))


def test_ids_and_directions_are_those_of_the_file():
    heard = set()
    with open_twin() as robot:
        receive = robot.driver._loop.motors._bus.receive

        def note():
            frames = receive()
            heard.update(frame.id for frame in frames)
            return frames

        robot.driver._loop.motors._bus.receive = note
        robot.prepare()
        robot.pull_to([-0.004, 0.02, -0.004], tension=20.0, hold=0.5)
        wound = [motor.wound for motor in robot.motors.motors]
        directions = tuple(motor.direction for motor in robot.motors.motors)
    assert heard == {compute_feedback_id(i) for i in MOTORS.ids}
    assert wound[1] == pytest.approx(0.02, abs=3e-3)
    assert directions == MOTORS.directions


@pytest.mark.parametrize(("most", "seen"), [pytest.param(None, 25.0, marks=pytest.mark.slow), (10.0, 10.0)])
def test_the_largest_tension_is_that_of_the_file(most, seen):
    with open_twin(cables=CableSetup(tension_max=most)) as robot:
        robot.prepare()
        for _ in range(50):
            robot.set_pulls([25.0] * 3, [math.inf] * 3)
            robot.run(RENEWAL)
            robot.raise_fault()
        assert robot.motors.tensions == pytest.approx([seen] * 3, rel=0.15)


def test_the_speed_is_that_of_the_file():
    """Settled within 5 %; it overshoots at first while the tension rises, by 3 to 7 mm/s with the encoders' noise."""
    fastest, settled = {}, math.nan
    for speed in (None, 0.01):
        with open_twin(cables=CableSetup(speed_max=speed)) as robot:
            robot.prepare()
            seen = []
            robot.watch = lambda driver, seen=seen: seen.append((driver.snapshot().time, driver.snapshot().cables[0]))
            robot.pull_to([0.03, math.nan, math.nan], tension=25.0, speed=0.1, hold=0.5)
            robot.watch = None  # Not while it lets go.
            fastest[speed] = max(cable.speed for _, cable in seen)
        (begin, first), (end, last) = seen[-10], seen[-1]
        settled = (last.pull - first.pull) / (end - begin)
    assert fastest[None] > 0.05
    assert settled == pytest.approx(0.01, rel=0.05)
    assert fastest[0.01] < 0.02


@pytest.mark.slow
def test_soft_cables_of_the_file_are_the_twins_and_no_slip():
    with open_twin(cables=CableSetup(stiffness=6e3)) as robot:
        assert {motor.stiffness for motor in robot.motors.motors} == {6e3}
        robot.prepare()
        for tension in (5.0, 40.0, 5.0):
            for _ in range(40):
                robot.set_pulls([tension] * 3, [math.inf] * 3)
                robot.run(RENEWAL)
                robot.raise_fault()


@pytest.mark.slow
def test_slack_of_the_file_is_in_the_cables_and_compensated():
    """The drum winds more, and the trunk is where it would be without slack."""
    slack, pull, ends = 0.012, 0.03, {}
    for each in (0.0, slack):
        with open_twin(cables=CableSetup(slack=(each,) * 3) if each else CableSetup()) as robot:
            robot.prepare()
            robot.pull_to([pull, math.nan, math.nan], tension=25.0, hold=1.0)
            ends[each] = robot.driver.snapshot().cables[0].pull, robot.read_pulls()[0], robot.motors.tensions[0]
    wanted = compensate_slack(pull, slack, PAPER.cable_stroke)
    assert wanted - pull > 2e-3
    assert ends[slack][0] - ends[0.0][0] == pytest.approx(wanted - pull, abs=4e-4)
    assert ends[slack][1] == pytest.approx(ends[0.0][1], abs=4e-4)
    assert ends[slack][2] == pytest.approx(ends[0.0][2], rel=0.1), "the same bend needs the same tension"


def test_a_file_for_servos_lends_its_cables_alone():
    motors = MotorSetup(family="sts", ids=(30, 31, 32), directions=(1, -1, 1))
    file = RobotFile(name="sts", bus="sts:/dev/absent", motors=motors, cables=CableSetup(tension_max=12.0))
    with TwinRobot(PAPER, options=TwinOptions(file=file)) as robot:
        assert (robot.wiring.motors.ids, robot.wiring.motors.signs) == ((1, 2, 3), (1, -1, 1))
        assert robot.wiring.period == TwinOptions().driver.period
        assert {winder.limits.tension_ceiling for winder in robot.wiring.winders} == {12.0}
        robot.prepare()


def test_a_file_that_raises_a_limit_is_refused():
    with pytest.raises(DesignError, match="it can only be lowered"):
        open_twin(cables=CableSetup(tension_max=1e3))
    with pytest.raises(DesignError, match="one for each cable"):
        open_twin(motors=MotorSetup(family="gm6020", ids=(1, 2)))


def test_a_longer_feedback_period_is_no_loss():
    with open_twin(motors=replace(MOTORS, feedback_period=0.004, period=0.004)) as robot:
        robot.prepare()
        robot.pull_to([0.01, math.nan, math.nan], tension=20.0, hold=0.5)
        snapshot = robot.driver.snapshot()
    assert snapshot.loss == pytest.approx(0.0, abs=1e-3)
    assert snapshot.warnings == ()
