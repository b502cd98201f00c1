"""The robot's process: who is in control, what is refused, and that a page that is gone leaves no torque."""

import math
import threading
import time
from dataclasses import replace
from multiprocessing import Pipe

import pytest

from spiraltrunk.design import presets
from spiraltrunk.errors import DriveError, SpiralTrunkError
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.hardware.winder.slack import compensate_slack
from spiraltrunk.workflows.drive.remote import robot_process
from spiraltrunk.workflows.drive.remote.requests import (
    Alive,
    Arm,
    Clear,
    Disarm,
    Home,
    Jog,
    Leave,
    Limit,
    Move,
    Run,
    Stop,
    check_request,
)
from spiraltrunk.workflows.drive.remote.robot_process import RobotServer
from spiraltrunk.workflows.drive.remote.service import RobotService
from spiraltrunk.workflows.drive.robot import RENEWAL
from spiraltrunk.workflows.drive.twin.twin_robot import TwinRobot

DESIGN = presets.PAPER
OFF = 1e-3
"""Electric torque below which a motor counts as without torque [N m]."""


class Bench:
    """A service on the twin, with a page whose clock is the test's."""

    def __init__(self, patience=0.8):
        self.robot = TwinRobot(DESIGN)
        self.service = RobotService(self.robot, patience=patience)
        self.now = 100.0

    def ask(self, request):
        self.service.handle(request, self.now)

    def run(self, duration, *, answers=True):
        for _ in range(round(duration / RENEWAL)):
            self.now += RENEWAL
            if answers:
                self.ask(Alive(self.now))
            self.service.step(self.now)

    @property
    def mode(self):
        return self.robot.driver.mode

    @property
    def torque(self):
        return max(map(abs, self.robot.read_torques()))


def test_the_state_tells_the_cables_as_the_trunk_sees_them():
    robot = TwinRobot(DESIGN)
    robot.slack = (0.006, 0.0, 0.0)
    snapshot = robot.driver.snapshot()
    wound = compensate_slack(0.05, 0.006, DESIGN.cable_stroke)
    cables = (replace(snapshot.cables[0], pull=wound), *snapshot.cables[1:])
    robot.driver.snapshot = lambda: replace(snapshot, cables=cables)
    try:
        state = RobotService(robot).read_state(0.0)
        assert state.pulls == tuple(robot.read_pulls()) == pytest.approx((0.05, 0.0, 0.0))
    finally:
        robot.close()


@pytest.fixture(scope="module")
def armed_once():
    """Homing takes seconds, so one twin is homed for all tests that begin armed."""
    bench = Bench()
    bench.run(0.2)
    bench.ask(Home())
    while bench.mode is not Mode.SAFE or not bench.robot.driver.is_homed:
        bench.run(0.1)
    yield bench
    bench.robot.close()


@pytest.fixture
def armed(armed_once):
    bench = armed_once
    bench.run(0.2)
    if bench.mode is Mode.FAULT:
        bench.ask(Clear("test"))
    if bench.mode is Mode.SAFE:
        bench.ask(Arm())
    bench.run(0.5)
    assert bench.mode is Mode.ARMED
    yield bench
    bench.run(1.5, answers=False)


@pytest.mark.slow
def test_a_jog_winds_its_cable_and_the_others_follow(armed):
    armed.ask(Limit(tension=20.0, speed=0.05))
    armed.ask(Jog(0, 0.02))
    armed.run(2.0)
    pulls = armed.robot.read_pulls()
    assert pulls[0] == pytest.approx(0.02, abs=0.003)
    assert max(pulls[1:]) < -0.005
    armed.ask(Move((None,) * 3))
    armed.run(2.0)
    assert armed.robot.read_pulls()[0] < pulls[0]
    assert all(cable.tension_target == 0.0 for cable in armed.robot.driver.snapshot().cables)


def test_a_page_that_does_not_answer_has_its_robot_let_go(armed):
    armed.ask(Jog(0, 0.02))
    armed.run(1.0)
    assert armed.torque > 0.02
    armed.run(0.7, answers=False)
    assert armed.mode is Mode.ARMED
    armed.run(0.9, answers=False)
    assert armed.mode is Mode.SAFE
    assert armed.torque < OFF
    assert armed.robot.driver.is_homed
    assert "did not answer for 0.8 s" in armed.service.read_state(armed.now).note
    with pytest.raises(DriveError, match="no page in control answers"):
        armed.ask(Arm())


def test_an_answer_counts_from_when_it_was_asked_for_not_from_when_it_came(armed):
    asked = armed.now
    armed.run(0.7, answers=False)
    armed.ask(Alive(asked))
    armed.ask(Alive(asked - 50.0))
    armed.run(0.2, answers=False)
    armed.run(0.6)
    assert armed.mode is Mode.SAFE


def test_an_answer_from_the_future_counts_as_one_of_now(armed):
    armed.ask(Alive(armed.now + 1000.0))
    armed.run(1.6, answers=False)
    assert armed.mode is Mode.SAFE


