"""Pictures of solids: shaded views drawn by a depth buffer, as an exploded view and as a sheet of all parts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np

from spiraltrunk.files.atomic import atomic_file
from spiraltrunk.report.solids.rasterise import rasterise
from spiraltrunk.report.style import INK, LARGE, NORMAL, SMALL, build_figure

_FINE = 2
"""Pixels drawn for each that is kept, along each side."""

_LIGHT = np.array([-0.45, 0.6, 0.66]) / np.linalg.norm([-0.45, 0.6, 0.66])
"""Where the light comes from, seen from the camera: left, above, behind it."""


@final
@dataclass(frozen=True, kw_only=True)
class PictureSolid:
    """One solid of a picture."""

    name: str
    """What stands beside it."""
    corners: np.ndarray
    """Triangles, counter-clockwise from outside, shape (n, 3, 3) [mm]."""
    color: tuple[float, float, float]
    """Red, green and blue [-]."""
    note: str = ""
    """A second line of text."""


def draw_view(
    solids: Sequence[PictureSolid], width: int, *, azimuth: float, elevation: float
) -> tuple[np.ndarray, np.ndarray]:
    """Solids in parallel projection, z upwards in the picture.

    Args:
        solids: what is drawn.
        width: of the picture [px].
        azimuth: direction of the camera about z from x [rad].
        elevation: height of the camera above the xy plane [rad].

    Returns:
        Picture with red, green, blue and opacity, shape (height, width, 4), and each solid's middle in it, shape
        (n_solid, 2) [px].
    """
    view = _camera(azimuth, elevation)
    corners = np.concatenate([solid.corners for solid in solids]) @ view.T
    low, high = corners[..., :2].min(axis=(0, 1)), corners[..., :2].max(axis=(0, 1))
    scale = _FINE * width / max(high[0] - low[0], 1e-9) * 0.98
    size = np.ceil((high - low) * scale).astype(int) + 2 * _FINE
    corners = (corners - [*low, 0.0]) * scale + [_FINE, _FINE, 0.0]
    owner = np.repeat(np.arange(len(solids)), [len(solid.corners) for solid in solids])
    depth, face = rasterise(corners, int(size[0]), int(size[1]))
    picture = _shade(corners, face, depth, np.array([solid.color for solid in solids])[owner])
    middles = np.array([_middle(solid.corners @ view.T) for solid in solids])
    spots = (middles - low) * scale / _FINE
    spots[:, 1] = size[1] / _FINE - spots[:, 1]
    return _halve(picture[::-1]), spots


def write_exploded(solids: Sequence[PictureSolid], paths: Sequence[Path], *, title: str) -> None:
    """Draw an exploded view with names, along z from left to right; each file's ending chooses its format.

    Raises:
        OSError: where the file cannot be written.
    """
    lying = [_lie(solid) for solid in solids]
    picture, spots = draw_view(lying, 1700, azimuth=-math.pi / 2 + 0.5, elevation=0.45)
    height, width = picture.shape[:2]
    figure = build_figure(13.0, 13.0 * height / width + 1.8, title)
    axes = figure.add_subplot()
    axes.imshow(picture, interpolation="antialiased")
    axes.set_axis_off()
    named = [(solid.name, spot) for solid, spot in zip(solids, spots, strict=True) if solid.name]
    order = sorted(range(len(named)), key=lambda k: float(named[k][1][0]))
    for rank, k in enumerate(order):
        name, (x, y) = named[k]
        is_above = rank % 2 == 0
        axes.annotate(
            name, (x, y), (x, (-0.06 if is_above else 1.06) * height), fontsize=NORMAL + 1, color=INK, ha="center",
            va="bottom" if is_above else "top",
            arrowprops={"arrowstyle": "-", "color": "#777777", "linewidth": 0.7, "shrinkB": 0},
        )  # fmt: skip
    axes.set_xlim(-0.03 * width, 1.03 * width)
    axes.set_ylim(1.15 * height, -0.15 * height)
    for path in paths:
        _save(figure, path)


def write_sheet(solids: Sequence[PictureSolid], path: str | Path, *, title: str, columns: int = 5) -> None:
    """Draw each solid by itself, with its name and note, on one sheet.

    Raises:
        OSError: where the file cannot be written.
    """
    rows = math.ceil(len(solids) / columns)
    figure = build_figure(2.6 * columns, 2.9 * rows + 0.5, title)
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in grid:
        axes.set_axis_off()
    for axes, solid in zip(grid, solids, strict=False):
        view = _camera(-math.pi / 2 + 0.6, 0.5)
        seen = (solid.corners @ view.T)[..., :2]
        wide, tall = np.ptp(seen, axis=(0, 1))
        picture, _ = draw_view(
            [solid], max(40, round(480 * min(1.0, wide / tall))), azimuth=-math.pi / 2 + 0.6, elevation=0.5
        )
        axes.imshow(picture, interpolation="antialiased")
        axes.set_box_aspect(1.0)
        axes.set_title(solid.name, fontsize=LARGE - 1, color=INK, pad=2)
        axes.text(0.5, -0.02, solid.note, transform=axes.transAxes, fontsize=SMALL, color=INK, ha="center", va="top")
    _save(figure, path)


def _save(figure, path: str | Path) -> None:  # type: ignore[no-untyped-def]
    """Write it; the same figure gives the same file."""
    from matplotlib import rc_context

    told = {"Date": None} if Path(path).suffix == ".svg" else {}
    with atomic_file(path) as draft, rc_context({"svg.hashsalt": "spiraltrunk"}):
        figure.savefig(draft, dpi=150, metadata=told)


def _lie(solid: PictureSolid) -> PictureSolid:
    """The solid with z along x, x upwards."""
    turned = solid.corners[..., [2, 1, 0]] * [1.0, -1.0, 1.0]
    return PictureSolid(name=solid.name, corners=turned, color=solid.color, note=solid.note)


def _middle(corners: np.ndarray) -> np.ndarray:
    return (corners[..., :2].min(axis=(0, 1)) + corners[..., :2].max(axis=(0, 1))) / 2


def _camera(azimuth: float, elevation: float) -> np.ndarray:
    """Rows: to the right in the picture, up in it, towards the camera."""
    ca, sa, ce, se = math.cos(azimuth), math.sin(azimuth), math.cos(elevation), math.sin(elevation)
    return np.array([[-sa, ca, 0.0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]])


def _shade(corners: np.ndarray, face: np.ndarray, depth: np.ndarray, colors: np.ndarray) -> np.ndarray:
    """Colour by the light's angle, with dark lines where depth or direction jumps."""
    a, b, c = corners.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    normal = (normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)).astype(np.float32)
    is_there = face >= 0
    facing = normal[face] * is_there[..., None]
    light = 0.45 + 0.55 * np.clip(facing @ _LIGHT, 0.0, 1.0)
    picture = np.concatenate([colors.astype(np.float32)[face] * light[..., None], is_there[..., None]], axis=-1)
    edge = np.zeros(face.shape, dtype=bool)
    deep = np.where(is_there, depth, np.nan)
    for axis in (0, 1):
        jump = np.abs(np.diff(deep, axis=axis)) > 8.0
        border = np.diff(is_there.astype(int), axis=axis) != 0
        one, other = _pairs(facing, axis)
        bend = one[..., 0] * other[..., 0] + one[..., 1] * other[..., 1] + one[..., 2] * other[..., 2] < 0.8
        line = jump | border | bend
        first, second = [slice(None)] * 2, [slice(None)] * 2
        first[axis], second[axis] = slice(None, -1), slice(1, None)
        edge[tuple(first)] |= line
        edge[tuple(second)] |= line
    picture[edge & is_there, :3] *= 0.35
    return picture


def _pairs(field: np.ndarray, axis: int) -> tuple[np.ndarray, np.ndarray]:
    return (field[:-1], field[1:]) if axis == 0 else (field[:, :-1], field[:, 1:])


def _halve(picture: np.ndarray) -> np.ndarray:
    """The mean of each block of `_FINE` by `_FINE` pixels, colours weighted by opacity."""
    height, width = (n // _FINE for n in picture.shape[:2])
    blocks = picture[: height * _FINE, : width * _FINE].reshape(height, _FINE, width, _FINE, 4)
    alpha = blocks[..., 3:].mean(axis=(1, 3))
    color = (blocks[..., :3] * blocks[..., 3:]).mean(axis=(1, 3)) / np.maximum(alpha, 1e-9)
    return np.concatenate([color, alpha], axis=-1)
