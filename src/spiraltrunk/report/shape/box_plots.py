"""Box plots of the distances between measured and predicted points, by shape and by section."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from spiraltrunk.report.shape.comparison import ShapeComparison
from spiraltrunk.report.style import COLORS, INK, add_legend_below, build_figure, style_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_TICKS = 18

_MEAN: Any = {"marker": "D", "markersize": 3.2, "color": COLORS[1], "linestyle": ""}
"""Style of the root mean squares."""


def build_boxes_figure(comparison: ShapeComparison) -> Figure:
    """Box plots by shape, left, and by section, right [mm]: median, quartiles, whiskers of 1.5 quartile distances.

    A diamond is the root mean square, which the tables call RMSE.
    """
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    distance, sections = 1e3 * comparison.distance, comparison.sections
    figure = build_figure(11.0, 3.6, comparison.title)
    left, right = figure.subplots(1, 2, sharey=True)
    _draw(left, list(distance), comparison.labels, COLORS[0])
    _draw(right, list(distance[:, sections].T), [str(number + 1) for number in sections], COLORS[2])
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


def _draw(axes: Axes, groups: Sequence[np.ndarray], labels: Sequence[str], color: str) -> None:
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
