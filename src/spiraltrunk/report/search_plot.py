"""Figures of a search for a trunk: success by candidate, and what is gained for what."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from spiraltrunk.report.style import COLORS, INK, LIMIT, NORMAL, SMALL, add_legend, build_figure, style_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@final
@dataclass(frozen=True, kw_only=True)
class CandidatePoint:
    """A candidate in the figures."""

    number: int
    """Its number."""
    success: float
    """Share of the objects that were grasped [-]."""
    low: float
    """Lower end of its interval [-]."""
    high: float
    """Upper end of its interval [-]."""
    payload: float
    """Payload [kg]."""
    range: float
    """Largest less smallest width [m]."""
    is_printable: bool
    """Whether it can be printed; else it was not simulated."""


def build_history_figure(points: Sequence[CandidatePoint]) -> Figure:
    """Success of each candidate in turn with its 95 % interval, and the best so far."""
    from matplotlib.ticker import MaxNLocator

    figure = build_figure(7.5, 3.6, "Success of the candidates")
    axes = figure.subplots()
    style_axes(axes, "Objects grasped [%]", xlabel="Candidate; 0 has the authors' proportions")
    tried = [point for point in points if point.is_printable]
    if tried:
        numbers = np.array([point.number for point in tried])
        rate = 100 * np.array([point.success for point in tried])
        low, high = (100 * np.array([getattr(point, name) for point in tried]) for name in ("low", "high"))
        axes.errorbar(
            numbers, rate, yerr=(rate - low, high - rate), fmt="o", markersize=4, color=COLORS[0], ecolor="#9CC4DF",
            elinewidth=1.0, label="rate and 95 % interval",
        )  # fmt: skip
        axes.step(numbers, np.maximum.accumulate(rate), where="post", color=COLORS[1], linewidth=1.2, label="best")
    _mark_refused(axes, [point.number for point in points if not point.is_printable])
    axes.set_ylim(-4.0, 104.0)
    axes.set_xlim(-0.7, max((point.number for point in points), default=0) + 0.7)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    if points:
        add_legend(axes, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)
    return figure


def build_front_figure(points: Sequence[CandidatePoint], front: Sequence[int], width: float) -> Figure:
    """Success over payload at an object of a width [m]; colours are the graspable range, rings the Pareto front."""
    figure = build_figure(6.4, 4.2, "What is gained for what")
    axes = figure.subplots()
    style_axes(axes, "Objects grasped [%]", xlabel=f"Payload of an object of {1e3 * width:.0f} mm [kg]")
    tried = [point for point in points if point.is_printable]
    if tried:
        drawn = axes.scatter(
            [point.payload for point in tried], [100 * point.success for point in tried], s=36.0,
            c=[1e3 * point.range for point in tried], cmap="viridis", edgecolors=INK, linewidths=0.5, zorder=2,
        )  # fmt: skip
        bar = figure.colorbar(drawn, ax=axes)
        bar.set_label("Graspable range: largest less smallest width [mm]", fontsize=NORMAL, color=INK)
        bar.ax.tick_params(labelsize=SMALL, colors=INK)
    for point in tried:
        if point.number in front:
            place = (point.payload, 100 * point.success)
            axes.plot(*place, "o", markersize=11, markerfacecolor="none", markeredgecolor=LIMIT)
            axes.annotate(str(point.number), place, (6, 5), textcoords="offset points", fontsize=SMALL, color=INK)
    axes.margins(0.1)
    return figure


def _mark_refused(axes: Axes, numbers: Sequence[int]) -> None:
    if numbers:
        axes.plot(numbers, [0.0] * len(numbers), "x", color=LIMIT, markersize=5, label="cannot be printed")
