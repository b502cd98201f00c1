"""Figure of success rates with their Wilson intervals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from spiraltrunk.report.style import COLORS, INK, NORMAL, SMALL, build_figure, style_axes

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def build_rates_figure(rates: Mapping[str, Mapping[str, float]]) -> Figure:
    """A dot for each rate and a line for its interval [%], the first on top; without trials only the line.

    Args:
        rates: by strategy, ``trials``, ``successes``, and the ends ``low`` and ``high`` of the 95 % interval [-].
    """
    figure = build_figure(7.6, 1.3 + 0.36 * len(rates), "Trials that succeeded, with intervals of 95 % (Wilson)")
    axes = figure.subplots()
    for i, rate in enumerate(rates.values()):
        ends = [100 * rate["low"], 100 * rate["high"]]
        axes.plot(ends, [i, i], color=COLORS[0], lw=4.0, alpha=0.35, solid_capstyle="butt")
        if rate["trials"]:
            axes.plot(100 * rate["successes"] / rate["trials"], i, color=COLORS[0], marker="o", markersize=6)
        axes.annotate(
            f"{rate['successes']} of {rate['trials']}", (1.01, i), xycoords=("axes fraction", "data"), va="center",
            fontsize=SMALL, color=INK, annotation_clip=False,
        )  # fmt: skip
    style_axes(axes, xlabel="Rate of success [%]")
    axes.set_yticks(range(len(rates)), list(rates), fontsize=NORMAL, color=INK)
    axes.set(ylim=(len(rates) - 0.5, -0.5), xlim=(-1.5, 101.5))
    return figure
