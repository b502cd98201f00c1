"""The robot on the terminal: lengths, tensions, temperatures and state, while it runs."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TextIO

from spiraltrunk.cli.progress import print_progress

if TYPE_CHECKING:
    from spiraltrunk.hardware.driver.snapshot import Snapshot
    from spiraltrunk.hardware.driver.threaded_driver import Driver
    from spiraltrunk.workflows.drive.robot import Robot

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

        robot.watch = tell
        yield
        return
    from rich.console import Console
    from rich.live import Live

    with Live(console=Console(file=stream), transient=True, auto_refresh=False) as live:
        shown = [0.0]

        def draw(driver: Driver) -> None:
            if time.monotonic() >= shown[0] + _REFRESH:
                shown[0] = time.monotonic()
                live.update(draw_table(driver.snapshot()), refresh=True)

        robot.watch = draw
        yield


def draw_table(snapshot: Snapshot) -> Any:
    """The robot's state as a table for the terminal."""
    from rich.table import Table

    lateness = snapshot.lateness
    state = "letting go" if snapshot.is_letting_go else snapshot.mode.value
    late = " / ".join(f"{1e3 * part:.1f}" for part in (lateness.p50, lateness.p99, lateness.p999))
    late = f"loop late by {late} ms (p50 / p99 / p99.9)"
    table = Table(title=f"{state}, {snapshot.time:.1f} s, {late}", caption=_describe_trouble(snapshot))
    for title in ("cable", "pull [mm]", "tension [N]", "of [N]", "motor [degC]", "age [ms]"):
        table.add_column(title, justify="right")
    for number, cable in enumerate(snapshot.cables, start=1):
        figures = (cable.tension, cable.tension_target, cable.temperature, 1e3 * cable.feedback_age)
        pull = f"{1e3 * cable.pull:.1f}" if snapshot.is_homed else "-"
        table.add_row(str(number), pull, *(f"{figure:.1f}" if math.isfinite(figure) else "-" for figure in figures))
    return table


def _describe_trouble(snapshot: Snapshot) -> str:
    """Faults and warnings, one a line."""
    return "\n".join([*(f"{fault.kind.value}: {fault.text}" for fault in snapshot.faults), *snapshot.warnings])
