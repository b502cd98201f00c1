"""Texts of the robot's tab: what a person reads in each state, and that no text of a robot becomes markup."""

import math
from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("viser", reason="viser is not installed")

from spiraltrunk.design import presets
from spiraltrunk.hardware.safety.fault import Fault, FaultKind
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.hardware.setup.robot_file import MotorSetup, RobotFile
from spiraltrunk.studio.robot.gauges import SETTLED, Gauges, collect_values, find_ends
from spiraltrunk.studio.robot.tab import UNWATCHED, RobotTab, has_tripped_board
from spiraltrunk.studio.robot.texts import (
    format_cables,
    format_closed,
    format_faults,
    format_run,
    format_status,
    is_stop,
)
from spiraltrunk.workflows.drive.remote.service import RobotService
from spiraltrunk.workflows.drive.remote.setup import RobotSetup
from spiraltrunk.workflows.drive.twin.twin_robot import TwinRobot


class FakePlot:
    """A plot that counts how often its scales are sent."""

    def __init__(self):
        self.n_scales = 0

    def __setattr__(self, name, value):
        if name == "scales":
            self.n_scales += 1
        super().__setattr__(name, value)


class FakeGui:
    """Controls of a page that keeps its plots."""

    def __init__(self):
        self.plots = []

    def add_folder(self, title):
        return nullcontext(SimpleNamespace())

    def add_uplot(self, *_, **options):
        self.plots.append(FakePlot())
        return self.plots[-1]


@pytest.fixture(scope="module")
def state():
    robot = TwinRobot(presets.PAPER)
    robot.run(0.1)
    yield RobotService(robot).read_state(1.0)
    robot.close()


def show(state, **changes):
    return replace(state, snapshot=replace(state.snapshot, **changes))


def test_a_pose_is_saved_without_the_slack_of_the_cables(state):
    """As `drive jog --save` does; both are wound in with it when the pose is reached."""
    homed = replace(show(state, is_homed=True), pulls=(0.01, 0.0, 0.0))
    tab = SimpleNamespace(_hub=SimpleNamespace(state=homed))
    assert RobotTab._read_pulls(tab) == (0.01, 0.0, 0.0)


def test_each_state_says_what_to_do_next(state):
    def say(one, owner="page 1", is_mine=True):
        return format_status(one, robot="twin", owner=owner, is_mine=is_mine)

    assert "connect it" in format_status(None, robot="", owner="", is_mine=False)
    assert "Starting" in say(None)
    assert "Home it first" in say(state)
    assert "Enable it" in say(show(state, is_homed=True))
    assert "Keep this page in front" in say(show(state, mode=Mode.ARMED))
    assert "then clear it" in say(show(state, mode=Mode.FAULT))
    assert "LETTING GO" in say(show(state, mode=Mode.ARMED, is_letting_go=True))
    assert "press STOP" in say(state, owner="page 2", is_mine=False)
    assert "Take control" in say(state, owner="", is_mine=False)


def test_faults_have_kind_cable_time_text_and_reaction(state):
    fault = Fault(kind=FaultKind.SLACK, time=12.345, cable=1, text="no load & <slack>")
    text = format_faults(show(state, mode=Mode.FAULT, faults=(fault,), warnings=("warm",)))
    for part in (
        "slack, broken or tangled cable, cable 2",
        "12.35 s",
        "no load &amp; &lt;slack&gt;",
        "torque ramped",
        "warm",
    ):
        assert part in text
    assert format_faults(state) == ""
    assert "&lt;b&gt;" in format_faults(replace(state, note="<b>"))
    assert "&lt;b&gt;" in format_run(replace(state, result="<b>"))


def test_lengths_are_shown_when_homed_and_tensions_when_armed(state):
    cables = (replace(state.snapshot.cables[0], tension=4.56), *state.snapshot.cables[1:])
    wound = replace(state, pulls=(0.0123, 0.0, 0.0))
    assert "12.3" not in format_cables(show(wound, cables=cables))
    armed = show(wound, cables=cables, is_homed=True, mode=Mode.ARMED)
    text = format_cables(replace(armed, goals=(0.02, None, None)))
    for part in ("12.3", "4.6", "20.0", "follows", "no page answers"):
        assert part in text
    assert math.isinf(state.page_age)


def test_a_length_at_rest_has_no_minus(state):
    text = format_cables(replace(show(state, is_homed=True), pulls=(-0.00002,) * 3))
    assert "0.0" in text
    assert "-0.0" not in text


def test_a_closed_strategy_says_what_opens_it(state):
    assert "Take control" in format_closed(state, is_mine=False)
    assert "Clear the fault" in format_closed(show(state, mode=Mode.FAULT), is_mine=True)
    assert "Disable the robot" in format_closed(show(state, mode=Mode.ARMED), is_mine=True)
    assert "Wait" in format_closed(show(state, mode=Mode.HOMING), is_mine=True)


