"""Progress of a command on standard error."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TextIO

SLOW = 5.0
"""Time after which work is told that seldom takes as long [s]."""


@contextmanager
def show_progress(stream: TextIO | None) -> Iterator[Callable[[str, int, int], None]]:
    """A `files.results.Progress` callback: a bar on a terminal, elsewhere one line for each new step.

    Standard error that is closed, None where it is from the start, ends no command.
    """
    if stream is None or not stream.isatty():
        steps: list[str] = []

        def print_step(step: str, done: int, total: int) -> None:
            if step not in steps[-1:]:
                steps.append(step)
                print_progress(step, stream)

        yield print_step
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description:<12}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(file=stream), transient=True) as bar:
        task = bar.add_task("starting", total=None)
        yield lambda step, done, total: bar.update(task, description=step, completed=done, total=total or None)


@contextmanager
def print_if_slow(what: str, stream: TextIO | None) -> Iterator[None]:
    """Print a line on what is done where that takes longer than `SLOW`."""
    timer = threading.Timer(SLOW, print_progress, (f"{what} ...", stream))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def print_progress(line: str, stream: TextIO | None) -> None:
    """Print a line of progress where there is somebody to read it."""
    if stream is not None:
        with suppress(OSError):
            print(f"spiraltrunk: {line}", file=stream, flush=True)
