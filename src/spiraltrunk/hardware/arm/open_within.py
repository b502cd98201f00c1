"""Opening a connection within a bounded time, where a library itself waits for minutes."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TypeVar

from spiraltrunk.errors import DriveError

_T = TypeVar("_T")

CONNECT_TIME = 5.0
"""Longest wait for an arm [s] (ours); libfranka itself waits 60 s for a robot that is off."""


def open_within(seconds: float, name: str, connect: Callable[[], _T]) -> _T:
    """What ``connect`` returns, unless it takes longer than ``seconds`` [s].

    A connection that comes later is dropped at once, as nobody holds it.

    Raises:
        DriveError: with the device's ``name``, and what to do, where it cannot be reached in time.
    """
    made: list[_T] = []
    failed: list[Exception] = []

    def run() -> None:
        try:
            made.append(connect())
        except Exception as error:  # Drivers' libraries raise errors of many classes.
            failed.append(error)

    thread = threading.Thread(target=run, name=f"connect {name}", daemon=True)
    thread.start()
    thread.join(seconds)
    what = "is it on, its brakes open, FCI active in Desk, and the network cable in the control box?"
    if failed:
        raise DriveError(f"{name} cannot be reached: {failed[0]}; {what}") from failed[0]
    if not made:
        raise DriveError(f"{name} does not answer within {seconds:g} s; {what}")
    return made[0]
