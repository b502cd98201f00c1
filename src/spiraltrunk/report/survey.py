"""Figures of a survey: success rates by strategy, heat maps over the object's width and mass, and failures by cause."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, final

import numpy as np

from spiraltrunk.report.style import COLORS, INK, NORMAL, SMALL, build_figure, build_grid, style_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BINS = 4
"""Approximate number of bins in each direction; their edges are round numbers."""
_LONGEST, _START = 34, 8
"""Characters of a name that figures show at most, and of its start where its middle is left out: a policy's name is a
path."""


@final
@dataclass(frozen=True, kw_only=True)
class Outcomes:
    """Trials of one strategy; all sequences are equally long."""

    name: str
    """Name of the strategy."""
    width: Sequence[float]
    """Width of each trial's object [m]."""
    mass: Sequence[float]
    """Its mass [kg]."""
    success: Sequence[bool]
    """Whether the trial succeeded."""


def compute_cells(outcomes: Outcomes) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Two-dimensional histogram over width and mass with round edges; every trial lies in one bin.

    Returns:
        Edges of width, shape (n + 1,) [mm], and of mass, shape (m + 1,) [g]; trials and successes in each bin, both of
        shape (n, m) [-].
    """
    width, mass = 1e3 * np.asarray(outcomes.width, dtype=float), 1e3 * np.asarray(outcomes.mass, dtype=float)
    edges = (_round_edges(width), _round_edges(mass))
    trials, successes = (
        np.histogram2d(width, mass, bins=edges, weights=weights)[0].astype(int)
        for weights in (None, np.asarray(outcomes.success, dtype=float))
    )
    return *edges, trials, successes


def build_heatmap_figure(sheet: Sequence[Outcomes]) -> Figure:
    """One map for each strategy: the colour is the rate, the text successes/trials; bins without trials are hatched."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    figure, grid = build_grid(len(sheet), 3, (3.6, 2.8), "Trials that succeeded, by the object's size and mass")
    for axes, outcomes in zip(grid, sheet, strict=True):
        _add_map(axes, outcomes)
    colors = ScalarMappable(Normalize(0, 100), "viridis")
    bar = figure.colorbar(colors, ax=figure.axes, shrink=0.85, pad=0.02, aspect=5 * figure.get_figheight())
    bar.set_label("Rate of success [%]", fontsize=NORMAL, color=INK)
    bar.ax.tick_params(labelsize=SMALL, colors=INK)
    return figure


def _add_map(axes: Axes, outcomes: Outcomes) -> None:
    total = f"{sum(outcomes.success)} of {len(outcomes.success)}"
    axes.set_title(f"{_shorten(outcomes.name)}: {total}", fontsize=NORMAL, color=INK, parse_math=False)
    axes.set_xlabel("Width [mm]", fontsize=SMALL, color=INK)
    axes.set_ylabel("Mass [g]", fontsize=SMALL, color=INK)
    axes.tick_params(labelsize=SMALL, colors=INK)
    axes.patch.set(hatch="////", facecolor="#F4F4F4", edgecolor="#D8D8D8")
    if not len(outcomes.success):
        axes.set(xticks=[], yticks=[])
        return
    width_mm, mass_g, trials, successes = compute_cells(outcomes)
    rate = np.ma.masked_invalid(100 * successes / np.where(trials, trials, np.nan))
    axes.pcolormesh(
        width_mm, mass_g, rate.T, cmap="viridis", vmin=0, vmax=100, edgecolors="white", linewidth=1.0, rasterized=True
    )
    for i, j in np.argwhere(trials):
        axes.text(
            width_mm[i : i + 2].mean(), mass_g[j : j + 2].mean(), f"{successes[i, j]}/{trials[i, j]}", ha="center",
            va="center", fontsize=SMALL, color="white" if rate[i, j] < 60 else INK,
        )  # fmt: skip
    axes.set_xticks(width_mm)
    axes.set_yticks(mass_g)


def _round_edges(values: np.ndarray) -> np.ndarray:
    """Evenly spaced round numbers that enclose all values."""
    from matplotlib.ticker import MaxNLocator

    if not values.size:
        return np.array([0.0, 1.0])
    edges = np.array(MaxNLocator(nbins=_BINS, steps=[1, 2, 2.5, 5, 10]).tick_values(values.min(), values.max()), float)
    edges[[0, -1]] = min(edges[0], values.min()), max(edges[-1], values.max())  # Rounding may leave a value outside.
    return edges


def _shorten(name: str) -> str:
    """A name as figures show it: of a long one its start and its end."""
    return name if len(name) <= _LONGEST else f"{name[:_START]}\N{HORIZONTAL ELLIPSIS}{name[_START + 1 - _LONGEST :]}"


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
    axes.set_yticks(range(len(rates)), [_shorten(name) for name in rates], fontsize=NORMAL, color=INK, parse_math=False)
    axes.set(ylim=(len(rates) - 0.5, -0.5), xlim=(-1.5, 101.5))
    return figure


def build_causes_figure(*groups: Mapping[str, Mapping[str, Any]]) -> Figure:
    """Number of failures by cause, a table for each group with its most frequent cells darkest.

    Args:
        groups: by strategy or by class of objects, ``trials``, and ``causes`` with their numbers of failures.
    """
    counted = [cause for group in groups for own in group.values() for cause in own["causes"]]
    causes = list(dict.fromkeys(counted)) or ["no failure"]
    rows = [max(1, len(group)) for group in groups]
    title = "Failures by cause, beside the number of trials"
    figure = build_figure(2.6 + 0.75 * max(4, len(causes)), 1.6 + 0.32 * sum(rows) + 0.6 * len(groups), title)
    grid = figure.subplots(len(groups), 1, squeeze=False, gridspec_kw={"height_ratios": rows})[:, 0]
    for axes, group in zip(grid, groups, strict=True):
        _add_cause_table(axes, group, causes)
    return figure


def _add_cause_table(axes: Axes, group: Mapping[str, Mapping[str, Any]], causes: Sequence[str]) -> None:
    count = np.array([[own["causes"].get(cause, 0) for cause in causes] for own in group.values()], dtype=int)
    count = count.reshape(len(group), len(causes))
    most = max(1, int(count.max(initial=0)))
    axes.pcolormesh(count, cmap="Oranges", vmin=0, vmax=1.4 * most, edgecolors="white", linewidth=1.0)
    for i, j in np.argwhere(count):
        axes.text(j + 0.5, i + 0.5, str(count[i, j]), ha="center", va="center", fontsize=SMALL, color=INK)
    names = [f"{_shorten(name)} ({own['trials']})" for name, own in group.items()]
    axes.set_yticks(np.arange(len(names)) + 0.5, names, fontsize=SMALL, color=INK, parse_math=False)
    axes.set_xticks(np.arange(len(causes)) + 0.5, causes, fontsize=SMALL, color=INK, rotation=30, ha="right")
    axes.set(xlim=(0, len(causes)), ylim=(max(1, len(group)), 0))
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
