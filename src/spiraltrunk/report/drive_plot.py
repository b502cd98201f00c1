"""Figure of what a driven robot measured over time: cables, tensions, temperatures and faults."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, final

import numpy as np

from spiraltrunk.report.style import (
    COLORS,
    INK,
    LIMIT,
    LINE_STYLES,
    NORMAL,
    SMALL,
    add_legend,
    build_figure,
    style_axes,
    write_figure,
)
from spiraltrunk.report.trial.phase_bands import add_bands, add_strip

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Measured:
    """What the driver measured, sampled at the same n instants."""

    time: np.ndarray
    """Instants, increasing, shape (n,) with n >= 2 [s]."""
    phase_spans: tuple[tuple[str, float, float], ...]
    """Name, start and end of each phase of the strategy; empty without one [-, s, s]."""
    pull: np.ndarray
    """Cable pulled in since the straight trunk, shape (n, n_cable) [m]."""
    tension: np.ndarray
    """Estimated tension, shape (n, n_cable) [N]."""
    target: np.ndarray
    """Tension that was asked for, shape (n, n_cable) [N]."""
    temperature: np.ndarray
    """Temperature of each motor, shape (n, n_cable) [degC]."""
    faults: tuple[tuple[float, str], ...]
    """Time and kind of each fault [s, -]."""
    title: str
    """Title of the figure."""


def build_drive_figure(measured: Measured) -> Figure:
    """Pulls, tensions with their targets, and temperatures over one time axis; faults as vertical lines."""
    figure = build_figure(7.6, 6.6, measured.title)
    panels = figure.subplots(3, 1, sharex=True, gridspec_kw={"height_ratios": [1.0, 1.2, 0.7]})
    _draw(panels[0], measured, 1e3 * measured.pull, "Length change [mm]\n(shortening > 0)")
    _draw(panels[1], measured, measured.tension, "Tension by the motors [N]\n(dotted: asked for)", measured.target)
    _draw(panels[2], measured, measured.temperature, "Motor [°C]")
    if measured.phase_spans:
        add_strip(panels[0], measured.phase_spans)
    for time, kind in measured.faults:
        panels[0].annotate(
            kind, (time, 1.0), (2, -2), xycoords=("data", "axes fraction"), textcoords="offset points", rotation=90,
            va="top", fontsize=SMALL, color=LIMIT,
        )  # fmt: skip
    panels[-1].set_xlabel("Time [s]", fontsize=NORMAL, color=INK)
    figure.align_ylabels(list(panels))
    return figure


def write_drive_plot(measured: Measured, path: str | Path) -> Path:
    """Write the figure.

    Raises:
        OSError: where the file cannot be written.
    """
    return write_figure(build_drive_figure(measured), path)


def _draw(axes: Axes, measured: Measured, values: np.ndarray, ylabel: str, target: np.ndarray | None = None) -> None:
    for i in range(values.shape[1]):
        color = COLORS[i % len(COLORS)]
        style = LINE_STYLES[i % 3]  # The fourth is that of the targets.
        axes.plot(measured.time, values[:, i], label=f"cable {i + 1}", linewidth=1.4, color=color, linestyle=style)
        if target is not None:
            axes.plot(measured.time, target[:, i], linewidth=0.9, color=color, linestyle=":")
    for time, _ in measured.faults:
        axes.axvline(time, color=LIMIT, linewidth=1.2)
    add_bands(axes, measured.phase_spans)
    style_axes(axes, ylabel)
    axes.set_xlim(float(measured.time[0]), float(measured.time[-1]))
    add_legend(axes)
