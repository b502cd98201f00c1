"""A calibration in one picture: stiffness joint by joint with its intervals, and the error on shapes not fitted."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, final

import numpy as np

from spiraltrunk.files.atomic import write_draft
from spiraltrunk.report.style import COLORS, DPI, INK, NORMAL, SMALL, add_look, build_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_NAMES = ("equilibrium, calibrated", "equilibrium, as designed", "paper's model, as designed")


@final
@dataclass(frozen=True, kw_only=True)
class Bars:
    """What is drawn."""

    before: np.ndarray
    """Stiffness of the joints as designed, shape (n_joint,) [N m/rad]."""
    value: np.ndarray
    """Fitted, shape (n_joint,) [N m/rad]."""
    low: np.ndarray
    """Lower ends of the 95 % intervals, shape (n_joint,) [N m/rad]."""
    high: np.ndarray
    """Upper ends, shape (n_joint,) [N m/rad]."""
    groups: tuple[str, ...]
    """Kinds of shapes."""
    errors: np.ndarray
    """Mean RMSE by kind and model (calibrated, as designed, paper's), not a number for none, (n_group, 3) [m]."""
    is_held_out: bool
    """Whether the shapes were not fitted."""
    title: str = "Calibration"
    """Head of the picture."""


def write_calibration(bars: Bars, path: str | Path) -> Path:
    """Draw it to a PNG.

    Raises:
        OSError: where the file cannot be written.
    """
    figure = build_calibration_figure(bars)
    with write_draft(path) as draft:
        figure.savefig(draft, dpi=DPI, format="png")
    return Path(path)


def build_calibration_figure(bars: Bars) -> Figure:
    """Stiffness left, errors right."""
    figure = build_figure(11.0, 4.2, bars.title)
    left, right = figure.subplots(1, 2)
    _draw_stiffness(left, bars)
    _draw_errors(right, bars)
    return figure


def _draw_stiffness(axes: Axes, bars: Bars) -> None:
    joint = np.arange(1, len(bars.value) + 1)
    axes.plot(joint, bars.before, color=COLORS[1], linestyle="--", linewidth=1.2, label="as designed")
    away = np.stack([bars.value - bars.low, bars.high - bars.value])
    axes.errorbar(
        joint, bars.value, yerr=away, color=COLORS[0], linestyle="", marker="o", markersize=4.0, capsize=3.0,
        label="fitted, with 95 % interval",
    )  # fmt: skip
    axes.set_yscale("log")
    axes.set_xticks(joint[::2])
    axes.set_xlabel("Joint, 1 at the base", fontsize=NORMAL, color=INK)
    add_look(axes, "Bending stiffness [N m/rad]")
    axes.legend(frameon=False, fontsize=SMALL, labelcolor=INK)


def _draw_errors(axes: Axes, bars: Bars) -> None:
    place = np.arange(len(bars.groups))
    for i, name in enumerate(_NAMES):
        drawn = axes.bar(place + 0.27 * (i - 1), 1e3 * bars.errors[:, i], width=0.25, color=COLORS[i], label=name)
        labels = ["-" if np.isnan(v) else f"{1e3 * v:.1f}" for v in bars.errors[:, i]]
        axes.bar_label(drawn, labels, fontsize=SMALL - 1.5, color=INK, padding=1.5)
    axes.set_xticks(place, [name.replace(" ", "\n", 1) for name in bars.groups])
    add_look(axes, f"Mean RMSE, {'held out' if bars.is_held_out else 'fitted'} [mm]")
    axes.margins(y=0.25)
    axes.legend(frameon=False, fontsize=SMALL, labelcolor=INK, loc="upper left")
