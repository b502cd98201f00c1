"""Shaded pictures of meshes with a depth buffer: an exploded view, and a sheet of single parts."""

from __future__ import annotations

import math
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
    note: str = ""
    """A second line of text."""


def build_camera(azimuth: float, elevation: float) -> np.ndarray:
    """Rotation into the camera's frame (right, up, towards the camera), shape (3, 3).

    Args:
        azimuth: direction of the camera about z from x [rad].
        elevation: angle of the camera above the xy plane [rad].
    """
    ca, sa, ce, se = math.cos(azimuth), math.sin(azimuth), math.cos(elevation), math.sin(elevation)
    return np.array([[-sa, ca, 0.0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]])


def draw_solids(axes: Axes, solids: Sequence[DrawnSolid], view: np.ndarray, width: int) -> None:
    """Draw solids in parallel projection; the coordinates of the axes are those of the camera [mm].

    Args:
        axes: where to.
        solids: what to draw.
        view: rotation into the camera's frame, shape (3, 3).
        width: of the picture [px].
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


def write_exploded(solids: Sequence[DrawnSolid], paths: Sequence[Path], *, title: str) -> None:
    """Draw an exploded view with labels, z from left to right; each path's ending names its format.

    Raises:
        OSError: where a file cannot be written.
    """
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
    from matplotlib import rc_context

    for path in paths:
        with rc_context({"svg.hashsalt": "spiraltrunk"}):  # The same figure gives the same file.
            write_figure(figure, path, metadata={"Date": None})


def write_sheet(solids: Sequence[DrawnSolid], path: Path, *, title: str) -> None:
    """Draw each solid by itself, with its name and note, on one sheet.

    Raises:
        OSError: where the file cannot be written.
    """
    figure, grid = build_grid(len(solids), 5, (2.6, 2.9), title)
    view = build_camera(-math.pi / 2 + 0.6, 0.5)
    for axes, solid in zip(grid, solids, strict=True):
        wide, tall, _ = np.ptp(solid.mesh.vertices @ view.T, axis=0)
        draw_solids(axes, [solid], view, round(480 * min(1.0, wide / tall)))
        axes.set_box_aspect(1.0)
        axes.set_title(solid.name, fontsize=LARGE - 1, color=INK, pad=2)
        axes.text(0.5, -0.02, solid.note, transform=axes.transAxes, fontsize=SMALL, color=INK, ha="center", va="top")
    write_figure(figure, path)
