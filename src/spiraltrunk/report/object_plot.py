"""Figure of an object: shaded, from the side with its widths by height, and in its stable poses."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from spiraltrunk.control.object_profile import ObjectProfile
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
"""Largest number of stable poses that are drawn."""

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
    poses = picture.profile.stable_poses[:POSES_MOST]
    figure = build_figure(10.5, 7.2 if poses else 4.6, picture.title)
    rows = figure.add_gridspec(2 if poses else 1, 1, height_ratios=[1.6, 1] if poses else [1])
    top = rows[0].subgridspec(1, 3, width_ratios=[1.05, 1, 1.15])
    low = float(picture.triangles[..., 2].min())
    standing = picture.triangles - [0.0, 0.0, low]
    _draw_shaded(figure.add_subplot(top[0]), standing)
    side = figure.add_subplot(top[1])
    _draw_side(side, standing, picture)
    _draw_widths(figure.add_subplot(top[2], sharey=side), picture)
    if poses:
        row = rows[1].subgridspec(1, POSES_MOST)
        for i, pose in enumerate(poses):
            axes = figure.add_subplot(row[i])
            _draw_shaded(axes, picture.triangles @ pose.rotation.T)
            tilt = math.degrees(pose.topple_angle)
            falls = f"falls over at {tilt:.0f} deg" if tilt > 0 else "rolls"
            axes.set_title(
                f"pose {i}: {100 * pose.probability:.1f} %\n{1e3 * pose.height:.0f} mm tall, {falls}",
                fontsize=SMALL, color=INK,
            )  # fmt: skip
    if picture.notes:
        figure.supxlabel("\n".join(picture.notes), fontsize=SMALL, color=INK, wrap=True, parse_math=False)
    return figure


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
    pad = 0.06 * float((high - low).max())
    axes.set_xlim(low[0] - pad, high[0] + pad)
    axes.set_ylim(low[1] - pad, high[1] + pad)
    axes.set_aspect("equal")


def _draw_side(axes: Axes, triangles: np.ndarray, picture: ObjectPicture) -> None:
    """Draw the view along y with the centre of mass and the width to grip."""
    _fill(axes, triangles, np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]))
    profile = picture.profile
    axes.axhline(0.0, color=INK, linewidth=0.8)
    x, z = 1e3 * picture.center[0], 1e3 * picture.center[2]
    axes.plot(x, z, marker="o", markersize=8, color="white", markeredgecolor=INK)
    axes.plot(x, z, marker="+", markersize=8, color=INK)
    axes.annotate("centre of mass", (x, z), xytext=(8, 6), textcoords="offset points", fontsize=SMALL, color=INK)
    axes.axhline(1e3 * profile.grip_height, color=COLORS[0], linewidth=1.0, linestyle="--")
    tilt = math.degrees(profile.topple_angle)
    title = f"falls over at a tilt of {tilt:.0f} deg" if tilt > 0 else "rolls"
    axes.set_aspect("equal", adjustable="datalim")
    style_axes(axes, "height [mm]", xlabel="x [mm]", title=title)


def _draw_widths(axes: Axes, picture: ObjectPicture) -> None:
    """Draw widths, and the girth as the diameter of a circle, over the height."""
    profile = picture.profile
    height = 1e3 * profile.height
    curves = (("least width", profile.width_least), ("largest width", profile.width_most),
              ("girth / pi", profile.girth / math.pi))  # fmt: skip
    for (label, values), color, style in zip(curves, COLORS, LINE_STYLES, strict=False):
        axes.plot(1e3 * values, height, color=color, linestyle=style, linewidth=1.6, label=label)
    axes.plot(1e3 * profile.grip_width, 1e3 * profile.grip_height, "o", color=COLORS[0], label="least width to grip")
    axes.set_xlim(left=0.0)
    title = f"grip {1e3 * profile.grip_width:.1f} mm wide at {1e3 * profile.grip_height:.0f} mm"
    style_axes(axes, xlabel="width [mm]", title=title)
    add_legend(axes, loc="best")
