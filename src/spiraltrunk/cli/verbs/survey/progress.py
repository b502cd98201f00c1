"""Progress of a survey: a bar for each strategy on a terminal, else a line for each trial."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, TextIO

from spiraltrunk.cli.progress import print_progress

Watch = Callable[[Sequence[Mapping[str, Any]]], None]
"""Called with all rows so far."""


@contextmanager
def show_survey(stream: TextIO | None, trials: Mapping[str, int]) -> Iterator[Watch]:
    """A callback for all rows so far, before the first trial and after each.

    Args:
        stream: where to show it.
        trials: number of trials of each strategy.
    """
    if stream is None or not stream.isatty():
        yield _build_line_printer(stream, sum(trials.values()))
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[count]}"),
        TimeElapsedColumn(), TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=Console(file=stream), transient=True) as bars:
        tasks = {name: bars.add_task(name, total=total, count="") for name, total in trials.items()}

        def show(rows: Sequence[Mapping[str, Any]]) -> None:
            for name, task in tasks.items():
                own = [row["success"] for row in rows if row["strategy"] == name]
                bars.update(task, completed=len(own), count=f"{sum(own)} succeeded")

        yield show


def _build_line_printer(stream: TextIO | None, total: int) -> Watch:
    is_first = True

    def print_line(rows: Sequence[Mapping[str, Any]]) -> None:
        nonlocal is_first
        head = f"{len(rows)}/{total}"
        if is_first:
            is_first = False
            text = f"{head} trials are there already" if rows else f"{head} trials"
        else:
            row = rows[-1]
            own = [other["success"] for other in rows if other["strategy"] == row["strategy"]]
            what = f"{row['strategy']}, {row['object']}, seed {row['seed']}: {row['reason']}"
            text = f"{head} {what} ({sum(own)} of {len(own)} succeeded)"
        print_progress(text, stream)

    return print_line
