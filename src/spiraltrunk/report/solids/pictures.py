"""Pictures of the printed robot: its exploded view, and a sheet with one part of each kind; shaded, with edges."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, final

import numpy as np

from spiraltrunk.report.solids.rasterise import rasterise
from spiraltrunk.report.style import INK, LARGE, NORMAL, SMALL, build_figure, build_grid, write_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from PIL.Image import Image
    from trimesh import Trimesh

_COLORS = {
    "trunk": (0.62, 0.67, 0.74), "gripper": (0.86, 0.47, 0.41), "shells": (0.93, 0.78, 0.66),
    "moulds": (0.80, 0.80, 0.84), "housing": (0.42, 0.47, 0.55), "drums": (0.90, 0.72, 0.30),
    "horn": (0.90, 0.72, 0.30), "adapter": (0.55, 0.62, 0.55),
    "wedge": (0.66, 0.62, 0.74), "markers": (0.55, 0.72, 0.70),
}  # fmt: skip

_APART = 45.0
"""Gap between neighbours in the exploded view [mm]."""

_ORDER = ("adapter", "housing", "drum", "horn", "lid", "neck")
"""Parts before the trunk, from the arm on."""

_LIGHT = np.array([-0.45, 0.6, 0.66]) / np.linalg.norm([-0.45, 0.6, 0.66])
"""Direction of the light in the camera's frame: from the left, above and behind the camera."""

_FINE = 2
"""Drawn pixels for each pixel that is kept, along each side."""

_STEP, _BEND = 8.0, 0.6
"""Laplacian of the depth [px] and difference of a normal's component [-] from which on an edge is drawn."""


@final
@dataclass(frozen=True, kw_only=True)
class DrawnSolid:
    """One solid of a picture."""

    name: str
    """Its label; empty for none."""
    mesh: Trimesh
    """Surface in the frame of the picture [mm]."""
    color: tuple[float, float, float]
    """Red, green and blue [-]."""


@final
@dataclass(frozen=True, kw_only=True)
class PlacedPart:
    """One part and its place in the robot."""

    name: str
    """Its name."""
    group: str
    """Its group, which gives the colour."""
    count: int
    """How many the robot needs."""
    mesh: Trimesh
    """Surface in its own frame [mm]."""
    at: tuple[float, float, float]
    """Origin of its frame in that of the straight trunk [mm]."""
    turn: float
    """Rotation about x into the frame of the straight trunk [rad]."""

    def assembled(self) -> Trimesh:
        """Its surface in the frame of the straight trunk [mm]."""
        return _turn(self.mesh, self.turn, (1.0, 0.0, 0.0)).apply_translation(self.at)


def write_pictures(parts: Sequence[PlacedPart], folder: Path, *, title: str, n_cable: int) -> None:
    """Write ``parts.png``, and ``exploded.png`` and ``exploded.svg`` where more than one part can be exploded.

    Raises:
        OSError: where a file cannot be written.
    """
    kinds: dict[str, PlacedPart] = {}
    for part in parts:
        kinds.setdefault(part.name if part.group == "trunk" else re.sub(r"_\d+$", "", part.name), part)
    _write_sheet(list(kinds.values()), folder / "parts.png", f"{title}: parts")
    apart = explode(parts, n_cable)
    if len(apart) > 1:
        _write_exploded(apart, folder, f"{title}: taken apart")


def explode(parts: Sequence[PlacedPart], n_cable: int) -> list[DrawnSolid]:
    """The robot's parts pulled apart along its axis; shells lifted off their sections, a drum for each cable."""
    by_name = {part.name: part for part in parts}
    chain = [by_name[name] for name in _ORDER if name in by_name]
    chain += [part for part in parts if part.group in ("trunk", "gripper")]
    solids: list[DrawnSolid] = []
    shift, end = 0.0, -math.inf
    for part in chain:
        mesh = part.assembled()
        low, high = (float(z) for z in mesh.bounds[:, 2])
        shift = max(shift, end + _APART - low) if solids else shift
        count, plural = (n_cable, "s") if part.group == "drums" else (1, "")
        for k in range(count):
            copy = _turn(mesh, 2 * math.pi * k / count, (0.0, 0.0, 1.0))
            name = "" if k else part.name + plural
            solids.append(DrawnSolid(name=name, mesh=copy.apply_translation((0, 0, shift)), color=_COLORS[part.group]))
        for shell in parts if part.group == "trunk" else ():
            if shell.group == "shells" and low <= shell.at[2] < high:
                lifted = shell.assembled()
                lifted.apply_translation((1.9 * float(lifted.bounds[1, 0]) + 25.0, 0, shift))
                name = "" if any(solid.name == "shells" for solid in solids) else "shells"
                solids.append(DrawnSolid(name=name, mesh=lifted, color=_COLORS["shells"]))
        end = high + shift
    return solids


def _turn(mesh: Trimesh, angle: float, axis: tuple[float, float, float]) -> Trimesh:
    """A copy rotated about an axis through the origin by an angle [rad]."""
    from trimesh.transformations import rotation_matrix

    return mesh.copy().apply_transform(rotation_matrix(angle, axis))  # type: ignore[no-untyped-call]


