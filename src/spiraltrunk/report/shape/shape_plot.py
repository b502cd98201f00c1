"""One shape of the trunk, in three dimensions and from two sides."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.files.atomic import write_draft
from spiraltrunk.model.kinematics.shape import Shape
from spiraltrunk.report.shape.sections_3d import Solids, build_solids
from spiraltrunk.report.style import COLORS, DPI, INK, NORMAL, SMALL, build_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BODY, _EDGE, _SHUT, _SHUT_MARK = "#B8C4D0", "#5F6F80", "#CC79A7", "#8E2A6B"
"""Sections, their outlines, faces that meet and the joints between them."""

_LEAD = 0.22
"""Length of the base axis before the base, over the picture's size [-]."""

_BEHIND = 0.1
"""Median distance of two cables in a side view up to which one hides the other, over that in space [-]."""

_DOT, _SPAN = (1.8, 4.0), 230.0
"""Least and largest size of a shut joint's dot, a third of its section's, and of a whole view [pt]."""

_VIEWS = (("side view", 0, "x [mm]", 2, 1), ("end view", 2, "z [mm]", 0, -1))
"""Side views: name, coordinate to the right and its label, coordinate towards the eye and its sign there."""


def write_shape(design: TrunkDesign, shape: Shape, theta_0: float, path: str | Path, *, title: str = "") -> Path:
    """Draw one shape to a file, whose ending says the format.

    Raises:
        OSError: where the file cannot be written.
    """
    figure = build_shape_figure(design, shape, theta_0, title=title)
    with write_draft(path) as draft:
        figure.savefig(draft, dpi=DPI)
    return Path(path)


def build_shape_figure(design: TrunkDesign, shape: Shape, theta_0: float, *, title: str = "") -> Figure:
    """The trunk in space, left, and from the side and the front, right; one scale for all, in mm."""
    solids = build_solids(design, shape, theta_0)
    figure = build_figure(11.0, 4.7, title)
    grid = figure.add_gridspec(1, 3, width_ratios=(1.25, 1.0, 1.0))
    low, high = _find_box(solids)
    _draw_space(figure.add_subplot(grid[0], projection="3d"), solids, low, high)
    for column, view in enumerate(_VIEWS, start=1):
        _draw_side(figure.add_subplot(grid[column]), solids, low, high, view)
    figure.legend(
        handles=_handles(solids), loc="outside lower center", ncols=8, frameon=False, fontsize=SMALL, labelcolor=INK
    )
    return figure


def _find_box(solids: Solids) -> tuple[np.ndarray, np.ndarray]:
    """Corners of a cube round trunk and base axis [mm], so that each view has the same scale."""
    points = solids.outline.reshape(-1, 3)
    size = float(np.ptp(points, axis=0).max())
    points = np.vstack([points, -_LEAD * size * solids.axis])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    half = 0.54 * float(np.ptp(points, axis=0).max())
    return middle - half, middle + half


def _draw_space(axes: Any, solids: Solids, low: np.ndarray, high: np.ndarray) -> None:
    """The frame's y is up, so it takes the place of matplotlib's z, and z points to the viewer's side."""
    from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection  # type: ignore[import-untyped]

    seen = [0, 2, 1]
    faces = _faces(solids)
    quads, colors = np.concatenate([part for part, _ in faces]), [color for part, color in faces for _ in part]
    axes.computed_zorder = False
    axes.add_collection3d(Poly3DCollection(quads[..., seen], facecolors=colors, alpha=0.30, linewidths=0.0, zorder=1))
    rims = solids.outline[:, 1:3].reshape(-1, solids.outline.shape[2], 3)
    rims = np.concatenate([rims, rims[:, :1]], axis=1)
    axes.add_collection3d(Line3DCollection(rims[..., seen], colors=_EDGE, linewidths=0.5, zorder=2))
    for cable, (line, gaps) in enumerate(zip(solids.cable, solids.gaps, strict=True)):
        axes.add_collection3d(Line3DCollection(line[None][..., seen], colors=_color(cable), linewidths=0.8, zorder=3))
        axes.add_collection3d(Line3DCollection(gaps[..., seen], colors=_color(cable), linewidths=2.4, zorder=4))
    size = float(high[0] - low[0])
    shut, dots = solids.center[solids.is_shut], _size_dots(solids, 1.6 * size)
    axes.scatter(*shut[:, seen].T, s=dots**2, color=_SHUT_MARK, depthshade=False, linewidths=0.0, zorder=5)
    lead = -_LEAD * size * solids.axis
    axes.plot(*np.stack([lead, 0 * lead])[:, seen].T, color=INK, linestyle=(0, (4, 2)), linewidth=1.2, zorder=2)
    _draw_gravity(axes, 0.95)  # Down in space is down in this view.
    _frame_space(axes, low, high)


def _frame_space(axes: Any, low: np.ndarray, high: np.ndarray) -> None:
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(high[2], low[2])  # Turned round, as x, z, y would be a left-handed frame.
    axes.set_zlim(low[1], high[1])
    axes.set_box_aspect((1, 1, 1), zoom=0.9)
    axes.view_init(elev=16, azim=-112)
    for name, label in (("x", "x [mm]"), ("y", "z [mm]"), ("z", "")):
        getattr(axes, f"set_{name}label")(label, fontsize=NORMAL, color=INK)
        axes.locator_params(axis=name, nbins=5)
    axes.text2D(0.10, 0.86, "y, up [mm]", transform=axes.transAxes, ha="center", fontsize=NORMAL, color=INK)
    axes.tick_params(labelsize=SMALL, colors=INK, pad=1.0)
    axes.tick_params(axis="z", pad=6.0)  # Its labels stand on the axis otherwise.
    for pane in (axes.xaxis, axes.yaxis, axes.zaxis):
        pane.set_pane_color((1.0, 1.0, 1.0, 0.0))


