"""The robot on the terminal: lengths, tensions, temperatures and state, while it runs."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TextIO

from spiraltrunk.cli.progress import print_progress
from spiraltrunk.cli.verbs.drive.figures import format_figure

if TYPE_CHECKING:
    from spiraltrunk.hardware.driver.snapshot import Snapshot
    from spiraltrunk.hardware.driver.threaded_driver import Driver
    from spiraltrunk.workflows.drive.robot import Robot, Watch

_WIDE = 68
"""Width of a terminal from which on titles are written out [columns]."""

_TITLES = ("cable", "pull [mm]", "tension [N]", "of [N]", "motor [degC]", "age [ms]")
_NARROW_TITLES = ("", "mm", "N", "of N", "degC", "ms old")

_REFRESH = 0.1
"""Wall time between two pictures [s]."""


@contextmanager
def show_robot(robot: Robot, stream: TextIO | None) -> Iterator[None]:
    """Show the robot until the block ends: a table on a terminal, elsewhere one line for each new mode."""
    if stream is None or not stream.isatty():
        modes: list[str] = []

        def tell(driver: Driver) -> None:
            if driver.mode.value not in modes[-1:]:
                modes.append(driver.mode.value)
                print_progress(driver.mode.value, stream)

        with _watch(robot, tell):
            yield
        return
    from rich.console import Console
    from rich.live import Live

    console = Console(file=stream)
    began = robot.clock.now()
    with Live(console=console, transient=True, auto_refresh=False) as live:
        shown = [0.0]

        def draw(driver: Driver) -> None:
            if time.monotonic() >= shown[0] + _REFRESH:
                shown[0] = time.monotonic()
                live.update(draw_table(driver.snapshot(), console.width, began=began), refresh=True)

        with _watch(robot, draw):
            yield


@contextmanager
def _watch(robot: Robot, watch: Watch) -> Iterator[None]:
    """Call ``watch`` while the block runs, and not while the robot lets go after it."""
    robot.watch = watch
    try:
        yield
    finally:
        robot.watch = None


def draw_table(snapshot: Snapshot, width: int = 80, *, began: float = 0.0) -> Any:
    """The robot's state for a terminal of so many columns: its mode, one line a cable, faults and warnings.

    ``began`` is the time of the robot's clock at which the command began [s]; the time shown is counted from it.
    """
    from rich.console import Group
    from rich.text import Text

    state = "letting go" if snapshot.is_letting_go else snapshot.mode.value
    head = Text(f"{state}, {max(snapshot.time - began, 0.0):.1f} s", style="bold")
    return Group(
        head, _build_rows(snapshot, is_narrow=width < _WIDE), *_describe_cells(snapshot),
        _describe_loop(snapshot, width), *_list_trouble(snapshot),
    )  # fmt: skip


def _build_rows(snapshot: Snapshot, *, is_narrow: bool) -> Any:
    """Table of the cables, which needs 36 columns where it is narrow, else 65."""
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, padding=(0, 1 if is_narrow else 2, 0, 0), pad_edge=False)
    for title in _NARROW_TITLES if is_narrow else _TITLES:
        table.add_column(Text(title), justify="right", no_wrap=True)
    for number, cable in enumerate(snapshot.cables, start=1):
        pull = format_figure(1e3 * cable.pull, 1) if snapshot.is_homed else "-"
        tensions = (format_figure(figure, 1) for figure in (cable.tension, cable.tension_target))
        rest = (format_figure(figure, 0) for figure in (cable.temperature, 1e3 * cable.feedback_age))
        table.add_row(str(number), pull, *tensions, *rest)
    return table


def _describe_cells(snapshot: Snapshot) -> list[Any]:
    """Which tensions are measured by load cells, and how old their readings are; nothing without any."""
    from rich.text import Text

    ages = [(i, cable.cell_age) for i, cable in enumerate(snapshot.cables, start=1) if cable.cell_age is not None]
    told = ", ".join(f"{i} ({format_figure(1e3 * age, 0)} ms)" for i, age in ages)
    return [Text(f"load cells: {told}")] if ages else []


def _describe_loop(snapshot: Snapshot, width: int) -> Any:
    """How late the loop woke, at three quantiles."""
    from rich.text import Text

    lateness = snapshot.lateness
    late = "/".join(f"{1e3 * part:.1f}" for part in (lateness.p50, lateness.p99, lateness.p999))
    return Text(f"late {late} ms" if width < _WIDE else f"loop late {late} ms (p50/p99/p99.9)")


def _list_trouble(snapshot: Snapshot) -> list[Any]:
    """Faults and warnings."""
    from rich.text import Text

    faults = [Text(f"{fault.kind.value}: {fault.text}", style="red") for fault in snapshot.faults]
    return [*faults, *(Text(warning, style="yellow") for warning in snapshot.warnings)]
