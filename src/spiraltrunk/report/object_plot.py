"""Figure of an object: shaded, from the side with its widths by height, and in its stable poses."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from spiraltrunk.control.object_profile import ObjectProfile, StablePose
from spiraltrunk.report.style import (
    COLORS,
    INK,
    LINE_STYLES,
    SMALL,
    add_legend,
    build_figure,
    style_axes,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

POSES_MOST = 5
"""Largest number of stable poses that are drawn, those that are alike counted once."""

ALIKE = 0.02
"""Largest relative difference of the figures of stable poses that are drawn once (ours) [-]."""

MARGIN = 0.06
"""Margin of a drawing over its larger extent [-]."""

AZIMUTH, ELEVATION = math.radians(-55.0), math.radians(22.0)
"""Direction of the shaded views: about the vertical and above the ground [rad]."""

_LIGHT = np.array([0.35, 0.55, 0.75]) / np.linalg.norm([0.35, 0.55, 0.75])
_BODY = np.array([0.88, 0.48, 0.26])


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ObjectPicture:
    """An object as it rests, z up, the origin in the middle of its extents."""

    title: str
    """Line above the figure."""
    triangles: np.ndarray
    """Its surface, counter-clockwise from outside, shape (n, 3, 3) [m]."""
    profile: ObjectProfile
    """Sections by height, with the stable poses."""
    center: np.ndarray
    """Centre of mass, its height from the ground, shape (3,) [m]."""
    notes: tuple[str, ...] = ()
    """Lines below the figure."""


def build_object_figure(picture: ObjectPicture) -> Figure:
    """The object shaded, from the side, its widths by height, and its stable poses in a row."""
    poses = picture.profile.stable_poses
    groups = group_poses(poses)
    figure = build_figure(10.5, 7.2 if poses else 4.6, picture.title)
    rows = figure.add_gridspec(2 if poses else 1, 1, height_ratios=[1.6, 1] if poses else [1])
    top = rows[0].subgridspec(1, 3, width_ratios=[1.05, 1, 1.15])
    low = float(picture.triangles[..., 2].min())
    standing = picture.triangles - [0.0, 0.0, low]
    _draw_shaded(figure.add_subplot(top[0]), standing)
    side = figure.add_subplot(top[1])
    _draw_side(side, standing, picture)
    _draw_widths(figure.add_subplot(top[2]), picture)
    if groups:
        row = rows[1].subgridspec(1, POSES_MOST)
        for i, group in enumerate(groups[:POSES_MOST]):
            axes = figure.add_subplot(row[i])
            pose = poses[group[0]]
            _draw_shaded(axes, picture.triangles @ pose.rotation.T)
            axes.set_anchor("N")  # Titles side by side.
            axes.set_title(_title_poses(group, pose), fontsize=SMALL, color=INK)
    left_out = sum(len(group) for group in groups[POSES_MOST:])
    notes = [f"and {left_out} more stable pose{'s' if left_out > 1 else ''}"] if left_out else []
    notes += picture.notes
    if notes:
        figure.supxlabel("\n".join(notes), fontsize=SMALL, color=INK, wrap=True, parse_math=False)
    return figure


def group_poses(poses: Sequence[StablePose]) -> list[list[int]]:
    """Places of stable poses that are alike, such as mirror images: one group, one drawing.

    Alike are poses whose heights, angles of falling over and probabilities differ by less than `ALIKE`.
    """
    groups: list[list[int]] = []
    figures = [
        np.array([pose.height, pose.center_height, math.pi + pose.topple_angle, pose.probability]) for pose in poses
    ]
    for i, own in enumerate(figures):
        alike = (group for group in groups if np.allclose(own, figures[group[0]], rtol=ALIKE, atol=0.0))
        group = next(alike, None)
        if group is None:
            groups.append([i])
        else:
            group.append(i)
    return groups


def _title_poses(group: list[int], pose: StablePose) -> str:
    tilt = math.degrees(pose.topple_angle)
    falls = f"falls over at {tilt:.0f} deg" if tilt > 0 else "rolls"
    share = f"{100 * pose.probability:.1f} %"
    named = f"pose {group[0]}: {share}"
    if len(group) > 1:
        listed = f"{group[0]} to {group[-1]}" if len(group) > 3 else ", ".join(map(str, group))
        named = f"poses {listed}: {share} each"
    return f"{named}\n{1e3 * pose.height:.0f} mm tall\n{falls}"


def _draw_shaded(axes: Axes, triangles: np.ndarray) -> None:
    """Draw the triangles that face the viewer, the nearest last, on a line for the ground."""
    c, s = math.cos(AZIMUTH), math.sin(AZIMUTH)
    right, ahead = np.array([-s, c, 0.0]), np.array([c, s, 0.0])
    toward = math.cos(ELEVATION) * ahead + math.sin(ELEVATION) * np.array([0.0, 0.0, 1.0])
    up = np.cross(toward, right)
    _fill(axes, triangles, np.stack([right, up, toward]))
    axes.set_axis_off()


def _fill(axes: Axes, triangles: np.ndarray, view: np.ndarray) -> None:
    """Fill triangles with the colour of their inclination to the light.

    Args:
        axes: where to draw.
        triangles: shape (n, 3, 3) [m].
        view: the world's directions to the right, upwards and towards the viewer, as rows, shape (3, 3) [-].
    """
    from matplotlib.collections import PolyCollection

    seen = triangles @ view.T
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(normal, axis=1)
    faces = (normal @ view[2] > 0) & (length > 0)
    order = np.argsort(seen[faces, :, 2].mean(axis=1))
    light = (normal[faces] / length[faces, None]) @ (view.T @ (_LIGHT * [-1, 1, 1]))
    shade = (0.45 + 0.55 * np.clip(light, 0, 1))[order, None]
    colors = np.clip(_BODY * shade, 0, 1)
    corners = 1e3 * seen[faces][order][..., :2]
    axes.add_collection(PolyCollection(corners, facecolors=colors, edgecolors=colors, linewidths=0.4))
    flat = corners.reshape(-1, 2)
    low, high = flat.min(axis=0), flat.max(axis=0)
    pad = MARGIN * float((high - low).max())
    axes.set_xlim(low[0] - pad, high[0] + pad)
    axes.set_ylim(low[1] - pad, high[1] + pad)
    axes.set_aspect("equal")


def _draw_side(axes: Axes, triangles: np.ndarray, picture: ObjectPicture) -> None:
    """Draw the view across the length with the centre of mass and the width to grip."""
    _fill(axes, triangles, np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]))
    profile = picture.profile
    axes.axhline(0.0, color=INK, linewidth=0.8)
    x, z = 1e3 * picture.center[0], 1e3 * picture.center[2]
    axes.axhline(1e3 * profile.grip_height, color=COLORS[0], linewidth=1.6, linestyle="--", label="height of the grip")
    axes.plot(x, z, linestyle="", marker="o", markersize=8, color="white", markeredgecolor=INK, label="centre of mass")
    axes.plot(x, z, marker="+", markersize=8, color=INK)
    tilt = math.degrees(profile.topple_angle)
    title = f"falls over at a tilt of {tilt:.0f} deg" if tilt > 0 else "rolls"
    style_axes(axes, "height [mm]", xlabel="along its length [mm]", title=title)
    add_legend(axes, loc="upper center", bbox_to_anchor=(0.5, 0.0), borderaxespad=4.5, ncols=2)


def _draw_widths(axes: Axes, picture: ObjectPicture) -> None:
    """Draw widths, and the girth as the diameter of a circle, over the height."""
    profile = picture.profile
    height = 1e3 * profile.height
    curves = (("least width", profile.width_least), ("largest width", profile.width_most),
              ("girth / pi", profile.girth / math.pi))  # fmt: skip
    for (label, values), color, style in zip(curves, COLORS, LINE_STYLES, strict=False):
        axes.plot(1e3 * values, height, color=color, linestyle=style, linewidth=1.6, label=label)
    axes.plot(1e3 * profile.grip_width, 1e3 * profile.grip_height, "o", color=COLORS[0], label="least width to grip")
    axes.set_xlim(0.0, (1 + MARGIN) * 1e3 * float(max(values.max() for _, values in curves)))
    axes.set_ylim(-MARGIN * height[-1], (1 + MARGIN) * height[-1])
    title = f"grip {1e3 * profile.grip_width:.1f} mm wide at {1e3 * profile.grip_height:.0f} mm"
    style_axes(axes, "height [mm]", xlabel="width [mm]", title=title)
    add_legend(axes, loc="upper center", bbox_to_anchor=(0.5, 0.0), borderaxespad=4.5, ncols=2)
