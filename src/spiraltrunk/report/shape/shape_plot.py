"""Figure of one shape of the trunk: in space, from the side and from the end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.model.kinematics.frames import base_orientation, section_frames
from spiraltrunk.model.kinematics.shape import Shape
from spiraltrunk.model.statics.pull_sequences import find_shut
from spiraltrunk.report.shape.views import SIDE_VIEWS, add_views
from spiraltrunk.report.style import COLORS, INK, NORMAL, add_legend_below, build_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_FACETS = 24
"""Facets round a section."""

_BODY, _EDGE, _SHUT, _SHUT_MARK = "#B8C4D0", "#5F6F80", "#CC79A7", "#8E2A6B"
"""Colours of sections, their outlines, faces that touch, and shut joints."""

_LEAD = 0.22
"""Length of the drawn base axis over the size of the trunk [-]."""

_BEHIND = 0.1
"""Median ratio of two cables' distance in a side view to that in space, below which one hides the other [-]."""

_DOT, _SPAN = (1.8, 4.0), 230.0
"""Least and largest diameter of a shut joint's dot, and size of a view [pt]."""

_DEPTHS = ((2, 1), (0, -1))
"""Coordinate towards the viewer in each of `SIDE_VIEWS`, and its sign."""


@final
@dataclass(frozen=True, kw_only=True)
class Solids:
    """Sections, cables and joints in space, in the frame of `Shape`."""

    outline: np.ndarray
    """Rings of each section base to tip: proximal joint centre, two rims, distal joint centre; shape (n_section, 4,
    n_facet, 3) [mm]."""
    cable: np.ndarray
    """Holes that each cable passes, base to tip, shape (n_cable, 2 n_section, 3) [mm]."""
    center: np.ndarray
    """Joint centres, shape (n_joint, 3) [mm]."""
    is_shut: np.ndarray
    """Whether each joint is at its limit, shape (n_joint,) [bool]."""
    axis: np.ndarray
    """Direction of the base axis, shape (3,) [-]."""

    @property
    def gaps(self) -> np.ndarray:
        """Cable segments across the gaps, shape (n_cable, n_joint, 2, 3) [mm]."""
        return np.stack([self.cable[:, 1:-1:2], self.cable[:, 2::2]], axis=2)


