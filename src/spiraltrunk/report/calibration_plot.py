"""Figure of a calibration: fitted stiffness of each joint with its interval, and errors on held-out shapes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from spiraltrunk.report.style import COLORS, INK, SMALL, add_legend, build_figure, style_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_NAMES = ("equilibrium, calibrated", "equilibrium, as designed", "paper's model, as designed")


@final
@dataclass(frozen=True, kw_only=True)
class CalibrationBars:
    """Values of the figure."""

    before: np.ndarray
    """Designed stiffness of each joint, shape (n_joint,) [N m/rad]."""
    value: np.ndarray
    """Fitted stiffness, shape (n_joint,) [N m/rad]."""
    low: np.ndarray
    """Lower ends of the 95 % intervals, shape (n_joint,) [N m/rad]."""
    high: np.ndarray
    """Upper ends, shape (n_joint,) [N m/rad]."""
    groups: tuple[str, ...]
    """Kinds of measured shapes."""
    errors: np.ndarray
    """Mean RMSE by kind and model (calibrated, as designed, paper's), NaN for none, shape (n_group, 3) [m]."""
    is_held_out: bool
    """Whether the errors are of shapes that were held out of the fit."""
    title: str = "Calibration"
    """Title of the figure."""


def build_calibration_figure(bars: CalibrationBars) -> Figure:
    """Stiffness by joint, left, and errors by kind of shape and model, right."""
    figure = build_figure(11.0, 4.2, bars.title)
    left, right = figure.subplots(1, 2)
    _draw_stiffness(left, bars)
    _draw_errors(right, bars)
    return figure


def _draw_stiffness(axes: Axes, bars: CalibrationBars) -> None:
    joint = np.arange(1, len(bars.value) + 1)
    axes.plot(joint, bars.before, color=COLORS[1], linestyle="--", linewidth=1.2, label="as designed")
    away = np.stack([bars.value - bars.low, bars.high - bars.value])
    axes.errorbar(
        joint, bars.value, yerr=away, color=COLORS[0], linestyle="", marker="o", markersize=4.0, capsize=3.0,
        label="fitted, with 95 % interval",
    )  # fmt: skip
    axes.set_yscale("log")
    axes.set_xticks(joint[::2])
    style_axes(axes, "Bending stiffness [N m/rad]", xlabel="Joint, 1 at the base")
    add_legend(axes, loc="best")


def _draw_errors(axes: Axes, bars: CalibrationBars) -> None:
    place = np.arange(len(bars.groups))
    for i, name in enumerate(_NAMES):
        drawn = axes.bar(place + 0.27 * (i - 1), 1e3 * bars.errors[:, i], width=0.25, color=COLORS[i], label=name)
        labels = ["-" if np.isnan(v) else f"{1e3 * v:.1f}" for v in bars.errors[:, i]]
        axes.bar_label(drawn, labels, fontsize=SMALL - 1.5, color=INK, padding=1.5)
    axes.set_xticks(place, [name.replace(" ", "\n", 1) for name in bars.groups])
    style_axes(axes, f"Mean RMSE, {'held out' if bars.is_held_out else 'fitted'} [mm]")
    axes.margins(y=0.25)
    add_legend(axes, loc="upper left")