def _draw_side(
    axes: Axes, solids: Solids, low: np.ndarray, high: np.ndarray, view: tuple[str, int, str, int, int]
) -> None:
    from matplotlib.collections import LineCollection, PolyCollection

    name, right, label, depth, sign = view
    seen = [right, 1]
    order = np.argsort(sign * solids.outline[..., depth].mean(axis=(1, 2)))
    for rank, section in enumerate(order):
        ring = solids.outline[section][..., seen].reshape(-1, 2)
        axes.add_collection(
            PolyCollection(
                [_hull(ring)], facecolors=_BODY, edgecolors=_EDGE, alpha=0.45, linewidths=0.6, zorder=1 + rank / 99
            )
        )
    size = float(high[0] - low[0])
    for cable, (line, gaps) in enumerate(zip(solids.cable[..., seen], solids.gaps[..., seen], strict=True)):
        apart = solids.cable[:cable] - solids.cable[cable]
        share = np.linalg.norm(apart[..., seen], axis=-1) / np.linalg.norm(apart, axis=-1)
        is_on_another = bool((np.median(share, axis=-1) < _BEHIND).any())  # Then both are seen, by turns.
        style = (0, (5, 5)) if is_on_another else "solid"
        axes.plot(*line.T, color=_color(cable), linewidth=0.8, linestyle=style, zorder=3)
        shown = gaps[1::2] if is_on_another else gaps
        axes.add_collection(LineCollection(list(shown), colors=_color(cable), linewidths=2.2, zorder=4))
    across, up = solids.center[solids.is_shut][:, seen].T
    axes.scatter(across, up, s=_size_dots(solids, size) ** 2, color=_SHUT_MARK, linewidths=0.0, zorder=5)
    lead = -_LEAD * size * solids.axis
    axes.plot([lead[right], 0.0], [lead[1], 0.0], color=INK, linestyle=(0, (4, 2)), linewidth=1.2, zorder=2)
    aside = 0.93 if solids.axis[right] > -0.01 else 0.07  # Away from the base axis.
    _draw_gravity(axes, aside)
    axes.set(xlim=(low[right], high[right]), ylim=(low[1], high[1]), aspect="equal")
    axes.set_title(name, fontsize=NORMAL, color=INK)
    axes.set_xlabel(label, fontsize=NORMAL, color=INK)
    axes.set_ylabel("y, up [mm]", fontsize=NORMAL, color=INK)
    axes.tick_params(labelsize=SMALL, colors=INK)
    axes.grid(visible=True, color="#00000018", linewidth=0.6)
    axes.set_axisbelow(True)


def _draw_gravity(axes: Any, place: float) -> None:
    axes.annotate(
        "g", (place, 0.80), (place, 0.97), xycoords="axes fraction", ha="center", va="top", fontsize=NORMAL, color=INK,
        arrowprops={"arrowstyle": "-|>", "color": INK},
    )  # fmt: skip


def _faces(solids: Solids) -> list[tuple[np.ndarray, str]]:
    """Quadrilaterals and their colour: both faces at a joint that is shut stand out."""
    bands, shut = solids.bands, solids.is_shut
    return [
        (bands[:, 1].reshape(-1, 4, 3), _BODY),
        (
            np.concatenate([bands[1:, 0][~shut], bands[:-1, 2][~shut], bands[:1, 0], bands[-1:, 2]]).reshape(-1, 4, 3),
            _BODY,
        ),
        (np.concatenate([bands[1:, 0][shut], bands[:-1, 2][shut]]).reshape(-1, 4, 3), _SHUT),
    ]


def _hull(points: np.ndarray) -> np.ndarray:
    """Corners of the convex hull of points in the plane, shape (n, 2)."""
    from scipy.spatial import ConvexHull

    return points[ConvexHull(points, qhull_options="QJ").vertices]


def _handles(solids: Solids) -> list[Any]:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    cables = [
        Line2D([], [], color=_color(cable), linewidth=2.4, label=f"cable {cable + 1}")
        for cable in range(len(solids.cable))
    ]
    lines = [Line2D([], [], color=_EDGE, linewidth=2.4, solid_capstyle="butt", label="thick: in a gap")]
    lines += [Line2D([], [], color=INK, linestyle=(0, (4, 2)), linewidth=1.2, label="base axis")]
    if solids.is_shut.any():
        lines.append(
            Line2D(
                [],
                [],
                linestyle="",
                marker="o",
                markersize=4.0,
                color=_SHUT_MARK,
                label=f"shut joint ({solids.is_shut.sum()})",
            )
        )
    return [Patch(facecolor=_BODY, edgecolor=_EDGE, label="section"), *cables, *lines]


def _size_dots(solids: Solids, size: float) -> np.ndarray:
    """Diameters of the shut joints' dots in a view ``size`` mm wide, shape (n_shut,) [pt]."""
    rim = solids.outline[1:, 1]
    radius = np.linalg.norm(rim - rim.mean(axis=1, keepdims=True), axis=-1).mean(axis=1)[solids.is_shut]
    least, most = _DOT
    return np.clip(radius * _SPAN / size * 2 / 3, least, most)


def _color(cable: int) -> str:
    return COLORS[cable % len(COLORS)]
