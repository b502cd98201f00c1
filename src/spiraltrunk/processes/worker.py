"""Main function of a worker process.

The processes of `multiprocessing` print a traceback where their parent dies as they start, and live on where it dies as
they work. This one ends as soon as the parent's end of its pipe is closed, which the kernel does at any death.
"""

from __future__ import annotations

import os
import pickle
import select
import threading
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection
from multiprocessing.spawn import prepare
from typing import Any

from spiraltrunk.processes.parent_death import end_with_parent

READY = "ready"
"""Message of a process that has imported its work."""

is_importing_main = False
"""Whether this process imports the main module of its parent."""


def serve(number: int, parent: int, *, is_main: bool) -> None:
    """Work until the other end of the pipe is closed; never returns.

    The parent sends what `multiprocessing.spawn` prepares the main module with, the work, and then the jobs. The answer
    to each is its result, and the exception's text and the exception itself where it has raised one.

    Args:
        number: descriptor of the pipe.
        parent: process that holds its other end.
        is_main: whether the main thread of the parent started this process.
    """
    _end_with(parent, number, is_main)
    with suppress(OSError):
        os.dup2(2, 1)  # Standard output is reserved for the command's result.
    pipe: Connection = Connection(number)
    _import_main(_receive(pipe))
    work = _receive(pipe)
    _send(pipe, READY)
    while True:
        _send(pipe, attempt(work, _receive(pipe)))


def format_error(error: Exception, most: int = 300) -> str:
    """An exception in one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())[:most]


def _end_with(parent: int, number: int, is_main: bool) -> None:
    """End this process at once when its parent ends.

    A thread sees the pipe's other end closed. It waits for Python's lock, which a geometry kernel may hold for long;
    Linux therefore kills the process as well.
    """
    threading.Thread(target=_wait_for_close, args=(number,), daemon=True).start()
    if is_main and not end_with_parent(parent):  # At the end of another thread the parent may live on.
        os._exit(0)


def _wait_for_close(number: int) -> None:
    poll = select.poll()
    poll.register(number, 0)  # Reports a closed end alone, which is always reported.
    if poll.poll()[0][1] & (select.POLLHUP | select.POLLERR):  # Else this process ends by itself and has closed it.
        os._exit(0)


def _import_main(data: dict[str, Any]) -> None:
    global is_importing_main  # noqa: PLW0603
    is_importing_main = True
    prepare(data)
    is_importing_main = False


def _receive(pipe: Connection) -> Any:
    try:
        message = pipe.recv_bytes()
    except (EOFError, OSError):
        os._exit(0)
    return pickle.loads(message)


def _send(pipe: Connection, message: object) -> None:
    try:
        pipe.send(message)
    except (EOFError, OSError):
        os._exit(0)


def attempt(work: Callable[[Any], object], job: object) -> tuple[object, str | None, Exception | None]:
    """Result of the work; where it raises, the exception in one line, and itself where it can be sent."""
    try:
        return work(job), None, None
    except Exception as error:
        return None, format_error(error), error if _can_be_sent(error) else None


def _can_be_sent(error: Exception) -> bool:
    try:
        return type(pickle.loads(pickle.dumps(error))) is type(error)
    except Exception:  # Its constructor takes other arguments than its text.
        return False
