"""Figures of learning: losses over updates, and rates of success over trials."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

from spiraltrunk.report.style import COLORS, LIMIT, add_legend, build_grid, style_axes

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@final
@dataclass(frozen=True, kw_only=True)
class Curve:
    """Lines over one axis."""

    title: str
    """Title of the panel."""
    xlabel: str
    """What the lines are over."""
    ylabel: str
    """What they show."""
    x: Sequence[float]
    """Abscissae of every line."""
    lines: Mapping[str, Sequence[float]]
    """Ordinates of each line by its label."""
    is_log: bool = False
    """Whether the ordinate is logarithmic."""
    bar: float | None = None
    """Ordinate to reach; None for none."""


def build_learning_figure(curves: Sequence[Curve], title: str) -> Figure:
    """One panel for each curve, two in a row."""
    figure, grid = build_grid(len(curves), 2, (4.2, 3.0), title)
    for axes, curve in zip(grid, curves, strict=True):
        for i, (label, values) in enumerate(curve.lines.items()):
            axes.plot(curve.x, values, color=COLORS[i % len(COLORS)], linewidth=1.4, label=label)
        if curve.bar is not None:
            axes.axhline(curve.bar, color=LIMIT, linestyle="--", linewidth=1.0, label="asked for")
        if curve.is_log:
            axes.set_yscale("log")
        style_axes(axes, curve.ylabel, xlabel=curve.xlabel, title=curve.title)
        add_legend(axes, loc="best")
    return figure
