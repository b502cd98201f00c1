"""Measured and predicted shapes side by side: box plots of their distances, and lines and dots in three views."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, final

import numpy as np

from spiraltrunk.report.shape.views import SIDE_VIEWS, add_views
from spiraltrunk.report.style import COLORS, INK, add_legend_below, build_figure, style_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_SHAPES = 5
"""Largest number of shapes in one overlay, as in the paper's [-]."""

_MOST_TICKS = 18

_MEAN: Any = {"marker": "D", "markersize": 3.2, "color": COLORS[1], "linestyle": ""}
"""Style of the root mean squares."""


@final
@dataclass(frozen=True, kw_only=True)
class ShapeComparison:
    """Shapes of one run, or of several runs of one shape each, in the frame of `Shape`."""

    title: str
    """Title of the figures."""
    labels: tuple[str, ...]
    """Label of each shape, such as its step or tilt."""
    label: str
    """Quantity and unit of the labels."""
    measured: np.ndarray
    """Measured points, NaN where unseen, shape (n, n_section, 3), n from 1 [m]."""
    predicted: np.ndarray
    """Points that the model predicts, shape (n, n_section, 3) [m]."""

    @property
    def distance(self) -> np.ndarray:
        """Distances of measured from predicted points, NaN where unseen, shape (n, n_section) [m]."""
        return np.asarray(np.linalg.norm(self.measured - self.predicted, axis=-1))

    @property
    def sections(self) -> np.ndarray:
        """Indices of the sections that were seen at least once, shape (k,) [-]."""
        return np.flatnonzero(np.isfinite(self.distance).any(axis=0))


def build_boxes_figure(comparison: ShapeComparison) -> Figure:
    """Box plots by shape, left, and by section, right [mm]: median, quartiles, whiskers of 1.5 quartile distances.

    A diamond is the root mean square, which the tables call RMSE.
    """
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    distance, sections = 1e3 * comparison.distance, comparison.sections
    figure = build_figure(11.0, 3.6, comparison.title)
    left, right = figure.subplots(1, 2, sharey=True)
    _draw_boxes(left, list(distance), comparison.labels, COLORS[0])
    _draw_boxes(right, list(distance[:, sections].T), [str(number + 1) for number in sections], COLORS[2])
    style_axes(left, "Distance from the model [mm]", xlabel=comparison.label)
    style_axes(right, xlabel="Section, 1 at the base")
    left.set_ylim(bottom=0.0)
    handles = [
        Patch(facecolor="#00000020", edgecolor=INK, label="quartiles"),
        Line2D([], [], color=INK, linewidth=1.4, label="median"),
        Line2D([], [], **_MEAN, label="root mean square"),
        Line2D([], [], linestyle="", marker="o", markersize=3, color=INK, markerfacecolor="none", label="outlier"),
    ]
    add_legend_below(figure, handles)
    return figure


def _draw_boxes(axes: Axes, groups: Sequence[np.ndarray], labels: Sequence[str], color: str) -> None:
    seen = [group[np.isfinite(group)] for group in groups]
    axes.boxplot(
        seen, positions=range(len(seen)), widths=0.6, patch_artist=True, manage_ticks=False,
        boxprops={"facecolor": color, "alpha": 0.30, "edgecolor": color}, medianprops={"color": INK, "linewidth": 1.4},
        whiskerprops={"color": color}, capprops={"color": color},
        flierprops={"marker": "o", "markersize": 2.5, "markeredgecolor": color, "markerfacecolor": "none"},
    )  # fmt: skip
    axes.plot(range(len(seen)), [np.sqrt(np.mean(group**2)) if len(group) else np.nan for group in seen], **_MEAN)
    ticks = range(0, len(labels), -(-len(labels) // _MOST_TICKS))
    axes.set_xticks(list(ticks), [labels[i] for i in ticks])
    axes.set_xlim(-0.7, len(labels) - 0.3)


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
    add_legend_below(figure, _list_handles(comparison, chosen, colors), columns=len(chosen) + 2)
    return figure


def _list_handles(comparison: ShapeComparison, chosen: list[int], colors: list[Any]) -> list[Any]:
    from matplotlib.lines import Line2D

    word, _, unit = comparison.label.lower().partition(" [")
    labels = [f"{word} {comparison.labels[shape]} {unit.rstrip(']')}".rstrip() for shape in chosen]
    return [
        Line2D([], [], color=INK, linewidth=1.4, label="model"),
        Line2D([], [], color=INK, linestyle="", marker="o", markersize=3.2, label="recording"),
        *(Line2D([], [], color=color, linewidth=3.0, label=label) for label, color in zip(labels, colors, strict=True)),
    ]
