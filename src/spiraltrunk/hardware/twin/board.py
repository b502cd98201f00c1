"""Watchdog between bus and motors: a twin of the board that lets commands pass while the host's heartbeats come."""

from __future__ import annotations

from typing import final

from spiraltrunk.hardware.bus.frame_bus import Frame
from spiraltrunk.hardware.safety.watchdog import ANSWER_ID, BoardMode
from spiraltrunk.hardware.safety.watches.board_watch import BoardWatch, advance, answer, hear, pass_share


@final
class BoardTwin:
    """A board with the watchdog of `safety.board_watch`; no such board was ever tried."""

    def __init__(self) -> None:
        self._watch = BoardWatch()

    @property
    def mode(self) -> BoardMode:
        """What the board does."""
        return self._watch.mode

    @property
    def is_open(self) -> bool:
        """Whether it takes new commands."""
        return self._watch.mode is BoardMode.WATCHING

    def hear(self, data: bytes, now: float) -> Frame:
        """Take a heartbeat with this content at ``now`` [s], and return the answer."""
        self._watch = hear(self._watch, data, now)
        return Frame(ANSWER_ID, answer(self._watch))

    def compute_share(self, now: float) -> float:
        """Part of the last command that passes at ``now`` [s], 0 to 1 [-]."""
        watch = self._watch
        if watch.mode is BoardMode.WATCHING:
            watch = self._watch = advance(watch, now)
        return pass_share(watch, now)
