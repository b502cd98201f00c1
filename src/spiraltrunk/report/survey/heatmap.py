"""Heat maps of the success rate over the object's width and mass, one for each strategy."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from spiraltrunk.report.style import INK, NORMAL, SMALL, build_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BINS = 4
"""Approximate number of bins in each direction; their edges are round numbers."""

_COLUMNS = 3
"""Largest number of maps in a row."""


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


@final
@dataclass(frozen=True, kw_only=True)
class Cells:
    """Two-dimensional histogram of trials over width and mass."""

    width_mm: np.ndarray
    """Edges of the bins of width, shape (n + 1,) [mm]."""
    mass_g: np.ndarray
    """Edges of the bins of mass, shape (m + 1,) [g]."""
    trials: np.ndarray
    """Trials in each bin, shape (n, m) [-]."""
    successes: np.ndarray
    """Successful trials in each bin, shape (n, m) [-]."""


def compute_cells(outcomes: Outcomes) -> Cells:
    """Trials and successes in bins with round edges; every trial lies in one bin."""
    width, mass = 1e3 * np.asarray(outcomes.width, dtype=float), 1e3 * np.asarray(outcomes.mass, dtype=float)
    edges = (_round_edges(width), _round_edges(mass))
    success = np.asarray(outcomes.success, dtype=bool)
    trials, *_ = np.histogram2d(width, mass, bins=edges)
    successes, *_ = np.histogram2d(width[success], mass[success], bins=edges)
    return Cells(width_mm=edges[0], mass_g=edges[1], trials=trials.astype(int), successes=successes.astype(int))


def build_heatmap_figure(sheet: Sequence[Outcomes]) -> Figure:
    """One map for each strategy: the colour is the rate, the text successes/trials; bins without trials are hatched."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    columns = max(1, min(_COLUMNS, len(sheet)))
    rows = max(1, math.ceil(len(sheet) / columns))
    figure = build_figure(0.9 + 3.3 * columns, 0.7 + 2.7 * rows, "Trials that succeeded, by the object's size and mass")
    grid = figure.subplots(rows, columns, squeeze=False)
    for axes, outcomes in zip(grid.flat, sheet, strict=False):
        _add_map(axes, outcomes)
    for axes in list(grid.flat)[len(sheet) :]:
        axes.set_axis_off()
    colors = ScalarMappable(Normalize(0, 100), "viridis")
    bar = figure.colorbar(colors, ax=grid, shrink=0.85, pad=0.02, aspect=15 * rows)
    bar.set_label("Rate of success [%]", fontsize=NORMAL, color=INK)
    bar.ax.tick_params(labelsize=SMALL, colors=INK)
    return figure


def _add_map(axes: Axes, outcomes: Outcomes) -> None:
    total = f"{sum(outcomes.success)} of {len(outcomes.success)}"
    axes.set_title(f"{outcomes.name}: {total}", fontsize=NORMAL, color=INK, parse_math=False)
    axes.set_xlabel("Width [mm]", fontsize=SMALL, color=INK)
    axes.set_ylabel("Mass [g]", fontsize=SMALL, color=INK)
    axes.tick_params(labelsize=SMALL, colors=INK)
    axes.patch.set(hatch="////", facecolor="#F4F4F4", edgecolor="#D8D8D8")
    if not len(outcomes.success):
        axes.set(xticks=[], yticks=[])
        return
    cells = compute_cells(outcomes)
    rate = np.ma.masked_invalid(100 * cells.successes / np.where(cells.trials, cells.trials, np.nan))
    mesh = axes.pcolormesh(
        cells.width_mm, cells.mass_g, rate.T, cmap="viridis", vmin=0, vmax=100, edgecolors="white", linewidth=1.0
    )
    mesh.set_rasterized(True)
    for i, j in np.argwhere(cells.trials):
        axes.text(
            cells.width_mm[i : i + 2].mean(), cells.mass_g[j : j + 2].mean(),
            f"{cells.successes[i, j]}/{cells.trials[i, j]}", ha="center", va="center", fontsize=SMALL,
            color="white" if rate[i, j] < 60 else INK,
        )  # fmt: skip
    axes.set_xticks(cells.width_mm)
    axes.set_yticks(cells.mass_g)


def _round_edges(values: np.ndarray) -> np.ndarray:
    """Evenly spaced round numbers that enclose all values."""
    from matplotlib.ticker import MaxNLocator

    if not values.size:
        return np.array([0.0, 1.0])
    edges = np.array(MaxNLocator(nbins=_BINS, steps=[1, 2, 2.5, 5, 10]).tick_values(values.min(), values.max()), float)
    edges[[0, -1]] = min(edges[0], values.min()), max(edges[-1], values.max())  # Rounding may leave a value outside.
    return edges
