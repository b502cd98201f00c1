"""The board's side of the watchdog, as its firmware has to do it: pure, so that twin and firmware can be compared."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.safety.watchdog import CLEAR_FLAG, END_FLAG, HEARTBEAT_FORMAT, RELEASE, TIMEOUT, BoardMode


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class BoardWatch:
    """What the board remembers."""

    mode: BoardMode = BoardMode.WAITING
    """What it does."""
    heard: float = 0.0
    """When the last heartbeat came [s]."""
    tripped: float = 0.0
    """When it tripped [s]."""
    counter: int = -1
    """Counter of the last heartbeat; -1 before the first."""


def hear(watch: BoardWatch, data: bytes, now: float) -> BoardWatch:
    """The board after a frame `HEARTBEAT_ID`; one of another length, or with the same counter, is no heartbeat.

    One with `END_FLAG` is the last one of a host that ends in order: a board that has not tripped waits for the next.
    """
    if len(data) != HEARTBEAT_FORMAT.size:
        return watch
    counter, flags = HEARTBEAT_FORMAT.unpack(data)
    if counter == watch.counter:
        return watch
    watch = advance(watch, now)
    if flags & END_FLAG:
        mode = BoardMode.TRIPPED if watch.mode is BoardMode.TRIPPED else BoardMode.WAITING
        return BoardWatch(mode=mode, heard=now, tripped=watch.tripped, counter=counter)
    is_passing = watch.mode is not BoardMode.TRIPPED or bool(flags & CLEAR_FLAG)
    mode = BoardMode.WATCHING if is_passing else BoardMode.TRIPPED
    return BoardWatch(mode=mode, heard=now, tripped=watch.tripped, counter=counter)


def advance(watch: BoardWatch, now: float) -> BoardWatch:
    """The board at ``now`` [s], tripped where no heartbeat came for `TIMEOUT`."""
    if watch.mode is not BoardMode.WATCHING or now - watch.heard < TIMEOUT:
        return watch
    return BoardWatch(mode=BoardMode.TRIPPED, heard=watch.heard, tripped=watch.heard + TIMEOUT, counter=watch.counter)


def pass_share(watch: BoardWatch, now: float) -> float:
    """Part of the last commanded torque that the board lets through at ``now`` [s], 0 to 1 [-].

    It falls linearly from 1 to 0 within `RELEASE` after the trip, and the board takes no new torque from then on.
    """
    if watch.mode is BoardMode.WATCHING:
        return 1.0
    if watch.mode is BoardMode.WAITING:
        return 0.0
    return max(0.0, 1.0 - (now - watch.tripped) / RELEASE)


def answer(watch: BoardWatch) -> bytes:
    """Content of the board's answer `ANSWER_ID`: the counter that it saw, and its mode."""
    return HEARTBEAT_FORMAT.pack(max(0, watch.counter), watch.mode)
