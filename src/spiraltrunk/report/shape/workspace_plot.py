"""Figure of the workspace: all tip positions, and a slice along the plane in which the trunk hangs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from spiraltrunk.model.inverse.workspace import Workspace
from spiraltrunk.report.style import COLORS, INK, LIMIT, NORMAL, SMALL, add_legend, build_figure, style_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SLICE = 0.01
"""Thickness of the slice [m]."""


def build_workspace_figure(workspace: Workspace, *, title: str = "") -> Figure:
    """Tips in space, left, and those near the plane z = 0, right [mm], coloured by the sum of tensions [N]."""
    from matplotlib.colors import LogNorm

    figure = build_figure(8.6, 5.4, title)
    space: Any = figure.add_subplot(1, 2, 1, projection="3d")
    plane: Any = figure.add_subplot(1, 2, 2)
    total, tip = workspace.tension.sum(axis=1), 1e3 * workspace.tip
    most = float(total.max(initial=0.0)) or 1.0
    norm = LogNorm(min(float(total[total > 0].min(initial=most)), 0.5 * most), most, clip=True)
    trunk = 1e3 * np.vstack([np.zeros(3), workspace.rest])
    order = np.argsort(-total)  # Little tension is drawn last, on top.
    near = order[workspace.in_plane(_SLICE)[order]]
    for axes, chosen, seen, style in (
        (space, order, [0, 2, 1], {"s": 3, "depthshade": False}),  # Matplotlib's third axis points up, ours is y.
        (plane, near, [0, 1], {"s": 9}),
    ):
        dots = axes.scatter(*tip[chosen][:, seen].T, c=total[chosen], cmap="viridis", norm=norm, linewidths=0, **style)
        axes.plot(*trunk[:, seen].T, color=INK, linewidth=2.2, label="trunk, cables slack")
    _frame_space(space, len(tip))
    _frame_plane(plane, tip[near, :2], 1e3 * workspace.length)
    bar = figure.colorbar(dots, ax=plane, shrink=0.85, pad=0.02)
    bar.set_label("Sum of the cables' tensions [N]", fontsize=NORMAL, color=INK)
    bar.ax.tick_params(labelsize=SMALL, colors=INK)
    bar.outline.set_visible(False)
    return figure


def _frame_space(axes: Any, count: int) -> None:
    axes.set_aspect("equal")
    axes.view_init(elev=16, azim=-62)
    for axis, label in ((axes.xaxis, "x [mm]"), (axes.yaxis, "z [mm]"), (axes.zaxis, "y [mm]")):
        axis.set_label_text(label, fontsize=NORMAL, color=INK)
        axis.set_tick_params(labelsize=SMALL, colors=INK)
        axis.set_pane_color("#00000008")
    axes.zaxis.labelpad = 9.0
    axes.locator_params(axis="x", nbins=4)
    axes.locator_params(axis="y", nbins=4)
    axes.set_title(f"{count} equilibria", fontsize=NORMAL, color=INK)


def _frame_plane(axes: Axes, tip: np.ndarray, length: float) -> None:
    """Add base, circle of the trunk's length and convex hull of the tips (n, 2) [mm], and the frame round the tips."""
    from scipy.spatial import ConvexHull

    axes.plot(0, 0, marker="s", color=INK, markersize=6, linestyle="none", label="base")
    circle = length * np.exp(1j * np.linspace(0, 2 * np.pi, 361))
    axes.plot(circle.real, circle.imag, color=LIMIT, linewidth=1.0, linestyle="--", label="trunk's length")
    if len(tip) > 2:
        corner = ConvexHull(tip, qhull_options="QJ").vertices
        hull = tip[np.append(corner, corner[0])]
        axes.plot(*hull.T, color=COLORS[0], linewidth=1.0, linestyle=":", label="convex hull")
    title = f"Tips within {1e3 * _SLICE / 2:g} mm of the plane z = 0"
    style_axes(axes, "y, up [mm]", xlabel="x, dorsal where it hangs [mm]", title=title)
    axes.set_aspect("equal")
    low, high = np.minimum(tip.min(axis=0), 0), np.maximum(tip.max(axis=0), 0)
    room = 0.08 * (high - low).max()
    axes.set(xlim=(low[0] - room, high[0] + room), ylim=(low[1] - room, high[1] + room))
    axes.locator_params(axis="x", nbins=5)
    add_legend(axes, loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2)
