"""Plots of the cables, from the states of the last half minute."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, final

import numpy as np

from spiraltrunk.report.style import COLORS
from spiraltrunk.studio.drawing.plot_lines import DASHES, label_axes
from spiraltrunk.studio.page.page import Page
from spiraltrunk.workflows.drive.remote.state import RobotState

_HEIGHT = 150
"""Height of a plot [px]."""

_SHOWN = 30.0
"""Time that plots show [s]."""


@final
class Gauges:
    """Plots of lengths, tensions and temperatures."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._n_cable = 0
        self._folder: Any = page.gui.add_folder("Plots of the last 30 s")
        self._plots: list[Any] = []

    def clear(self) -> None:
        """Show nothing."""
        self._folder.visible = False

    def draw(self, states: Sequence[RobotState]) -> None:
        """Show the latest states."""
        if not states:
            return
        count = len(states[-1].goals)
        if count != self._n_cable:
            self._build(count)
        self._folder.visible = True
        time = np.array([state.snapshot.time for state in states])
        for plot, values in zip(self._plots, _collect(states, count), strict=True):
            plot.data = (time - time[-1], *values.T)

    def _build(self, count: int) -> None:
        for plot in self._plots:
            plot.remove()
        self._n_cable = count
        with self._folder:
            self._plots = [
                self._add(title, count) for title in ("Length [mm]", "Tension [N]", "Temperature of motors [°C]")
            ]

    def _add(self, title: str, count: int) -> Any:
        colors = [COLORS[i % len(COLORS)] for i in range(count)]
        series: list[Any] = [{"label": "time [s]"}]
        series += [
            {"label": f"cable {i + 1}", "stroke": color, "width": 2, "dash": DASHES[i % len(DASHES)]}
            for i, color in enumerate(colors)
        ]
        empty = tuple(np.zeros(2) for _ in range(count + 1))
        return self._page.gui.add_uplot(
            empty, tuple(series), title=title, height=_HEIGHT, scales={"x": {"time": False, "range": (-_SHOWN, 0.0)}},
            legend={"show": False}, padding=(14, 10, 0, 0), axes=label_axes("Time before now [s]", ""),
        )  # fmt: skip


def _collect(states: Sequence[RobotState], count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lengths [mm], tensions [N] and temperatures [°C], shape (n_state, n_cable)."""
    rows = [state.snapshot.cables for state in states]
    pull = np.array([[1e3 * cable.pull for cable in row] for row in rows])
    tension = np.array([[cable.tension for cable in row] for row in rows])
    temperature = np.array([[cable.temperature for cable in row] for row in rows])
    return pull[:, :count], tension[:, :count], temperature[:, :count]
