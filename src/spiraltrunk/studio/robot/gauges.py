"""Plots of the cables, from the states of the last half minute."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, final

import numpy as np

from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.report.style import COLORS
from spiraltrunk.studio.drawing.axis_end import round_up
from spiraltrunk.studio.drawing.plot_lines import DASHES, label_axes
from spiraltrunk.studio.page.page import Page
from spiraltrunk.workflows.drive.remote.state import RobotState

_HEIGHT = 150
"""Height of a plot [px]."""

_SHOWN = 30.0
"""Time that plots show [s]."""

_PLOTS = (("Pulled in [mm]", -5.0, 5.0), ("Tension [N]", 0.0, 5.0), ("Temperature of motors [°C]", 0.0, 50.0))
"""Title of each plot, and the ends that its scale has at least, so that noise at rest is not drawn as a move."""


SETTLED = 3
"""Times that a plot is drawn after it was laid out, upon which its scale is sent again: viser lays a plot out without
a width first, and loses the axis of the time where data arrive meanwhile [-] (ours)."""


@final
class Gauges:
    """Plots of lengths, tensions and temperatures."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._n_cable = 0
        self._folder: Any = page.gui.add_folder("Plots of the last 30 s")
        self._plots: list[Any] = []
        self._ends: list[tuple[float, float]] = []
        self._n_drawn = 0

    def renew(self) -> None:
        """The plots are laid out anew, as when their tab is shown."""
        self._n_drawn = 0

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
        self._n_drawn += 1
        time = np.array([state.snapshot.time for state in states])
        for i, values in enumerate(collect_values(states, count)):
            ends = find_ends(values, *_PLOTS[i][1:])
            if ends != self._ends[i] or self._n_drawn == SETTLED:
                self._ends[i], self._plots[i].scales = ends, _scale(ends)
            self._plots[i].data = (time - time[-1], *values.T)

    def _build(self, count: int) -> None:
        for plot in self._plots:
            plot.remove()
        self._n_cable = count
        self.renew()
        self._ends = [(least, most) for _, least, most in _PLOTS]
        with self._folder:
            self._plots = [self._add(title, count, (least, most)) for title, least, most in _PLOTS]

    def _add(self, title: str, count: int, ends: tuple[float, float]) -> Any:
        colors = [COLORS[i % len(COLORS)] for i in range(count)]
        series: list[Any] = [{"label": "time [s]"}]
        series += [
            {"label": f"cable {i + 1}", "stroke": color, "width": 2, "dash": DASHES[i % len(DASHES)]}
            for i, color in enumerate(colors)
        ]
        empty = (np.array([-_SHOWN, 0.0]), *(np.zeros(2) for _ in range(count)))  # Without a span, no axis is drawn.
        return self._page.gui.add_uplot(
            empty, tuple(series), title=title, height=_HEIGHT, scales=_scale(ends),
            legend={"show": False}, padding=(14, 10, 0, 0), axes=label_axes("Time before now [s]", ""),
        )  # fmt: skip


def find_ends(values: np.ndarray, least: float, most: float) -> tuple[float, float]:
    """Ends of a scale: ``least`` and ``most``, and beyond them 1, 2 or 5 times a power of ten where values are."""
    seen = values[np.isfinite(values)]
    low, high = float(seen.min(initial=least)), float(seen.max(initial=most))
    return (least if low >= least else -round_up(-low, 1.0)), (most if high <= most else round_up(high, 1.0))


def _scale(ends: tuple[float, float]) -> Any:
    return {"x": {"time": False, "range": (-_SHOWN, 0.0)}, "y": {"range": ends}}


def collect_values(states: Sequence[RobotState], count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pulls without slack [mm], tensions [N] and temperatures [°C], shape (n_state, n_cable).

    No pull is known before homing, and no tension while the torque is off.
    """
    rows = [state.snapshot.cables for state in states]
    pull = 1e3 * np.array([state.pulls for state in states])
    pull[[not state.snapshot.is_homed for state in states]] = np.nan
    tension = np.array([[cable.tension for cable in row] for row in rows])
    tension[[state.snapshot.mode is not Mode.ARMED for state in states]] = np.nan
    temperature = np.array([[cable.temperature for cable in row] for row in rows])
    return pull[:, :count], tension[:, :count], temperature[:, :count]
