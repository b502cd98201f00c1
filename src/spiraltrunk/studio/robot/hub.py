"""The robot of a studio: one process, which all pages see and one page at most is in control of."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import Protocol, final

from spiraltrunk.design import TrunkDesign
from spiraltrunk.errors import RunError, StudioError
from spiraltrunk.hardware.setup.robot_file import RobotFile
from spiraltrunk.workflows.drive.remote.link import RobotLink
from spiraltrunk.workflows.drive.remote.requests import Alive, Leave, Request, Stop
from spiraltrunk.workflows.drive.remote.service import PATIENCE
from spiraltrunk.workflows.drive.remote.setup import RobotSetup
from spiraltrunk.workflows.drive.remote.state import RobotState

BEAT_PERIOD = 0.1
"""Time between two questions to the page in control [s] (ours)."""

LINGER = 30.0
"""Time for which the robot stays connected, safe, without any page, so that a reload finds it [s] (ours)."""

MOST_STATES = 300
"""States that are kept for plots: half a minute [-] (ours)."""


class Watcher(Protocol):
    """A page, as the hub calls it; its methods are called from any thread and return at once."""

    name: str
    """What other pages call it."""

    def ask_beat(self) -> None:
        """Ask the page to answer, by `RobotHub.take_beat`."""

    def update(self) -> None:
        """Show what is new."""

    def show_message(self, text: str) -> None:
        """Show a message."""


@final
class RobotHub:
    """The robot and the lock on it.

    Args:
        design: the design of the robot of the file.
        file: how it is wired; None where only the twin can be connected.
        without_watchdog: whether hardware may be armed without a watchdog.
        patience: time after which a page that does not answer counts as gone [s].
        pace: simulated time of the twin over the computer's [-].
    """

    def __init__(
        self,
        design: TrunkDesign,
        file: RobotFile | None = None,
        *,
        without_watchdog: bool = False,
        patience: float = PATIENCE,
        pace: float = 1.0,
    ) -> None:
        self._hardware = (
            None
            if file is None
            else RobotSetup(design=design, file=file, without_watchdog=without_watchdog, patience=patience)
        )
        self._patience, self._pace = patience, pace
        self._lock = threading.RLock()
        self._watchers: list[Watcher] = []
        self._owner: Watcher | None = None
        self._link: RobotLink | None = None
        self._state: RobotState | None = None
        self._heard = 0.0
        self._states: deque[RobotState] = deque(maxlen=MOST_STATES)
        self._lonely_since = time.monotonic()

    @property
    def robots(self) -> tuple[str, ...]:
        """Robots that can be connected, the twin first."""
        return ("twin",) if self._hardware is None else ("twin", self._hardware.name)

    @property
    def is_connected(self) -> bool:
        """Whether there is a robot, or one is being connected."""
        return self._link is not None

    @property
    def setup(self) -> RobotSetup | None:
        """The robot that is connected."""
        link = self._link
        return None if link is None else link.setup

    @property
    def state(self) -> RobotState | None:
        """Its latest state; None before the first."""
        return self._state

    @property
    def silence(self) -> float:
        """Time since its process reported a state [s]; 0 before the first."""
        return 0.0 if self._state is None else time.monotonic() - self._heard

    @property
    def states(self) -> tuple[RobotState, ...]:
        """Its states of the last half minute."""
        with self._lock:
            return tuple(self._states)

    @property
    def owner(self) -> str:
        """Name of the page in control; empty where none is."""
        owner = self._owner
        return "" if owner is None else owner.name

    def is_owner(self, watcher: Watcher) -> bool:
        """Whether this page is in control."""
        return self._owner is watcher

    def enter(self, watcher: Watcher) -> None:
        """A page opens."""
        with self._lock:
            self._watchers.append(watcher)

    def leave(self, watcher: Watcher) -> None:
        """A page is closed: where it was in control, the robot lets go at once; harmless when called again."""
        with self._lock:
            if watcher in self._watchers:
                self._watchers.remove(watcher)
            self._lonely_since = time.monotonic()
            if self._owner is watcher:
                self._drop_owner()
        self._notify()

    def connect(self, watcher: Watcher, robot: str, design: TrunkDesign) -> None:
        """Connect a robot, and take control of it.

        Args:
            watcher: the page.
            robot: one of `robots`.
            design: design of the twin.

        Raises:
            StudioError: where one is connected, or the name is none.
        """
        with self._lock:
            if self._link is not None:
                raise StudioError(f"the {self._link.setup.name} is connected already; take control of it")
            setup = self._choose(robot, design)
            self._state, self._owner = None, watcher
            self._states.clear()
            link = self._link = RobotLink(
                setup, on_state=self._take_state, on_refusal=self._refuse, on_end=lambda reason: self._end(link, reason)
            )
            link.start()
            threading.Thread(target=self._beat, args=(link,), name="heartbeat", daemon=True).start()
        self._notify()

    def disconnect(self, watcher: Watcher) -> None:
        """Let the robot go, and end its process.

        Raises:
            StudioError: where another page is in control.
        """
        with self._lock:
            if self._owner is not None and self._owner is not watcher:
                raise StudioError(f"{self._owner.name} is in control; it alone can disconnect the robot")
            if self._link is not None:
                self._link.close()

    def take(self, watcher: Watcher) -> None:
        """Take control.

        Raises:
            StudioError: where another page has it, or there is no robot.
        """
        with self._lock:
            if self._link is None:
                raise StudioError("no robot is connected; connect one first")
            if self._owner is not None and self._owner is not watcher:
                raise StudioError(f"{self._owner.name} is in control; it can release it, or be closed")
            self._owner = watcher
        self._notify()

    def release(self, watcher: Watcher) -> None:
        """Give control back; the robot lets go."""
        with self._lock:
            if self._owner is watcher:
                self._drop_owner()
        self._notify()

    def ask(self, watcher: Watcher, request: Request) -> None:
        """Send a request of the page in control.

        Raises:
            StudioError: of another page.
            DriveError: for a value out of its range; nothing is sent then.
            RunError: without a robot.
        """
        with self._lock:
            if self._link is None:
                raise RunError("no robot is connected; connect one first")
            if self._owner is not watcher:
                whose = "another page is" if self._owner is not None else "no page is"
                raise StudioError(f"{whose} in control of the robot; this one can watch, and press STOP")
            self._link.ask(request, watcher.name)

    def stop(self) -> None:
        """Stop the robot; for every page, never refused.

        Raises:
            RunError: where no robot is connected.
        """
        link = self._link
        if link is None:
            raise RunError("no robot is connected, so nothing was stopped")
        link.ask(Stop())

    def take_beat(self, watcher: Watcher, asked: float) -> None:
        """A page answered what it was asked at a time of `time.monotonic` [s]."""
        with self._lock, suppress(RunError):
            if self._owner is watcher and self._link is not None:
                self._link.ask(Alive(asked))

    def close(self) -> None:
        """Let the robot go, and wait until its process has ended; harmless when called again."""
        link = self._link
        if link is not None:
            link.close()
            link.join()

    def _choose(self, robot: str, design: TrunkDesign) -> RobotSetup:
        if robot == "twin":
            return RobotSetup(design=design, patience=self._patience, pace=self._pace)
        if self._hardware is None or robot != self._hardware.name:
            raise StudioError(f"robot is {robot[:80]!r}; allowed: {', '.join(self.robots)}")
        return self._hardware

    def _drop_owner(self) -> None:
        self._owner = None
        if self._link is not None:
            with suppress(RunError):
                self._link.ask(Leave())

    def _beat(self, link: RobotLink) -> None:
        """Ask the page in control again and again, and close a robot that no page watches."""
        resting = threading.Event()
        while self._link is link:
            owner = self._owner
            if owner is not None:
                owner.ask_beat()
            with self._lock:
                is_lonely = not self._watchers and time.monotonic() - self._lonely_since > LINGER
            if is_lonely:
                link.close()
                return
            resting.wait(BEAT_PERIOD)

    def _take_state(self, state: RobotState) -> None:
        with self._lock:
            if self._state is not None and _has_other_clock(self._state, state):
                self._states.clear()
            self._state, self._heard = state, time.monotonic()
            self._states.append(state)
        self._notify()

    def _refuse(self, asker: str, text: str) -> None:
        self._call(lambda one: one.show_message(text) if one.name == asker else None)

    def _end(self, link: RobotLink, reason: str | None) -> None:
        with self._lock:
            if self._link is not link:
                return
            self._link = self._owner = self._state = None
        if reason is not None:
            self._call(lambda one: one.show_message(f"the robot is disconnected: {reason}"))
        self._notify()

    def _notify(self) -> None:
        self._call(lambda one: one.update())

    def _call(self, act: Callable[[Watcher], None]) -> None:
        with self._lock:
            watchers = tuple(self._watchers)
        for one in watchers:
            act(one)


def _has_other_clock(before: RobotState, now: RobotState) -> bool:
    """Whether the clock is another one: that of a strategy's own twin, or after it that of the twin before."""
    return now.snapshot.time < before.snapshot.time or (bool(before.run) and not now.run)
