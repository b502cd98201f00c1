"""Three views of the trunk at one scale: in space, from the side and from the end."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from spiraltrunk.report.style import INK, NORMAL, SMALL, style_axes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIDE_VIEWS = (("side view", 0, "x [mm]"), ("end view", 2, "z [mm]"))
"""Title of each side view, index of the coordinate to the right, and its label."""


def add_views(figure: Figure, points: np.ndarray) -> tuple[Any, list[Any]]:
    """Add one axes in space and two side views that show the same cube round all points.

    ``points`` are in the frame of `Shape`, NaN where unknown, shape (..., 3) [mm]. Its y is up and its z points towards
    the viewer, so the axes in space take x, z, y. They are returned first, then those of `SIDE_VIEWS`.
    """
    points = points.reshape(-1, 3)
    least, most = np.nanmin(points, axis=0), np.nanmax(points, axis=0)
    half = 0.55 * float((most - least).max())
    low, high = (least + most) / 2 - half, (least + most) / 2 + half
    grid = figure.add_gridspec(1, 3, width_ratios=(1.25, 1.0, 1.0))
    space: Any = figure.add_subplot(grid[0], projection="3d")
    _frame_space(space, low, high)
    sides = []
    for column, (title, right, label) in enumerate(SIDE_VIEWS, start=1):
        axes = figure.add_subplot(grid[column])
        axes.set(xlim=(low[right], high[right]), ylim=(low[1], high[1]), aspect="equal")
        style_axes(axes, "y, up [mm]", xlabel=label, title=title)
        axes.spines[:].set_visible(True)
        sides.append(axes)
    return space, sides


def _frame_space(axes: Any, low: np.ndarray, high: np.ndarray) -> None:
    axes.set(xlim=(low[0], high[0]), zlim=(low[1], high[1]))
    axes.set_ylim(high[2], low[2])  # Reversed, as x, z, y would be a left-handed frame.
    axes.set_box_aspect((1, 1, 1), zoom=0.9)
    axes.view_init(elev=16, azim=-112)
    axes.set_xlabel("x [mm]", fontsize=NORMAL, color=INK)
    axes.set_ylabel("z [mm]", fontsize=NORMAL, color=INK)
    axes.text2D(0.10, 0.86, "y, up [mm]", transform=axes.transAxes, ha="center", fontsize=NORMAL, color=INK)
    axes.tick_params(labelsize=SMALL, colors=INK, pad=1.0)
    axes.tick_params(axis="z", pad=6.0)  # The labels would overlap the axis.
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
        axis.get_major_locator().set_params(nbins=4)
