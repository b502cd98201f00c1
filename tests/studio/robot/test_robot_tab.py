"""The Robot tab in a real browser: its main act on the twin, a second page beside it, and a page that is closed."""

import time
from dataclasses import replace
from functools import partial
from typing import ClassVar

import numpy as np
import pytest

pytest.importorskip("viser", reason="viser is not installed")

from spiraltrunk.design import presets
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.hardware.setup.poses import load_poses
from spiraltrunk.studio.robot import hub as hub_module
from spiraltrunk.studio.robot.hub import RobotHub
from spiraltrunk.studio.robot.tab import UNWATCHED, RobotTab
from spiraltrunk.workflows.drive.gamepad_jog import compute_pull_limits
from spiraltrunk.workflows.drive.remote.requests import Alive, Clear, Home, Leave, Stop
from spiraltrunk.workflows.drive.remote.service import RobotService
from spiraltrunk.workflows.drive.twin.twin_robot import TwinRobot

pytestmark = pytest.mark.slow  # A real browser, which draws by software: minutes in all.

PATIENT = 60_000
"""Time that a browser on a busy computer has [ms]."""

OFF = 1e-3
"""Electric torque below which a motor counts as without torque [N m]."""


@pytest.fixture
def hub():
    """A twin that is faster than the clock, and patient with a browser that draws without a GPU."""
    one = RobotHub(presets.PAPER, patience=60.0, pace=20.0)
    yield one
    one.close()


def wait_until(holds, seconds=60.0):
    end = time.monotonic() + seconds
    while not holds() and time.monotonic() < end:
        time.sleep(0.05)
    assert holds()


def press(page, name):
    page.get_by_role("button", name=name, exact=True).click(timeout=PATIENT)


def find_mode(hub):
    return hub.state and hub.state.snapshot.mode


@pytest.mark.slow
def test_connect_home_enable_jog_stop_and_close(hub, studio, open_page, take_picture, tmp_path):
    poses = tmp_path / "poses.json"
    tabs = []
    running = studio([lambda one: tabs.append(RobotTab(one, hub=hub, poses=poses)) or tabs[-1]])
    page = open_page(running)
    note = tabs[0]._picture._note
    assert (note.text, note.visible) == ("the design; no robot is connected", True)
    wait_until(lambda: (take_picture(page, "design")[200:620, 380:500].max(axis=2) < 220).mean() > 0.2)
    press(page, "Connect")
    press(page, "Home")
    press(page, "Enable")
    wait_until(lambda: find_mode(hub) is Mode.ARMED)
    assert not note.visible
    before = take_picture(page, "straight")
    for _ in range(3):
        page.get_by_role("button", name="wind in").first.click(timeout=PATIENT)
    wait_until(lambda: hub.state.goals[0] is not None and hub.state.snapshot.cables[0].pull > 0.01)
    wait_until(lambda: (np.abs(take_picture(page, "bent") - before) > 30).sum() > 500)

    page.get_by_text("Poses", exact=True).click()
    press(page, "Save the pose")
    page.get_by_text("the pose has no name").wait_for(timeout=PATIENT)
    row = page.locator("div:has(> div label)", has=page.get_by_text("Name", exact=True)).last
    row.get_by_role("textbox").last.fill("bent")

    def save() -> bool:
        press(page, "Save the pose")
        page.wait_for_timeout(500)
        return poses.exists()

    wait_until(save)  # The text may leave the box after the press.
    page.get_by_text("the pose 'bent' is saved in poses.json").wait_for(timeout=PATIENT)
    saved = load_poses(poses, compute_pull_limits(presets.PAPER))["bent"]
    assert saved.pulls[0] > 0.01
    press(page, "All cables follow")
    wait_until(lambda: hub.state.goals[0] is None)
    press(page, "Move to the pose")
    wait_until(lambda: hub.state.goals == pytest.approx(saved.pulls))

    other = open_page(running, own=True)
    other.get_by_text("In control: page 1").wait_for(timeout=PATIENT)
    for name in ("Take control", "Enable", "Disable", "Home", "Disconnect"):
        assert other.get_by_role("button", name=name, exact=True).count() == 0
    other.get_by_role("button", name="STOP").click(timeout=PATIENT)
    wait_until(lambda: find_mode(hub) is Mode.FAULT and max(map(abs, hub.state.true_torques)) < OFF)
    page.get_by_text("stopped by a person").first.wait_for(timeout=PATIENT)

    press(page, "Clear the stop")
    press(page, "Enable")
    wait_until(lambda: find_mode(hub) is Mode.ARMED)
    page.get_by_role("textbox").filter(visible=True).first.focus()
    page.keyboard.press("Escape")
    wait_until(lambda: find_mode(hub) is Mode.FAULT)
    press(page, "Clear the stop")
    press(page, "Enable")
    wait_until(lambda: find_mode(hub) is Mode.ARMED and max(hub.state.true_torques) > OFF)
    page.close()
    wait_until(lambda: find_mode(hub) is Mode.SAFE and max(map(abs, hub.state.true_torques)) < OFF)
    assert hub.owner == ""
    other.get_by_role("button", name="Take control", exact=True).wait_for(timeout=PATIENT)


