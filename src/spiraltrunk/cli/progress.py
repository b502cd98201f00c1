"""What is being done, told while it is done."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TextIO

Tell = Callable[[str, int, int], None]
"""Called with what is being done, how much of it is done and how much there is."""


@contextmanager
def show_progress(stream: TextIO) -> Iterator[Tell]:
    """A function to call with what is being done, how much of it is done and how much there is.

    On a terminal it draws a bar, elsewhere it says each new thing in one line.
    """
    if not stream.isatty():
        yield _speak_once(stream)
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description:<12}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(file=stream), transient=True) as bar:
        task = bar.add_task("starting", total=None)

        def show(what: str, done: int, total: int) -> None:
            bar.update(task, description=what, completed=done, total=total or None)

        yield show


def _speak_once(stream: TextIO) -> Tell:
    last = ""

    def say(what: str, done: int, total: int) -> None:
        nonlocal last
        if what != last:
            last = what
            print(f"spiraltrunk: {what}", file=stream, flush=True)

    return say
