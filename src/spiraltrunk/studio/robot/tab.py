"""Tab *Robot*: connect, take control, home, enable, jog, stop, and see what the robot does."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, final

from spiraltrunk.errors import StudioError
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.studio.drawing.camera import aim_at_trunk
from spiraltrunk.studio.page.buttons import add_button
from spiraltrunk.studio.page.controls import Choice
from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.page.theme import GRAY
from spiraltrunk.studio.robot.gauges import Gauges
from spiraltrunk.studio.robot.heartbeat import PageHeartbeat
from spiraltrunk.studio.robot.hub import RobotHub
from spiraltrunk.studio.robot.move_controls import MoveControls
from spiraltrunk.studio.robot.pose_controls import PoseControls
from spiraltrunk.studio.robot.stop_panel import StopPanel
from spiraltrunk.studio.robot.strategy_controls import StrategyControls
from spiraltrunk.studio.robot.texts import (
    CLEAR_FAULT,
    CLEAR_STOP,
    format_cables,
    format_faults,
    format_status,
    is_stop,
)
from spiraltrunk.studio.robot.twin_picture import TwinPicture
from spiraltrunk.workflows.drive.remote.requests import Arm, Clear, Disarm, Home, Request
from spiraltrunk.workflows.drive.remote.setup import RobotSetup
from spiraltrunk.workflows.drive.remote.state import RobotState

PLOT_PERIOD = 0.5
"""Time between two pictures of the plots [s] (ours)."""

UNWATCHED = 1.0
"""Time without a watchdog after which its board counts as tripped: a late answer lasts less [s] (ours)."""


@final
class RobotTab:
    """The robot, as one page sees it."""

    name = "robot"
    title = "Robot"

    def __init__(self, page: Page, hub: RobotHub, poses: Path = Path("poses.json")) -> None:
        self._page, self._hub, self._poses = page, hub, poses
        self.name_of_page = f"page {page.client.client_id + 1}"
        self._heartbeat = PageHeartbeat(page.client, lambda asked: hub.take_beat(self._watcher, asked))
        self._watcher = _PageWatcher(self)
        self._is_shown = False
        self._plotted = 0.0
        self._design = page.design
        self._picture: TwinPicture | None = None
        self._camera = aim_at_trunk(page, page.design)

    def build(self) -> None:
        """See `Tab.build`."""
        page, hub = self._page, self._hub
        self._status: Any = page.gui.add_html("")
        self._faults: Any = page.gui.add_html("")
        self._robot = Choice(page, "Robot", hub.robots, hub.robots[0], lambda _: None, hint="The twin is simulated")
        self._buttons: dict[str, Any] = {
            "connect": add_button(page, "Connect", self._connect, hint="Starts the robot's process; nothing moves"),
            "take": add_button(page, "Take control", self._take, hint="One page at a time can move the robot"),
            "clear": add_button(
                page, CLEAR_FAULT, lambda: self._ask(Clear(self.name_of_page)),
                hint="Leads to safe, never to torque", color=(184, 74, 0),
            ),
            "home": add_button(
                page, "Home", lambda: self._ask(Home()), hint="Winds all cables in gently until the trunk is straight"
            ),
            "enable": add_button(
                page, "Enable", self._enable, hint="Switches torque on; all cables follow the trunk, gently"
            ),
            "disable": add_button(
                page, "Disable", lambda: self._ask(Disarm()), hint="Lets the cables go in half a second, then no torque"
            ),
        }  # fmt: skip
        self._moves_folder: Any = page.gui.add_folder("Jog")
        self._build_moves()
        self._table: Any = page.gui.add_html("")
        self._strategy_folder: Any = page.gui.add_folder("Strategy on the twin", expand_by_default=False)
        with self._strategy_folder:
            self._strategy = StrategyControls(page, self._ask)
        self._buttons["release"] = add_button(
            page, "Release control", self._release, hint="Lets the robot go; other pages may take it", color=GRAY
        )
        self._buttons["disconnect"] = add_button(
            page, "Disconnect", self._disconnect, hint="Lets the robot go, and ends its process", color=GRAY
        )
        self._gauges = Gauges(page)
        self._stop = StopPanel(page, hub.stop)
        hub.enter(self._watcher)
        self.draw()

    def show(self) -> None:
        """See `Tab.show`."""
        self._is_shown = True
        self._camera.show()
        self._gauges.renew()
        self.draw()

    def hide(self) -> None:
        """See `Tab.hide`; a robot that is connected keeps its STOP in view."""
        self._is_shown = False
        self._camera.keep()
        self._stop.show(self._hub.is_connected)

    def read_settings(self) -> dict[str, Any]:
        """See `Tab.read_settings`."""
        moves = self._moves
        return {"step_mm": moves.step.value, "tension_n": moves.tension.value, "speed_mm_s": moves.speed.value}

    def apply_settings(self, settings: dict[str, Any]) -> None:
        """See `Tab.apply_settings`; a reload does not take control again."""
        for name, slider in zip(("step_mm", "tension_n", "speed_mm_s"), self._moves.sliders, strict=True):
            if isinstance(settings.get(name), int | float):
                slider.set(settings[name])

    def close(self) -> None:
        """See `Tab.close`: where this page is in control, the robot lets go."""
        self._hub.leave(self._watcher)

    def ask_beat(self) -> None:
        """Ask the browser to answer."""
        self._heartbeat.ask()

    def show_message(self, text: str) -> None:
        """Show a message."""
        self._page.notice(text)

    def update(self) -> None:
        """Draw soon."""
        self._page.later("robot", self.draw)

    def draw(self) -> None:
        """Show the present state."""
        hub, state = self._hub, self._hub.state
        self._follow_design()
        is_mine = hub.is_owner(self._watcher)
        self._stop.show(self._is_shown or hub.is_connected)
        if not self._is_shown:
            return
        with self._page.client.atomic():
            setup = hub.setup
            robot = "" if setup is None else setup.name
            _write(self._status, format_status(state, robot=robot, owner=hub.owner, is_mine=is_mine))
            _write(self._faults, "" if state is None else format_faults(state))
            self._open_buttons(state, is_mine=is_mine)
            self._draw_state(state)

    def _draw_state(self, state: RobotState | None) -> None:
        if state is None:
            _write(self._table, "")
            self._gauges.clear()
            self._find_picture().draw_straight()
            return
        _write(self._table, format_cables(state))
        if time.monotonic() > self._plotted + PLOT_PERIOD:
            self._plotted = time.monotonic()
            self._gauges.draw(self._hub.states)
        self._find_picture().draw(state.frames)

    def _open_buttons(self, state: RobotState | None, *, is_mine: bool) -> None:
        """Show the buttons that apply, and open the controls that do."""
        mode = None if state is None or state.run else state.snapshot.mode
        is_rest = is_mine and mode is Mode.SAFE and state is not None and not state.snapshot.is_letting_go
        is_armed = is_mine and mode is Mode.ARMED and state is not None and not state.snapshot.is_letting_go
        is_homed = state is not None and state.snapshot.is_homed
        is_tripped = is_rest and has_tripped_board(self._hub.setup, self._hub.states)
        shown = {
            "connect": not self._hub.is_connected,
            "take": state is not None and not self._hub.owner,
            "clear": is_mine and (mode is Mode.FAULT or is_tripped),
            "home": is_rest,
            "enable": is_rest and is_homed,
            "disable": is_armed,
            "release": is_mine and state is not None,
            "disconnect": self._hub.is_connected and (is_mine or not self._hub.owner),
        }
        for name, visible in shown.items():
            if self._buttons[name].visible != visible:
                self._buttons[name].visible = visible
        label = CLEAR_STOP if state is not None and is_stop(state) else CLEAR_FAULT
        if self._buttons["clear"].label != label:
            self._buttons["clear"].label = label
        self._robot.handle.visible = not self._hub.is_connected
        self._moves_folder.visible = is_armed
        self._strategy_folder.visible = state is not None and state.is_twin
        self._moves.open(is_armed)
        self._strategy.draw(state, is_open=is_rest, is_mine=is_mine)

    def _connect(self) -> None:
        self._hub.connect(self._watcher, self._robot.value, self._page.design)
        self._moves.send_limits()

    def _take(self) -> None:
        self._hub.take(self._watcher)
        self._moves.send_limits()

    def _release(self) -> None:
        self._hub.release(self._watcher)

    def _disconnect(self) -> None:
        self._hub.disconnect(self._watcher)

    def _enable(self) -> None:
        self._moves.send_limits()
        self._ask(Arm())

    def _ask(self, request: Request) -> None:
        self._hub.ask(self._watcher, request)

    def _follow_design(self) -> None:
        """Controls and picture are those of the robot's design, or of the page's where none is connected."""
        setup = self._hub.setup
        design = self._page.design if setup is None else setup.design
        if design is not self._design:
            self._design = design
            self._build_moves()
            self._camera = aim_at_trunk(self._page, design)
            if self._is_shown:
                self._camera.show()

    def _build_moves(self) -> None:
        for child in tuple(self._moves_folder._children.values()):
            child.remove()
        with self._moves_folder:
            self._moves = MoveControls(self._page, self._design, self._ask)
            PoseControls(self._page, self._design, self._poses, self._ask, self._read_pulls)

    def _read_pulls(self) -> tuple[float, ...]:
        """Present pull of each cable, as the trunk sees it [m].

        Raises:
            StudioError: where the robot is not homed.
        """
        state = self._hub.state
        if state is None or not state.snapshot.is_homed:
            raise StudioError("the lengths of the cables are not known; home the robot first")
        return state.pulls

    def _find_picture(self) -> TwinPicture:
        """The picture of the present design."""
        if self._picture is None or self._picture.design is not self._design:
            if self._picture is not None:
                self._picture.remove()
            self._picture = TwinPicture(self._page, f"/{self.name}/trunk", self._design)
        return self._picture


@final
class _PageWatcher:
    """The page as the hub sees it."""

    def __init__(self, tab: RobotTab) -> None:
        self._tab = tab
        self.name = tab.name_of_page

    def ask_beat(self) -> None:
        """See `Watcher.ask_beat`."""
        self._tab.ask_beat()

    def update(self) -> None:
        """See `Watcher.update`."""
        self._tab.update()

    def show_message(self, text: str) -> None:
        """See `Watcher.show_message`."""
        self._tab.show_message(text)


def has_tripped_board(setup: RobotSetup | None, states: Sequence[RobotState]) -> bool:
    """Whether a board's watchdog is set up that has not let torques through for `UNWATCHED`."""
    if setup is None or not setup.has_board or not states:
        return False
    end = states[-1].snapshot.time
    latest = [state.snapshot for state in states if state.snapshot.time > end - UNWATCHED]
    return len(latest) < len(states) and not any(snapshot.is_watched for snapshot in latest)


def _write(handle: Any, content: str) -> None:
    if handle.content != content:
        handle.content = content
