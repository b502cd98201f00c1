"""One look for every plot, set on each figure: matplotlib's global settings stay as they are."""

from __future__ import annotations

from textwrap import wrap
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""Lines, told apart with any colour vision (Okabe and Ito, Color Universal Design)."""

LINE_STYLES = ("-", "--", "-.", ":")
"""Styles of the lines, so that they differ in print without colours as well."""

INK = "#222222"
"""Text and frames."""

PHASE_COLORS = {"reach": "#56B4E9", "prehension": "#E69F00", "transport": "#009E73", "release": "#CC79A7"}
"""Strips over the plots; the bands in them are the same, much lighter."""

OTHER_PHASE_COLOR = "#999999"
"""Strip of a phase with another name."""

LIMIT = "#B34500"
"""What must not be passed."""

SMALL, NORMAL, LARGE = 8.0, 9.0, 10.5
"""Text sizes: ticks and legends, axes, title [pt]."""

DPI = 150
"""Pixels per inch."""


def build_figure(width: float, height: float, title: str) -> Figure:
    """An empty figure that makes room for what is drawn on it, sizes in inches."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=DPI, layout="constrained", facecolor="white")
    if title:
        figure.suptitle(
            "\n".join(wrap(title, round(10 * width))), fontsize=LARGE, fontweight="bold", color=INK, parse_math=False
        )
    return figure


def add_look(axes: Axes, ylabel: str) -> None:
    """Label the vertical axis, and give ticks, frame and grid the look of the house."""
    axes.set_ylabel(ylabel, fontsize=NORMAL, color=INK)
    axes.tick_params(labelsize=SMALL, colors=INK)
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(visible=True, color="#00000018", linewidth=0.6)
    axes.set_axisbelow(True)


def add_time_label(axes: Axes) -> None:
    """Label the horizontal axis."""
    axes.set_xlabel("Time [s]", fontsize=NORMAL, color=INK)


def add_legend(axes: Axes) -> None:
    """Name the lines to the right of the axes, where no data can be."""
    axes.legend(
        loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0, frameon=False, fontsize=SMALL, labelcolor=INK
    )
