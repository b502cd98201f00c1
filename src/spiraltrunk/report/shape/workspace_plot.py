"""Figure of the workspace: all tip positions, and a slice along the plane in which the trunk hangs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from spiraltrunk.model.inverse.workspace import Workspace
from spiraltrunk.report.style import COLORS, INK, LIMIT, NORMAL, SMALL, add_legend, build_figure, style_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PathCollection
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

_SLICE = 0.01
"""Thickness of the slice [m]."""


def build_workspace_figure(workspace: Workspace, *, title: str = "") -> Figure:
    """Tips in space, left, and those near the plane z = 0, right [mm], coloured by the sum of tensions [N]."""
    from matplotlib.colors import LogNorm

    figure = build_figure(8.6, 5.4, title)
    grid = figure.add_gridspec(1, 2, width_ratios=[1.0, 1.0])
    space = figure.add_subplot(grid[0], projection="3d")
    plane = figure.add_subplot(grid[1])
    total = workspace.tension.sum(axis=1)
    order = np.argsort(-total)  # Little tension is drawn last, on top.
    most = float(total.max(initial=0.0)) or 1.0
    least = float(total[total > 0].min(initial=most))
    norm = LogNorm(min(least, 0.5 * most), most, clip=True)
    _add_space(space, workspace, order, norm)
    dots = _add_plane(plane, workspace, order, norm)
    bar = figure.colorbar(dots, ax=plane, shrink=0.85, pad=0.02)
    bar.set_label("Sum of the cables' tensions [N]", fontsize=NORMAL, color=INK)
    bar.ax.tick_params(labelsize=SMALL, colors=INK)
    bar.outline.set_visible(False)
    return figure


def _add_space(axes: Any, workspace: Workspace, order: np.ndarray, norm: Normalize) -> None:
    tip, rest = 1e3 * workspace.tip[order], 1e3 * _from_base(workspace)
    total = workspace.tension.sum(axis=1)[order]
    # Matplotlib's third axis points up, ours is y.
    axes.scatter(
        tip[:, 0], tip[:, 2], tip[:, 1], c=total, s=3, cmap="viridis", norm=norm, linewidths=0, depthshade=False
    )
    axes.plot(rest[:, 0], rest[:, 2], rest[:, 1], color=INK, linewidth=2.2)
    axes.set_aspect("equal")
    axes.view_init(elev=16, azim=-62)
    for axis, label in ((axes.xaxis, "x [mm]"), (axes.yaxis, "z [mm]"), (axes.zaxis, "y [mm]")):
        axis.set_label_text(label, fontsize=NORMAL, color=INK)
        axis.set_tick_params(labelsize=SMALL, colors=INK)
        axis.set_pane_color("#00000008")
    axes.zaxis.labelpad = 9.0
    axes.locator_params(axis="x", nbins=4)
    axes.locator_params(axis="y", nbins=4)
    axes.set_title(f"{len(tip)} equilibria", fontsize=NORMAL, color=INK)


def _add_plane(axes: Axes, workspace: Workspace, order: np.ndarray, norm: Normalize) -> PathCollection:
    from scipy.spatial import ConvexHull

    order = order[workspace.in_plane(_SLICE)[order]]
    tip, rest = 1e3 * workspace.tip[order], 1e3 * _from_base(workspace)
    dots = axes.scatter(
        tip[:, 0], tip[:, 1], c=workspace.tension.sum(axis=1)[order], s=9, cmap="viridis", norm=norm, linewidths=0
    )
    axes.plot(rest[:, 0], rest[:, 1], color=INK, linewidth=2.2, label="trunk, cables slack")
    axes.plot(0, 0, marker="s", color=INK, markersize=6, linestyle="none", label="base")
    circle = 1e3 * workspace.length * np.exp(1j * np.linspace(0, 2 * np.pi, 361))
    axes.plot(circle.real, circle.imag, color=LIMIT, linewidth=1.0, linestyle="--", label="trunk's length")
    if len(tip) > 2:
        corner = ConvexHull(tip[:, :2], qhull_options="QJ").vertices
        hull = tip[np.append(corner, corner[0])]
        axes.plot(hull[:, 0], hull[:, 1], color=COLORS[0], linewidth=1.0, linestyle=":", label="convex hull")
    title = f"Tips within {1e3 * _SLICE / 2:g} mm of the plane z = 0"
    style_axes(axes, "y, up [mm]", xlabel="x, dorsal where it hangs [mm]", title=title)
    axes.set_aspect("equal")
    low, high = np.minimum(tip[:, :2].min(axis=0), 0), np.maximum(tip[:, :2].max(axis=0), 0)
    room = 0.08 * (high - low).max()
    axes.set(xlim=(low[0] - room, high[0] + room), ylim=(low[1] - room, high[1] + room))
    axes.locator_params(axis="x", nbins=5)
    add_legend(axes, loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2)
    return dots


def _from_base(workspace: Workspace) -> np.ndarray:
    return np.vstack([np.zeros(3), workspace.rest])
