"""Plots of the study of the forward models."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from spiraltrunk.report.style import COLORS, DPI, INK, NORMAL, SMALL, build_figure, style_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LOOK = {
    "reference": {"color": INK, "linewidth": 2.4, "linestyle": "-"},
    "0": {"color": COLORS[5], "linestyle": "-", "marker": "o"},
    "0.1": {"color": COLORS[0], "linestyle": "--", "marker": "s"},
    "0.15": {"color": COLORS[2], "linestyle": "-.", "marker": "^"},
    "0.2": {"color": COLORS[4], "linestyle": "--", "marker": "v"},
    "0.4": {"color": COLORS[1], "linestyle": ":", "marker": "D"},
}
"""Line of each model, the same in every plot."""


def draw_bending(figures: dict[str, Any], path: Path) -> None:
    """What part of the cable each joint takes, and at which pull it is shut."""
    figure = build_figure(9.6, 3.9, "Bending while hanging: who takes the cable, and who shuts first")
    share, shut = figure.subplots(1, 2)
    joints = np.arange(1, len(figures["share"]["reference"]) + 1)
    for name in LOOK:
        _plot(share, joints, 100 * np.array(figures["share"][name]), name)
        _plot(shut, joints, np.array(figures["shut_mm"][name], float), name)
    for axes, label in ((share, "Share of the first 10 mm [%]"), (shut, "Pull at which the joint is shut [mm]")):
        _finish(axes, "Joint, 1 at the base, 17 at the tip", label)
    share.set_ylim(bottom=0.0)
    shut.set_ylim(0.0, 135.0)
    _write(figure, share, path)


def draw_distance(figures: dict[str, Any], path: Path) -> None:
    """Distance between the two models over the pull, by the base's angle."""
    figure = build_figure(9.6, 5.6, "Distance between the two models, dorsal pull (RMS over section ends)")
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    words = {"90": "90 deg: hanging", "0": "0 deg: lying", "45": "45 deg", "135": "135 deg: beyond the vertical"}
    for axes, (theta, title) in zip(panels.flat, words.items(), strict=True):
        for name in list(LOOK)[1:]:
            _plot(axes, figures["pull_mm"], np.array(figures["distance"][name][theta]["rms_mm"], float), name)
        axes.set_title(f"theta_0 = {title}", fontsize=NORMAL, color=INK)
        _finish(axes, "", "")
    for axes in panels[1]:
        axes.set_xlabel("Cable 1 pulled in from rest [mm]", fontsize=NORMAL, color=INK)
    for axes in panels[:, 0]:
        axes.set_ylabel("Distance [mm]", fontsize=NORMAL, color=INK)
    panels[0, 0].set_ylim(bottom=0.0)
    _write(figure, panels[0, 0], path)


def draw_twist(figures: dict[str, Any], path: Path) -> None:
    """Direction of bending along the trunk, and how far out of one plane by the order of pulling."""
    figure = build_figure(9.6, 4.1, "Twisting while hanging: cable 1 by 60 mm, cable 2 by 30 mm")
    direction, bars = figure.subplots(1, 2, width_ratios=(1.2, 1.0))
    twist = figures["twist"]
    joints = np.arange(1, len(twist["reference"]["direction_deg"]) + 1)
    for name in LOOK:
        _plot(direction, joints, np.array(twist[name]["direction_deg"]), name)
    _finish(
        direction, "Joint, 1 at the base, 17 at the tip", "Direction of bending [deg],\n0 to cable 1, 120 to cable 2"
    )
    names = [name for name in LOOK if name != "reference"]
    for shift, (order, shade) in enumerate(
        zip(("1 then 2", "2 then 1", "together"), ("#33566F", "#8FB1C7", "#D9D9D9"), strict=True)
    ):
        height = [twist[name]["orders"][order]["out_of_plane_mm"] for name in names]
        bars.bar(
            np.arange(len(names)) + 0.27 * (shift - 1),
            height,
            0.25,
            color=shade,
            edgecolor=INK,
            linewidth=0.5,
            label=order,
        )
    bars.axhline(twist["reference"]["out_of_plane_mm"], color=INK, linewidth=2.4, label="reference, 1 then 2")
    bars.set_xticks(range(len(names)), names)
    _finish(bars, "Friction mu [-]", "Out of the best plane, largest [mm]")
    bars.set_ylim(0.0, 1.45 * twist["reference"]["out_of_plane_mm"])
    bars.legend(fontsize=SMALL, frameon=False, ncols=2, loc="upper left", labelcolor=INK)
    _write(figure, direction, path)


def draw_shapes(shapes: dict[str, Any], path: Path) -> None:
    """Backbones over each other: bent, seen from the side, and twisted, from the side and from the end."""
    figure = build_figure(9.6, 4.6, "Backbones while hanging: cable 1 by 60 mm, and then cable 2 by 30 mm")
    views = (("dorsal", 0, "cable 1, side view", "x [mm]"), ("twist", 0, "both, side view", "x [mm]"),
             ("twist", 2, "both, end view", "z [mm]"))  # fmt: skip
    panels = figure.subplots(1, 3, sharey=True)
    for axes, (kind, right, title, label) in zip(panels, views, strict=True):
        for name, shape in shapes[kind].items():
            points = 1e3 * np.vstack([np.zeros(3), shape.points])
            _plot(axes, points[:, right], points[:, 1], name)
        axes.set_title(title, fontsize=NORMAL, color=INK)
        _finish(axes, label, "")
        axes.set(aspect="equal", xlim=(-45.0, 245.0))
    panels[0].set_ylabel("y, up [mm]", fontsize=NORMAL, color=INK)
    _write(figure, panels[0], path)


def _plot(axes: Axes, x: Any, y: np.ndarray, name: str) -> None:
    label = "reference (the paper)" if name == "reference" else f"equilibrium, mu = {name}"
    axes.plot(x, y, **{"markersize": 3.5, "linewidth": 1.2, **LOOK[name]}, label=label)


def _finish(axes: Axes, xlabel: str, ylabel: str) -> None:
    style_axes(axes, ylabel, xlabel=xlabel)


def _write(figure: Figure, axes: Axes, path: Path) -> None:
    figure.legend(
        *axes.get_legend_handles_labels(),
        loc="outside lower center",
        ncols=3,
        frameon=False,
        fontsize=SMALL,
        labelcolor=INK,
    )
    figure.savefig(path, dpi=DPI)
