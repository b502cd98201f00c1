"""Figures of one run, and their files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from spiraltrunk.report.style import INK, NORMAL, build_figure, write_figure
from spiraltrunk.report.trial.panels import (
    add_cable_pull,
    add_cable_tension,
    add_forces,
    add_front,
    add_joint_bend,
    add_object_height,
)
from spiraltrunk.report.trial.phase_bands import add_strip
from spiraltrunk.report.trial.series import Series

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WIDTH = 7.6
"""Width of every figure [in]."""

FIGURES: dict[str, tuple[float, dict[Callable[[Axes, Series], None], float]]] = {
    "cables.png": (4.6, {add_cable_pull: 1.0, add_cable_tension: 1.0}),
    "joints.png": (3.4, {add_joint_bend: 1.0}),
    "curvature.png": (3.0, {add_front: 1.0}),
    "object.png": (3.0, {add_object_height: 1.0}),
    "force.png": (3.0, {add_forces: 1.0}),
    "overview.png": (
        10.6,
        {
            add_cable_pull: 1.0, add_cable_tension: 1.0, add_joint_bend: 1.3, add_front: 0.9, add_object_height: 0.9,
            add_forces: 0.9,
        },
    ),
}  # fmt: skip
"""File name of each figure, its height [in], and its panels from top to bottom with their relative heights."""


def build_run_figure(series: Series, name: str) -> Figure:
    """Build the figure of `FIGURES` with this file name: panels over one time axis."""
    height, panels = FIGURES[name]
    figure = build_figure(_WIDTH, height, series.title)
    ratios = {"height_ratios": list(panels.values())}
    column = figure.subplots(len(panels), 1, sharex=True, squeeze=False, gridspec_kw=ratios)[:, 0]
    for axes, add_panel in zip(column, panels, strict=True):
        add_panel(axes, series)
    add_strip(column[0], series.phase_spans)
    column[-1].set_xlabel("Time [s]", fontsize=NORMAL, color=INK)
    figure.align_ylabels(list(column))
    return figure


def write_plots(series: Series, folder: str | Path) -> tuple[Path, ...]:
    """Write every figure to a folder, made where it is missing, and return the files.

    Raises:
        OSError: where the folder cannot be written.
    """
    return tuple(write_figure(build_run_figure(series, name), Path(folder) / name) for name in FIGURES)
