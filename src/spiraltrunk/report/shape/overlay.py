"""Measured shapes over a model's: in space, from the side and from the end."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from spiraltrunk.files.atomic import write_draft
from spiraltrunk.report.shape.comparison import Judged
from spiraltrunk.report.style import DPI, INK, NORMAL, SMALL, build_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_SHAPES = 5
"""Shapes in one picture, as in the paper's figure [-]."""

_VIEWS = (("side view", 0, "x [mm]"), ("end view", 2, "z [mm]"))


def write_overlay(judged: Judged, path: str | Path) -> Path:
    """Draw the shapes to a PNG.

    Raises:
        OSError: where the file cannot be written.
    """
    figure = build_overlay_figure(judged)
    with write_draft(path) as draft:
        figure.savefig(draft, dpi=DPI, format="png")
    return Path(path)


def choose_shapes(judged: Judged) -> list[int]:
    """Which shapes are drawn: first, last, the worst, and others evenly between, at most `MOST_SHAPES`."""
    count = len(judged.labels)
    distance = np.nan_to_num(judged.distance)
    worst = int(np.argmax(distance.max(axis=1)))
    even = [round(i) for i in np.linspace(0, count - 1, min(count, MOST_SHAPES))]
    if worst not in even:
        nearest = min(range(1, len(even) - 1), key=lambda i: abs(even[i] - worst))
        even[nearest] = worst
    return sorted(set(even))


def build_overlay_figure(judged: Judged) -> Figure:
    """Lines are the model, dots the recording, thin lines join them; one colour a shape, one scale for all, in mm."""
    chosen = choose_shapes(judged)
    from matplotlib import colormaps

    colors = [colormaps["viridis"](value) for value in np.linspace(0.0, 0.85, len(chosen))]
    figure = build_figure(11.0, 4.15, judged.title)
    grid = figure.add_gridspec(1, 3, width_ratios=(1.1, 1.0, 1.0))
    low, high = _find_box(judged, chosen)
    space: Any = figure.add_subplot(grid[0], projection="3d")
    flat = [figure.add_subplot(grid[i]) for i in (1, 2)]
    for shape, color in zip(chosen, colors, strict=True):
        line, dots = _trace(judged, shape)
        space.plot(*line[:, [0, 2, 1]].T, color=color, linewidth=1.4)
        space.plot(*dots[:, [0, 2, 1]].T, linestyle="", marker="o", markersize=3.0, color=color)
        for joined in np.stack([dots, line[1:]], axis=1):
            space.plot(*joined[:, [0, 2, 1]].T, color=color, linewidth=0.6, alpha=0.6)
        for axes, (_, right, _) in zip(flat, _VIEWS, strict=True):
            axes.plot(line[:, right], line[:, 1], color=color, linewidth=1.4)
            axes.plot(dots[:, right], dots[:, 1], linestyle="", marker="o", markersize=3.2, color=color)
            across = np.stack([dots, line[1:]])[:, :, [right, 1]]
            axes.plot(across[:, :, 0], across[:, :, 1], color=color, linewidth=0.6, alpha=0.6)
    _frame_space(space, low, high)
    for axes, view in zip(flat, _VIEWS, strict=True):
        _frame_flat(axes, view, low, high)
    figure.legend(
        handles=_handles(judged, chosen, colors), loc="outside lower center", ncols=len(chosen) + 2, frameon=False,
        fontsize=SMALL, labelcolor=INK,
    )  # fmt: skip
    return figure


def _trace(judged: Judged, shape: int) -> tuple[np.ndarray, np.ndarray]:
    """The model's line from the base on and the measured dots [mm]."""
    line = np.vstack([np.zeros(3), judged.predicted[shape]])
    return 1e3 * line, 1e3 * judged.measured[shape]


def _find_box(judged: Judged, chosen: list[int]) -> tuple[np.ndarray, np.ndarray]:
    parts = [part for shape in chosen for part in _trace(judged, shape)]
    points = np.vstack(parts)
    points = points[np.isfinite(points).all(axis=1)]
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    half = 0.56 * float(np.ptp(points, axis=0).max())
    return middle - half, middle + half


def _frame_space(axes: Any, low: np.ndarray, high: np.ndarray) -> None:
    """The frame's y is up, so it takes the place of matplotlib's z, and z points to the viewer's side."""
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(high[2], low[2])  # Turned round, as x, z, y would be a left-handed frame.
    axes.set_zlim(low[1], high[1])
    axes.set_box_aspect((1, 1, 1), zoom=1.0)
    axes.view_init(elev=16, azim=-112)
    axes.set_xlabel("x [mm]", fontsize=NORMAL, color=INK)
    axes.set_ylabel("z [mm]", fontsize=NORMAL, color=INK)
    axes.text2D(0.10, 0.93, "y, up [mm]", transform=axes.transAxes, ha="center", fontsize=NORMAL, color=INK)
    for name in ("x", "y", "z"):
        axes.locator_params(axis=name, nbins=4)
    axes.tick_params(labelsize=SMALL, colors=INK, pad=1.0)
    for pane in (axes.xaxis, axes.yaxis, axes.zaxis):
        pane.set_pane_color((1.0, 1.0, 1.0, 0.0))


def _frame_flat(axes: Axes, view: tuple[str, int, str], low: np.ndarray, high: np.ndarray) -> None:
    name, right, label = view
    axes.set(xlim=(low[right], high[right]), ylim=(low[1], high[1]), aspect="equal")
    axes.set_title(name, fontsize=NORMAL, color=INK)
    axes.set_xlabel(label, fontsize=NORMAL, color=INK)
    axes.set_ylabel("y, up [mm]", fontsize=NORMAL, color=INK)
    axes.tick_params(labelsize=SMALL, colors=INK)
    axes.grid(visible=True, color="#00000018", linewidth=0.6)
    axes.set_axisbelow(True)


def _handles(judged: Judged, chosen: list[int], colors: list[Any]) -> list[object]:
    from matplotlib.lines import Line2D

    kinds = [
        Line2D([], [], color=INK, linewidth=1.4, label="model"),
        Line2D([], [], color=INK, linestyle="", marker="o", markersize=3.2, label="recording"),
    ]
    word, _, unit = judged.label.lower().partition(" [")
    shapes = [
        Line2D([], [], color=color, linewidth=3.0, label=f"{word} {judged.labels[shape]} {unit.rstrip(']')}".rstrip())
        for shape, color in zip(chosen, colors, strict=True)
    ]
    return [*kinds, *shapes]