def build_solids(design: TrunkDesign, shape: Shape, theta_0: float) -> Solids:
    """Geometry of one shape with the base axis ``theta_0`` below the horizontal [rad]."""
    base = base_orientation(theta_0)
    frames = section_frames(design, shape.joint_rotation)
    turn, origin = base @ frames[:, :3, :3], frames[:, :3, 3] @ base.T

    def place(axial: np.ndarray, radial: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """Points of cylindrical coordinates (n_section, k) along directions (m, 3), shape (n_section, k, m, 3) [mm]."""
        local = axial[..., None, None] * np.array([1.0, 0.0, 0.0]) + radial[..., None, None] * direction
        return 1e3 * (np.einsum("nij,nabj->nabi", turn, local) + origin[:, None, None])

    solid, scale = design.solid, design.scale[:, None]
    angle = np.linspace(0.0, 2 * np.pi, _FACETS, endpoint=False)
    around = np.stack([np.zeros(_FACETS), np.cos(angle), np.sin(angle)], axis=-1)
    holes = place(design.hole_position[..., 0], design.hole_position[..., 1], design.cable_direction)
    return Solids(
        outline=place(
            scale * [0.0, solid.rim_start, solid.rim_end, solid.length],
            scale * [0.0, solid.radius, solid.radius, 0.0], around,
        ),
        cable=np.moveaxis(holes, 2, 0).reshape(design.n_cable, -1, 3), center=1e3 * origin[1:],
        is_shut=find_shut(design, shape), axis=base[:, 0],
    )  # fmt: skip


def build_shape_figure(design: TrunkDesign, shape: Shape, theta_0: float, *, title: str = "") -> Figure:
    """The trunk in space, left, and from the side and the end, right; one scale for all, in mm."""
    solids = build_solids(design, shape, theta_0)
    figure = build_figure(11.0, 4.7, title)
    size = float(np.ptp(solids.outline.reshape(-1, 3), axis=0).max())
    lead = np.stack([-_LEAD * size * solids.axis, np.zeros(3)])
    space, sides = add_views(figure, np.vstack([solids.outline.reshape(-1, 3), lead]))
    _draw_space(space, solids, lead)
    for axes, (_, right, _), depth in zip(sides, SIDE_VIEWS, _DEPTHS, strict=True):
        _draw_side(axes, solids, lead, right, depth)
    add_legend_below(figure, _handles(solids), columns=8)
    return figure


def _draw_space(axes: Any, solids: Solids, lead: np.ndarray) -> None:
    """Draw sections, cables, shut joints and base axis; the axes take x, z, y."""
    from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection  # type: ignore[import-untyped]

    seen = [0, 2, 1]
    axes.computed_zorder = False
    for quads, color in _faces(solids):
        axes.add_collection3d(Poly3DCollection(quads[..., seen], facecolors=color, alpha=0.30, linewidths=0, zorder=1))
    rims = solids.outline[:, 1:3].reshape(-1, solids.outline.shape[2], 3)
    rims = np.concatenate([rims, rims[:, :1]], axis=1)
    axes.add_collection3d(Line3DCollection(rims[..., seen], colors=_EDGE, linewidths=0.5, zorder=2))
    for cable, (line, gaps) in enumerate(zip(solids.cable, solids.gaps, strict=True)):
        axes.add_collection3d(Line3DCollection(line[None][..., seen], colors=_color(cable), linewidths=0.8, zorder=3))
        axes.add_collection3d(Line3DCollection(gaps[..., seen], colors=_color(cable), linewidths=2.4, zorder=4))
    shut, dots = solids.center[solids.is_shut], _size_dots(solids, 1.6 * float(np.ptp(axes.get_xlim())))
    axes.scatter(*shut[:, seen].T, s=dots**2, color=_SHUT_MARK, depthshade=False, linewidths=0.0, zorder=5)
    axes.plot(*lead[:, seen].T, color=INK, linestyle=(0, (4, 2)), linewidth=1.2, zorder=2)
    _draw_gravity(axes, 0.95)  # Down in space is down in this view.


def _draw_side(axes: Axes, solids: Solids, lead: np.ndarray, right: int, depth: tuple[int, int]) -> None:
    """Draw the same in one side view; ``depth`` is the coordinate towards the eye and its sign."""
    from matplotlib.collections import LineCollection, PolyCollection
    from scipy.spatial import ConvexHull

    seen, (toward, sign) = [right, 1], depth
    order = np.argsort(sign * solids.outline[..., toward].mean(axis=(1, 2)))
    rings = [solids.outline[section][..., seen].reshape(-1, 2) for section in order]
    hulls = [ring[ConvexHull(ring, qhull_options="QJ").vertices] for ring in rings]
    axes.add_collection(PolyCollection(hulls, facecolors=_BODY, edgecolors=_EDGE, alpha=0.45, linewidths=0.6, zorder=1))
    for cable, (line, gaps) in enumerate(zip(solids.cable[..., seen], solids.gaps[..., seen], strict=True)):
        apart = solids.cable[:cable] - solids.cable[cable]
        share = np.linalg.norm(apart[..., seen], axis=-1) / np.linalg.norm(apart, axis=-1)
        is_on_another = bool((np.median(share, axis=-1) < _BEHIND).any())  # Then dashes and every other gap are drawn.
        style = (0, (5, 5)) if is_on_another else "solid"
        axes.plot(*line.T, color=_color(cable), linewidth=0.8, linestyle=style, zorder=3)
        shown = gaps[1::2] if is_on_another else gaps
        axes.add_collection(LineCollection(list(shown), colors=_color(cable), linewidths=2.2, zorder=4))
    across, up = solids.center[solids.is_shut][:, seen].T
    dots = _size_dots(solids, float(np.ptp(axes.get_xlim())))
    axes.scatter(across, up, s=dots**2, color=_SHUT_MARK, linewidths=0.0, zorder=5)
    axes.plot(*lead[:, seen].T, color=INK, linestyle=(0, (4, 2)), linewidth=1.2, zorder=2)
    _draw_gravity(axes, 0.93 if solids.axis[right] > -0.01 else 0.07)  # Away from the base axis.


def _draw_gravity(axes: Any, place: float) -> None:
    axes.annotate(
        "g", (place, 0.80), (place, 0.97), xycoords="axes fraction", ha="center", va="top", fontsize=NORMAL, color=INK,
        arrowprops={"arrowstyle": "-|>", "color": INK},
    )  # fmt: skip


def _faces(solids: Solids) -> list[tuple[np.ndarray, str]]:
    """Quadrilaterals and their colour: both faces at a shut joint are marked."""
    ring, beside = solids.outline, np.roll(solids.outline, -1, axis=2)
    quads = np.stack([ring[:, :-1], ring[:, 1:], beside[:, 1:], beside[:, :-1]], axis=3)
    is_marked = np.zeros(quads.shape[:2], dtype=bool)  # Proximal face, outside and distal face of each section.
    is_marked[1:, 0] = is_marked[:-1, 2] = solids.is_shut
    return [(quads[~is_marked].reshape(-1, 4, 3), _BODY), (quads[is_marked].reshape(-1, 4, 3), _SHUT)]


def _handles(solids: Solids) -> list[Any]:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    cables = [Line2D([], [], color=_color(i), linewidth=2.4, label=f"cable {i + 1}") for i in range(len(solids.cable))]
    lines = [
        Line2D([], [], color=_EDGE, linewidth=2.4, solid_capstyle="butt", label="thick: in a gap"),
        Line2D([], [], color=INK, linestyle=(0, (4, 2)), linewidth=1.2, label="base axis"),
    ]
    if solids.is_shut.any():
        label = f"shut joint ({solids.is_shut.sum()})"
        lines.append(Line2D([], [], linestyle="", marker="o", markersize=4.0, color=_SHUT_MARK, label=label))
    return [Patch(facecolor=_BODY, edgecolor=_EDGE, label="section"), *cables, *lines]


def _size_dots(solids: Solids, size: float) -> np.ndarray:
    """Diameters of the shut joints' dots in a view ``size`` mm wide, shape (n_shut,) [pt]."""
    rim = solids.outline[1:, 1]
    radius = np.linalg.norm(rim - rim.mean(axis=1, keepdims=True), axis=-1).mean(axis=1)[solids.is_shut]
    least, most = _DOT
    return np.clip(radius * _SPAN / size * 2 / 3, least, most)


def _color(cable: int) -> str:
    return COLORS[cable % len(COLORS)]