def build_camera(azimuth: float, elevation: float) -> np.ndarray:
    """Rotation into the camera's frame (right, up, towards the camera), shape (3, 3).

    ``azimuth`` is the camera's direction about z from x, ``elevation`` its angle above the xy plane [rad].
    """
    ca, sa, ce, se = math.cos(azimuth), math.sin(azimuth), math.cos(elevation), math.sin(elevation)
    return np.array([[-sa, ca, 0.0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]])


def draw_solids(axes: Axes, solids: Sequence[DrawnSolid], view: np.ndarray, width: int) -> None:
    """Draw solids in parallel projection on axes in the camera's coordinates [mm].

    ``view`` is the rotation into the camera's frame, shape (3, 3); ``width`` is that of the picture [px].
    """
    corners = np.concatenate([solid.mesh.triangles for solid in solids]) @ view.T
    colors = np.repeat([solid.color for solid in solids], [len(solid.mesh.faces) for solid in solids], axis=0)
    (left, low), (right, high) = corners[..., :2].min(axis=(0, 1)), corners[..., :2].max(axis=(0, 1))
    scale = (_FINE * width - 2) / (right - left)
    size = _FINE * width, 2 + int(np.ceil(scale * (high - low)))
    corners = (corners - [left, low, 0.0]) * scale + [1.0, 1.0, 0.0]
    picture = _shade(corners, colors, size)
    pixel = 1 / scale
    extent = left - pixel, left + (size[0] - 1) * pixel, low - pixel, low + (size[1] - 1) * pixel
    axes.imshow(picture, extent=extent, interpolation="antialiased")
    axes.set_axis_off()


def _shade(corners: np.ndarray, colors: np.ndarray, size: tuple[int, int]) -> Image:
    """Picture of triangles (n, 3, 3) in pixels and their colours (n, 3): lit faces, dark edges, nothing behind."""
    from PIL import Image
    from scipy.ndimage import laplace, morphological_gradient

    depth, face = rasterise(corners, *size)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    is_solid = face >= 0
    facing = normals[face] * is_solid[..., None]
    light = 0.45 + 0.55 * np.clip(facing @ _LIGHT, 0.0, 1.0)
    is_edge = np.abs(laplace(np.where(is_solid, depth, -1e6))) > _STEP
    is_edge |= (morphological_gradient(facing, size=(3, 3, 1)) > _BEND).any(axis=-1)
    shaded = colors[face] * (light * np.where(is_edge, 0.35, 1.0))[..., None]
    pixels = np.round(255 * np.concatenate([shaded, is_solid[..., None]], axis=-1)).astype(np.uint8)
    return Image.fromarray(pixels[::-1]).reduce(_FINE)


def _write_exploded(solids: Sequence[DrawnSolid], folder: Path, title: str) -> None:
    """Draw the exploded view with labels, z from left to right, as PNG and SVG."""
    from matplotlib import rc_context

    lying = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
    view = build_camera(-math.pi / 2 + 0.5, 0.45) @ lying
    points = [solid.mesh.vertices @ view.T for solid in solids]
    width, height, _ = np.ptp(np.concatenate(points), axis=0)
    figure = build_figure(13.0, 13.0 * height / width + 1.8, title)
    axes = figure.add_subplot()
    draw_solids(axes, solids, view, 1700)
    left, right, low, high = axes.axis()
    spots = [(points[k].min(axis=0) + points[k].max(axis=0)) / 2 for k in range(len(solids))]
    labels = sorted((float(spot[0]), float(spot[1]), solid.name) for spot, solid in zip(spots, solids, strict=True))
    for rank, (x, y, name) in enumerate(label for label in labels if label[2]):
        is_above = rank % 2 == 0
        axes.annotate(
            name, (x, y), (x, high + 0.06 * height if is_above else low - 0.06 * height), fontsize=NORMAL + 1,
            color=INK, ha="center", va="bottom" if is_above else "top",
            arrowprops={"arrowstyle": "-", "color": "#777777", "linewidth": 0.7, "shrinkB": 0},
        )  # fmt: skip
    axes.set(xlim=(left - 0.03 * width, right + 0.03 * width), ylim=(low - 0.15 * height, high + 0.15 * height))
    for ending in ("png", "svg"):
        with rc_context({"svg.hashsalt": "spiraltrunk"}):  # The same figure gives the same file.
            write_figure(figure, folder / f"exploded.{ending}", metadata={"Date": None})


def _write_sheet(parts: Sequence[PlacedPart], path: Path, title: str) -> None:
    """Draw each part by itself, with its name, size and number, on one sheet."""
    figure, grid = build_grid(len(parts), 5, (2.6, 2.9), title)
    view = build_camera(-math.pi / 2 + 0.6, 0.5)
    for axes, part in zip(grid, parts, strict=True):
        wide, tall, _ = np.ptp(part.mesh.vertices @ view.T, axis=0)
        solid = DrawnSolid(name=part.name, mesh=part.mesh, color=_COLORS[part.group])
        draw_solids(axes, [solid], view, round(480 * min(1.0, wide / tall)))
        axes.set_box_aspect(1.0)
        axes.set_title(part.name, fontsize=LARGE - 1, color=INK, pad=2)
        size = " x ".join(f"{value:.0f}" for value in part.mesh.extents) + " mm"
        note = f"{size}, {part.count} needed" if part.count > 1 else size
        axes.text(0.5, -0.02, note, transform=axes.transAxes, fontsize=SMALL, color=INK, ha="center", va="top")
    write_figure(figure, path)
