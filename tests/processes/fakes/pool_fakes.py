"""Work that takes no time, in a module that processes can import."""

from __future__ import annotations

import os
import signal
import sys
import time
from typing import Any


def double(number: int) -> int:
    return 2 * number


def raise_second(number: int) -> int:
    if number == 1:
        raise ValueError(f"no plan\nfor seed {number}")
    return number


def die_second(number: int) -> int:
    if number == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def hang_after_third(number: int) -> int:
    if number >= 3:
        time.sleep(600)
    return number


def tell_threads(name: str) -> str | None:
    print("what a library prints", flush=True)
    return os.environ.get(name)


def shout(job: object) -> object:
    """Ended by a signal of the terminal, if any could reach it."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        os.kill(os.getpid(), number)
    return job


class Unreadable:
    """A job or function that a process cannot take over."""

    def __reduce__(self) -> tuple[Any, ...]:
        return sys.exit, (3,)

    def __call__(self, job: object) -> object:
        return job


class UnpicklableError(Exception):
    """Cannot be made anew from its text."""

    def __init__(self, first: str, second: str) -> None:
        super().__init__(f"{first} {second}")


def raise_unpicklable(job: str) -> None:
    raise UnpicklableError("not to be", "sent")
