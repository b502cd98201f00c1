"""Figures of one run, and their files."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from spiraltrunk.files.atomic import write_draft
from spiraltrunk.report.style import DPI, add_time_label, build_figure
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


def build_cables_figure(series: Series) -> Figure:
    """Length change over tension of each cable; the axes from top to bottom are the figure's first two."""
    return _stack(series, [(add_cable_pull, 1.0), (add_cable_tension, 1.0)], height=4.6)


def build_joints_figure(series: Series) -> Figure:
    """Bend of every joint over time as colours: base below, tip above."""
    return _stack(series, [(add_joint_bend, 1.0)], height=3.4)


def build_curvature_figure(series: Series) -> Figure:
    """How far from the tip the trunk is curled: inwards in prehension and transport, back in release."""
    return _stack(series, [(add_front, 1.0)], height=3.0)


def build_object_figure(series: Series) -> Figure:
    """Height of the object and where it shall go."""
    return _stack(series, [(add_object_height, 1.0)], height=3.0)


def build_force_figure(series: Series) -> Figure:
    """Forces that carry the object: the trunk's and the strings'."""
    return _stack(series, [(add_forces, 1.0)], height=3.0)


def build_overview_figure(series: Series) -> Figure:
    """All of them over one time axis."""
    panels = [
        (add_cable_pull, 1.0),
        (add_cable_tension, 1.0),
        (add_joint_bend, 1.3),
        (add_front, 0.9),
        (add_object_height, 0.9),
        (add_forces, 0.9),
    ]
    return _stack(series, panels, height=10.6)


FIGURES: dict[str, Callable[[Series], Figure]] = {
    "cables.png": build_cables_figure,
    "joints.png": build_joints_figure,
    "curvature.png": build_curvature_figure,
    "object.png": build_object_figure,
    "force.png": build_force_figure,
}
"""File name of each figure of a run."""


def write_plots(series: Series, folder: str | Path) -> tuple[Path, ...]:
    """Write every figure of FIGURES to a folder, made where it is missing, and return the files.

    Raises:
        OSError: where the folder cannot be written.
    """
    figures = {Path(folder) / name: build(series) for name, build in FIGURES.items()}
    return tuple(_write(figure, path) for path, figure in figures.items())


def write_overview(series: Series, path: str | Path) -> Path:
    """Write one picture with all panels over one time axis.

    Raises:
        OSError: where the file cannot be written.
    """
    return _write(build_overview_figure(series), Path(path))


def _stack(series: Series, panels: Sequence[tuple[Callable[[Axes, Series], None], float]], *, height: float) -> Figure:
    figure = build_figure(_WIDTH, height, series.title)
    column = figure.subplots(
        len(panels), 1, sharex=True, squeeze=False, gridspec_kw={"height_ratios": [share for _, share in panels]}
    )[:, 0]
    for axes, (add_panel, _) in zip(column, panels, strict=True):
        add_panel(axes, series)
    add_strip(column[0], series.phase_spans)
    add_time_label(column[-1])
    figure.align_ylabels(list(column))
    return figure


def _write(figure: Figure, path: Path) -> Path:
    with write_draft(path) as draft:
        figure.savefig(draft, dpi=DPI, format="png")
    return path
