"""Rates of success with their intervals, one line each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, final

from spiraltrunk.files.atomic import write_draft
from spiraltrunk.report.style import COLORS, DPI, INK, NORMAL, SMALL, add_look, build_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@final
@dataclass(frozen=True, kw_only=True)
class Rate:
    """How often something succeeded."""

    name: str
    """What was tried."""
    trials: int
    """How often it was tried."""
    successes: int
    """How often it succeeded."""
    low: float
    """Lower end of the rate's interval of 95 % [-]."""
    high: float
    """Its upper end [-]."""


def write_rates(rates: Sequence[Rate], path: str | Path) -> Path:
    """Write the picture of the rates.

    Raises:
        OSError: where the file cannot be written.
    """
    figure = build_rates_figure(rates)
    with write_draft(path) as draft:
        figure.savefig(draft, dpi=DPI, format="png")
    return Path(path)


def build_rates_figure(rates: Sequence[Rate]) -> Figure:
    """A dot for each rate, a line for its interval, the first on top [%]; without trials there is the line alone."""
    figure = build_figure(7.6, 1.3 + 0.36 * len(rates), "Trials that succeeded, with intervals of 95 % (Wilson)")
    axes = figure.subplots()
    for i, rate in enumerate(rates):
        axes.plot([100 * rate.low, 100 * rate.high], [i, i], color=COLORS[0], lw=4.0, alpha=0.35, solid_capstyle="butt")
        if rate.trials:
            axes.plot(100 * rate.successes / rate.trials, i, color=COLORS[0], marker="o", markersize=6)
        axes.annotate(
            f"{rate.successes} of {rate.trials}", (1.01, i), xycoords=("axes fraction", "data"), va="center",
            fontsize=SMALL, color=INK, annotation_clip=False,
        )  # fmt: skip
    add_look(axes, "")
    axes.set_yticks(range(len(rates)), [rate.name for rate in rates], fontsize=NORMAL, color=INK)
    axes.set_ylim(len(rates) - 0.5, -0.5)
    axes.set_xlim(-1.5, 101.5)
    axes.set_xlabel("Rate of success [%]", fontsize=NORMAL, color=INK)
    return figure
