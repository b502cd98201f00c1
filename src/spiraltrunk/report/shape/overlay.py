"""Figure of measured shapes over predicted ones: in space, from the side and from the end."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from spiraltrunk.report.shape.comparison import ShapeComparison
from spiraltrunk.report.shape.views import SIDE_VIEWS, add_views
from spiraltrunk.report.style import INK, add_legend_below, build_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_SHAPES = 5
"""Largest number of shapes in one figure, as in the paper's [-]."""


def choose_shapes(comparison: ShapeComparison) -> list[int]:
    """Indices of the shapes to draw, at most `MOST_SHAPES`: first, last, the worst, and others evenly between."""
    count = len(comparison.labels)
    worst = int(np.argmax(np.nan_to_num(comparison.distance).max(axis=1)))
    even = [round(i) for i in np.linspace(0, count - 1, min(count, MOST_SHAPES))]
    if worst not in even:
        nearest = min(range(1, len(even) - 1), key=lambda i: abs(even[i] - worst))
        even[nearest] = worst
    return sorted(set(even))


def build_overlay_figure(comparison: ShapeComparison) -> Figure:
    """Lines are the model, dots the recording, thin lines join the two; one colour a shape, one scale, in mm."""
    from matplotlib import colormaps

    chosen = choose_shapes(comparison)
    colors = [colormaps["viridis"](value) for value in np.linspace(0.0, 0.85, len(chosen))]
    lines = 1e3 * np.pad(comparison.predicted[chosen], ((0, 0), (1, 0), (0, 0)))  # From the base on.
    dots = 1e3 * comparison.measured[chosen]
    figure = build_figure(11.0, 4.15, comparison.title)
    space, sides = add_views(figure, np.concatenate([lines, dots], axis=1))
    views = [(space, [0, 2, 1]), *((axes, [right, 1]) for axes, (_, right, _) in zip(sides, SIDE_VIEWS, strict=True))]
    for line, dot, color in zip(lines, dots, colors, strict=True):
        for axes, seen in views:
            axes.plot(*line[:, seen].T, color=color, linewidth=1.4)
            axes.plot(*dot[:, seen].T, linestyle="", marker="o", markersize=3.2, color=color)
            for pair in np.stack([dot, line[1:]], axis=1):
                axes.plot(*pair[:, seen].T, color=color, linewidth=0.6, alpha=0.6)
    add_legend_below(figure, _handles(comparison, chosen, colors), columns=len(chosen) + 2)
    return figure


def _handles(comparison: ShapeComparison, chosen: list[int], colors: list[Any]) -> list[Any]:
    from matplotlib.lines import Line2D

    kinds = [
        Line2D([], [], color=INK, linewidth=1.4, label="model"),
        Line2D([], [], color=INK, linestyle="", marker="o", markersize=3.2, label="recording"),
    ]
    word, _, unit = comparison.label.lower().partition(" [")
    labels = [f"{word} {comparison.labels[shape]} {unit.rstrip(']')}".rstrip() for shape in chosen]
    return kinds + [
        Line2D([], [], color=color, linewidth=3.0, label=label) for label, color in zip(labels, colors, strict=True)
    ]