def test_stop_while_homing(studio, open_page):
    hub = RobotHub(presets.PAPER, patience=60.0)
    page = open_page(studio([partial(RobotTab, hub=hub)]))
    press(page, "Connect")
    press(page, "Home")
    wait_until(lambda: find_mode(hub) is Mode.HOMING and max(map(abs, hub.state.true_torques)) > OFF)
    page.get_by_role("button", name="STOP").click(timeout=PATIENT)
    wait_until(lambda: find_mode(hub) is Mode.FAULT and max(map(abs, hub.state.true_torques)) < OFF)
    page.get_by_text("stopped by a person").first.wait_for(timeout=PATIENT)
    press(page, "Clear the stop")
    page.get_by_text("No torque. Home it first.").wait_for(timeout=PATIENT)
    assert page.get_by_role("button", name="Enable", exact=True).count() == 0
    hub.close()


class IdleLink:
    """A link to a robot that stays as it is, and keeps what it is asked."""

    asked: ClassVar[list] = []

    def __init__(self, setup, *, on_state, on_refusal, on_end):
        self.setup, self._on_state, self._on_end = setup, on_state, on_end

    def start(self):
        robot = TwinRobot(self.setup.design)
        robot.run(0.1)
        self._on_state(RobotService(robot).read_state(0.0))
        robot.close()

    def ask(self, request, asker=""):
        self.asked.append((asker, type(request)))

    def close(self):
        self._on_end(None)

    def join(self):
        pass


def test_the_browser_answers_and_a_second_page_can_only_stop(hub, studio, open_page, monkeypatch):
    monkeypatch.setattr(hub_module, "RobotLink", IdleLink)
    IdleLink.asked.clear()
    running = studio([partial(RobotTab, hub=hub)])
    page = open_page(running)
    press(page, "Connect")
    press(page, "Home")
    wait_until(lambda: ("page 1", Home) in IdleLink.asked)
    wait_until(lambda: sum(kind is Alive for _, kind in IdleLink.asked) > 3)
    other = open_page(running, own=True)
    other.get_by_text("In control: page 1").wait_for(timeout=PATIENT)
    assert other.get_by_role("button", name="Home", exact=True).count() == 0
    assert other.get_by_role("button", name="Take control", exact=True).count() == 0
    other.keyboard.press("Escape")
    wait_until(lambda: ("", Stop) in IdleLink.asked)
    page.close()
    wait_until(lambda: ("", Leave) in IdleLink.asked and not hub.owner)
    press(other, "Take control")
    wait_until(lambda: hub.owner == "page 2")


class TrippedLink(IdleLink):
    """A link to a robot that is safe, and whose board's watchdog has tripped."""

    def start(self):
        robot = TwinRobot(self.setup.design)
        robot.run(0.1)
        state = RobotService(robot).read_state(0.0)
        for instant in np.arange(9) * UNWATCHED / 4:
            self._on_state(replace(state, snapshot=replace(state.snapshot, time=instant, absence="it has tripped")))
        robot.close()


def test_a_board_that_has_tripped_is_cleared_while_the_robot_is_safe(hub, studio, open_page, monkeypatch):
    monkeypatch.setattr(hub_module, "RobotLink", TrippedLink)
    IdleLink.asked.clear()
    page = open_page(studio([partial(RobotTab, hub=hub)]))
    clear = page.get_by_role("button", name="I found the cause: clear the fault", exact=True)
    assert clear.count() == 0, "no robot is connected"
    press(page, "Connect")
    clear.wait_for(timeout=PATIENT)
    assert find_mode(hub) is Mode.SAFE
    assert page.get_by_text("No torque. Home it first.").is_visible(), "the board's trip is no fault of the robot"
    assert page.get_by_role("button", name="Home", exact=True).is_visible()
    assert ("page 1", Clear) not in IdleLink.asked
    clear.click(timeout=PATIENT)
    wait_until(lambda: ("page 1", Clear) in IdleLink.asked)
    assert page.get_by_role("alert").filter(has_text="That did not work").count() == 0
