"""How the distances of measured points from predicted ones are spread, by shape and by section."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from spiraltrunk.files.atomic import write_draft
from spiraltrunk.report.shape.comparison import Judged
from spiraltrunk.report.style import COLORS, DPI, INK, NORMAL, SMALL, add_look, build_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_TICKS = 18


def write_boxes(judged: Judged, path: str | Path) -> Path:
    """Draw the spread to a PNG.

    Raises:
        OSError: where the file cannot be written.
    """
    figure = build_boxes_figure(judged)
    with write_draft(path) as draft:
        figure.savefig(draft, dpi=DPI, format="png")
    return Path(path)


def build_boxes_figure(judged: Judged) -> Figure:
    """Boxes by shape, left, and by section, right: median, quartiles, all within 1.5 of their distance, and the rest.

    A diamond is the root mean square, which the tables call RMSE.
    """
    distance = 1e3 * judged.distance
    sections = judged.sections
    figure = build_figure(11.0, 3.6, judged.title)
    left, right = figure.subplots(1, 2, sharey=True)
    _draw(left, list(distance), judged.labels, COLORS[0])
    _draw(right, list(distance[:, sections].T), [str(number + 1) for number in sections], COLORS[2])
    add_look(left, "Distance from the model [mm]")
    add_look(right, "")
    left.set_xlabel(judged.label, fontsize=NORMAL, color=INK)
    right.set_xlabel("Section, 1 at the base", fontsize=NORMAL, color=INK)
    left.set_ylim(bottom=0.0)
    figure.legend(
        handles=_handles(), loc="outside lower center", ncols=4, frameon=False, fontsize=SMALL, labelcolor=INK
    )
    return figure


def _draw(axes: Axes, groups: Sequence[np.ndarray], labels: Sequence[str], color: str) -> None:
    seen = [group[np.isfinite(group)] for group in groups]
    axes.boxplot(
        seen, positions=range(len(seen)), widths=0.6, patch_artist=True, manage_ticks=False,
        boxprops={"facecolor": color, "alpha": 0.30, "edgecolor": color}, medianprops={"color": INK, "linewidth": 1.4},
        whiskerprops={"color": color}, capprops={"color": color},
        flierprops={"marker": "o", "markersize": 2.5, "markeredgecolor": color, "markerfacecolor": "none"},
    )  # fmt: skip
    root = [float(np.sqrt(np.mean(group**2))) if len(group) else np.nan for group in seen]
    axes.plot(range(len(seen)), root, linestyle="", marker="D", markersize=3.2, color=COLORS[1])
    step = max(1, -(-len(labels) // _MOST_TICKS))
    ticks = range(0, len(labels), step)
    axes.set_xticks(list(ticks), [labels[i] for i in ticks])
    axes.set_xlim(-0.7, len(labels) - 0.3)


def _handles() -> list[object]:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    return [
        Patch(facecolor="#00000020", edgecolor=INK, label="quartiles"),
        Line2D([], [], color=INK, linewidth=1.4, label="median"),
        Line2D([], [], linestyle="", marker="D", markersize=3.2, color=COLORS[1], label="root mean square"),
        Line2D([], [], linestyle="", marker="o", markersize=3, color=INK, markerfacecolor="none", label="outlier"),
    ]