@pytest.mark.parametrize(
    ("values", "ends"),
    [
        ([-0.008, 0.01], (-5.0, 5.0)),
        ([-60.0, 34.0], (-100.0, 50.0)),
        ([math.nan, 7.0], (-5.0, 10.0)),
        ([math.nan], (-5.0, 5.0)),
    ],
)
def test_noise_at_rest_does_not_fill_a_plot(values, ends):
    assert find_ends(np.array(values), -5.0, 5.0) == ends


def test_a_stop_that_nobody_asked_for_is_not_called_a_person_s(state):
    fault = Fault(kind=FaultKind.STOPPED, time=5.16, cable=None, text="a person stopped the robot")
    stopped = show(state, mode=Mode.FAULT, faults=(fault,))
    told = format_faults(stopped)
    assert "<b>stopped by a person</b>, 5.16 s</div>" in told
    assert told.count("person") == 1
    assert is_stop(stopped)
    assert not is_stop(replace(stopped, note="the page in control did not answer for 1.1 s"))
    assert not is_stop(state)
    text = format_faults(replace(stopped, note="the page in control did not answer for 1.1 s"))
    assert "person" not in text
    assert text.count("did not answer for 1.1 s") == 1


@pytest.mark.parametrize("mode", [Mode.SAFE, Mode.HOMING, Mode.FAULT, Mode.ARMED])
def test_table_and_plot_know_a_tension_in_the_same_states(state, mode):
    shown = show(state, mode=mode)
    _, tension, _ = collect_values((state, shown), 3)
    assert np.isnan(tension[0]).all()
    assert np.isfinite(tension[1]).all() == (mode is Mode.ARMED)
    row = format_cables(shown).split("<tr>")[2]
    assert (row.split("</td>")[3].endswith("&ndash;")) == (mode is not Mode.ARMED)


def test_the_scales_of_plots_are_sent_again_once_they_are_laid_out(state):
    gui = FakeGui()
    gauges = Gauges(SimpleNamespace(gui=gui))
    for _ in range(2 * SETTLED):
        gauges.draw((state, state))
    assert [plot.n_scales for plot in gui.plots] == [1, 1, 1]
    gauges.renew()
    for _ in range(2 * SETTLED):
        gauges.draw((state, state))
    assert [plot.n_scales for plot in gui.plots] == [2, 2, 2]


def test_the_plot_of_lengths_is_empty_until_the_robot_is_homed(state):
    wound, gui = replace(state, pulls=(0.01, 0.01, 0.01)), FakeGui()
    Gauges(SimpleNamespace(gui=gui)).draw((wound, show(wound, is_homed=True)))
    _, *pulls = gui.plots[0].data
    assert np.isnan([pull[0] for pull in pulls]).all()
    assert [pull[1] for pull in pulls] == pytest.approx([10.0] * 3)


def test_a_board_that_has_tripped_is_told_from_a_late_answer_and_from_none(state):
    def run(*watched):
        times = np.arange(len(watched)) * UNWATCHED / 4
        return [
            show(state, time=time, absence="" if is_watched else "it has tripped")
            for time, is_watched in zip(times, watched, strict=True)
        ]

    twin = RobotSetup(design=presets.PAPER)
    tripped = run(True, *[False] * 5)
    assert has_tripped_board(twin, tripped)
    assert not has_tripped_board(twin, run(*[True] * 5, False))
    assert not has_tripped_board(twin, run(False, False))  # The board has not answered yet.
    assert not has_tripped_board(twin, ())
    assert not has_tripped_board(None, tripped)
    motors = MotorSetup(family="gm6020", ids=(1, 2, 3))
    for watchdog, is_done_without, expected in (("board", False, True), ("none", True, False), ("board", True, False)):
        file = RobotFile(name="mine", bus="board:/dev/ttyACM0", watchdog=watchdog, motors=motors)
        setup = RobotSetup(design=presets.PAPER, file=file, without_watchdog=is_done_without)
        assert has_tripped_board(setup, tripped) is expected


def test_table_plot_and_goals_are_all_without_slack():
    robot = TwinRobot(presets.PAPER)
    robot.slack = (0.01, 0.01, 0.01)
    service, stroke = RobotService(robot), presets.PAPER.cable_stroke
    snapshot = robot.driver.snapshot()
    cables = [replace(each, pull=stroke + 0.01, pull_target=stroke + 0.01) for each in snapshot.cables]
    robot.driver.snapshot = lambda: replace(snapshot, cables=tuple(cables), is_homed=True, mode=Mode.ARMED)
    service.run = "lift"
    state = service.read_state(1.0)
    robot.close()
    pulls, _, _ = collect_values((state,), 3)
    assert pulls[0] == pytest.approx([1e3 * stroke] * 3)
    assert state.goals == pytest.approx([stroke] * 3)
    assert format_cables(state).count(f">{1e3 * stroke:.1f}<") == 6


def test_the_table_that_is_sent_anew_has_no_thead(state):
    """Chromium keeps some memory for each, see `format_cables`."""
    assert "<th style" in format_cables(state)
    assert "<thead" not in format_cables(state)
