"""Plots of a grasp over time, with a line at the time that is shown."""

from __future__ import annotations

from typing import Any, final

import numpy as np

from spiraltrunk.report.style import COLORS
from spiraltrunk.studio.drawing.plot_lines import DASHES, label_axes
from spiraltrunk.studio.page.page import Page
from spiraltrunk.workflows.grasp.recording import Frames

POINTS = 250
"""Largest number of points of a curve that is sent [-]."""

MARK = "#888888"
"""Colour of the line at the time that is shown."""

_ZERO = "Rise: height of the object's centre above its place at the start, in all phases, not the lift alone."
"""What the rise in the plots is measured from."""


@final
class CoursePlots:
    """Cable tensions, height of the object and grip force of the frames so far."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._folder: Any = page.gui.add_folder("Course", visible=False)
        with self._folder:
            page.gui.add_markdown(_ZERO)
        self._plots: list[Any] = []
        self._curves: list[list[np.ndarray]] = []
        self._time = np.zeros(0)

    def clear(self) -> None:
        """Show nothing."""
        self._folder.visible = False
        self._time = np.zeros(0)

    def draw(self, frames: Frames, index: int) -> None:
        """Draw all frames, with the line at one of them."""
        if len(frames) < 2:
            return
        n = frames.tension.shape[1]
        if len(self._plots) != 3 or len(self._curves[0]) != n:
            self._build(n)
        shown = np.unique(np.linspace(0, len(frames) - 1, min(POINTS, len(frames))).round().astype(int))
        self._time = frames.time[shown]
        self._curves = [
            [frames.tension[shown, cable] for cable in range(n)],
            [1e3 * (frames.height[shown] - frames.height[0])],
            [frames.grip_force[shown]],
        ]
        self._folder.visible = True
        self.mark(float(frames.time[index]))

    def mark(self, time: float) -> None:
        """Move the line to a time [s]."""
        if not len(self._time):
            return
        at = int(np.searchsorted(self._time, time, side="right"))
        for plot, curves in zip(self._plots, self._curves, strict=True):
            low, high = min(float(c.min()) for c in curves), max(float(c.max()) for c in curves)
            line = np.full(len(self._time) + 3, low)  # A line along the lowest value, and a peak at this time.
            line[at + 1] = high
            now = (np.interp(time, self._time, curve) for curve in curves)
            columns = (np.insert(curve, at, [value] * 3) for curve, value in zip(curves, now, strict=True))
            plot.data = (np.insert(self._time, at, [time] * 3), line, *columns)

    def _build(self, n_cable: int) -> None:
        for plot in self._plots:
            plot.remove()
        cables = tuple(f"cable {cable + 1}" for cable in range(n_cable))
        with self._folder:
            self._plots = [
                self._add("Cable tension [N]", cables),
                self._add("Rise of the object [mm]", ("rise",)),
                self._add("Grip force [N]", ("force",)),
            ]
        self._curves = [[np.zeros(2)] * n_cable, [np.zeros(2)], [np.zeros(2)]]

    def _add(self, title: str, labels: tuple[str, ...]) -> Any:
        series: list[Any] = [{"label": "time [s]"}]
        series.append({"label": "now", "stroke": MARK, "width": 1, "points": {"show": False}})
        for i, label in enumerate(labels):
            color, dash = COLORS[i % len(COLORS)], DASHES[i % len(DASHES)]
            series.append({"label": label, "stroke": color, "width": 2, "dash": dash, "points": {"show": False}})
        empty = (np.array([0.0, 1.0]), *(np.zeros(2) for _ in series[1:]))
        return self._page.gui.add_uplot(
            empty, tuple(series), title=title, height=172, scales={"x": {"time": False}},
            legend={"show": len(labels) > 1, "live": False}, axes=label_axes("Time [s]", ""),
            cursor={"drag": {"x": False, "y": False}},
        )  # fmt: skip
