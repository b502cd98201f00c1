"""Clock of the timeline: plays frames in real time."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import final

from spiraltrunk.studio.page.page import Page
from spiraltrunk.workflows.grasp.recording import RATE


@final
class Player:
    """Calls ``show`` in the page's thread with the number of the frame whose time has come.

    Where the page is slower than the clock, frames are left out and the time is kept.
    """

    def __init__(self, page: Page, show: Callable[[int], None], on_end: Callable[[], None]) -> None:
        self._page = page
        self._show = show
        self._on_end = on_end
        self._playing: threading.Event | None = None

    @property
    def is_playing(self) -> bool:
        """Whether it plays."""
        return self._playing is not None

    def play(self, first: int, count: int) -> None:
        """Play from a frame to the last of ``count``."""
        self.pause()
        stopped = self._playing = threading.Event()
        began = time.monotonic() - first / RATE

        def tick() -> None:
            if stopped.is_set():
                return
            index = int((time.monotonic() - began) * RATE)
            self._show(min(index, count - 1))
            if index >= count - 1:
                self.pause()
                self._on_end()

        def run() -> None:
            due = time.monotonic()
            while not stopped.is_set() and not self._page.is_closed:
                self._page.later("grasp frame", tick)
                due += 1.0 / RATE
                stopped.wait(max(0.0, due - time.monotonic()))

        threading.Thread(target=run, name="studio player", daemon=True).start()

    def pause(self) -> None:
        """Stop where it is."""
        if self._playing is not None:
            self._playing.set()
            self._playing = None