def test_a_page_that_leaves_has_its_robot_let_go_at_once(armed):
    armed.run(0.1)
    armed.ask(Leave())
    armed.run(0.6, answers=False)
    assert armed.mode is Mode.SAFE
    assert armed.torque < OFF


def test_disarming_lets_go_once_and_takes_no_moves(armed):
    armed.ask(Disarm())
    armed.ask(Disarm())
    with pytest.raises(DriveError, match="enable the robot first"):
        armed.ask(Jog(0, 0.01))
    armed.run(0.6)
    assert armed.mode is Mode.SAFE
    assert armed.torque < OFF


def test_stop_is_a_fault_that_a_person_clears(armed):
    armed.ask(Jog(0, 0.02))
    armed.run(0.5)
    armed.ask(Stop())
    armed.run(0.1)
    assert armed.mode is Mode.FAULT
    assert armed.torque < OFF
    with pytest.raises(DriveError):
        armed.ask(Clear("  "))
    armed.ask(Clear("test"))
    assert armed.mode is Mode.SAFE


def test_a_jog_beyond_the_drum_is_refused_and_changes_nothing(armed):
    armed.ask(Move((0.1, None, None)))
    armed.ask(Jog(0, 0.03))
    goals = armed.service.read_state(armed.now).goals
    assert goals == (pytest.approx(0.13), None, None)
    with pytest.raises(DriveError, match="what its drum winds"):
        armed.ask(Jog(0, 0.05))
    assert armed.service.read_state(armed.now).goals == goals


def test_a_strategy_does_not_take_the_place_of_an_armed_robot(armed):
    with pytest.raises(DriveError, match="begins with it safe"):
        armed.ask(Run("wrap-vertical", "cylinder-60"))


def test_homing_stops_when_its_page_is_gone():
    bench = Bench()
    bench.run(0.2)
    bench.ask(Home())
    bench.run(0.3)
    assert bench.mode is Mode.HOMING
    bench.run(0.9, answers=False)
    assert bench.mode is Mode.FAULT
    assert bench.torque < OFF
    bench.robot.close()


def test_nothing_gets_torque_without_a_page():
    bench = Bench()
    bench.run(0.2, answers=False)
    for request in (Home(), Arm(), Jog(0, 0.001), Move((None,) * 3), Run("wrap-vertical", "cylinder-60")):
        with pytest.raises(DriveError, match="no page in control answers"):
            bench.ask(request)
    bench.robot.close()


NAN, INF = math.nan, math.inf


@pytest.mark.parametrize(
    "request_",
    [
        Jog(3, 0.001), Jog(-1, 0.001), Jog(True, 0.001), Jog(0.0, 0.001), Jog("1", 0.001),
        Jog(0, 9999.0), Jog(0, 9999), Jog(0, NAN), Jog(0, INF), Jog(0, "5"), Jog(0, None), Jog(0, True),
        Move(()), Move((0.0, 0.0)), Move((9999.0, None, None)), Move((NAN, None, None)), Move((-INF, None, None)),
        Move(("0", None, None)), Move([None, None, None]), Move(None),
        Limit(9999.0, 0.02), Limit(NAN, 0.02), Limit(-1.0, 0.02), Limit(20.0, 0.0), Limit(20.0, NAN), Limit("20", 0.02),
        Alive(NAN), Alive("now"), Clear(""), Clear("\n"), Clear("x" * 61), Clear(5),
        Run("no such strategy", "cylinder-60"), Run("wrap-vertical", "no such object"), Run(5, "cylinder-60"),
        Run("wrap-vertical", "cylinder-60", "x"),
    ],
    ids=str,
)  # fmt: skip
def test_values_that_no_robot_takes_are_refused(request_):
    with pytest.raises(SpiralTrunkError):
        check_request(DESIGN, request_)


def test_the_closed_pipe_leaves_no_torque():
    ours, theirs = Pipe()
    robot = TwinRobot(DESIGN)
    robot.prepare()
    told = []
    service = RobotService(robot, patience=60.0)

    def serve():
        with robot, pytest.raises(robot_process._Closed):
            RobotServer(theirs, service, lambda *message: told.append(message)).serve()

    thread = threading.Thread(target=serve, daemon=True)
    ours.send(("me", Alive(time.monotonic())))
    ours.send(("me", Jog(0, 0.02)))
    ours.send(("me", Jog(0, "nonsense")))
    thread.start()
    end, most = time.monotonic() + 60.0, 0.0
    while most <= 0.02 and time.monotonic() < end:  # The first state after the jog may come before its torque.
        time.sleep(0.02)
        if any(kind == "state" and value[0].goals[0] for kind, *value in list(told)):
            most = max(robot.read_torques())
    ours.close()
    assert most > 0.02
    thread.join(60.0)
    assert not thread.is_alive()
    robot.clock.sleep_until(robot.clock.now() + 0.02)
    assert max(map(abs, robot.read_torques())) < OFF
    assert [one[1] for one in told if one[0] == "refused"] == ["me"]
