"""How a recording is brought into the model's frame: by a rigid transformation, whose choice changes every error.

- ``base``: the rigid body at the trunk's base is put where the model's base is. Errors of base and model count in full.
- ``run``: one transformation a take, the best for all its shapes (Kabsch). Cameras and base do not move within a take.
- ``shape``: one for each shape, the best for it alone. It hides the most, such as a base that is tilted wrongly.

The last two may use some sections alone: ``shape:1-5`` puts the first five as well as it can, and the others follow.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import final

import numpy as np

from spiraltrunk.errors import ShapeError, TakeError

KINDS = ("base", "run", "shape")
"""Alignments by name."""

FEWEST = 3
"""Points that a transformation is fitted to at least [-]."""

_MOST_SECTIONS = 200
_THIN = 2e-3


@final
@dataclass(frozen=True, kw_only=True)
class Alignment:
    """Which transformation is fitted to what."""

    kind: str = "run"
    """One of `KINDS`."""
    sections: tuple[int, ...] = ()
    """Sections that it is fitted to, from 1; empty for all that are seen."""
    typed: str = field(default="", compare=False, repr=False)
    """What was typed, for messages; empty where nothing was."""

    def __str__(self) -> str:
        return self.kind + (f":{','.join(map(str, self.sections))}" if self.sections else "")

    @property
    def told(self) -> str:
        """As typed, else as written out."""
        return self.typed or str(self)

    def __post_init__(self) -> None:
        if self.kind not in KINDS or (self.sections and self.kind == "base"):
            raise TakeError(f"alignment is {self.told}; allowed: {_ALLOWED}")
        if self.sections and len(self.sections) < FEWEST:
            raise TakeError(f"alignment is {self.told}; allowed: {FEWEST} sections or more")


_ALLOWED = "base, run or shape; the last two also on chosen sections, such as run:1-5 or shape:1,3,8-10"


def read_alignment(text: str) -> Alignment:
    """The alignment that a text names.

    Raises:
        TakeError: for a text that names none.
    """
    kind, colon, rest = text.strip().lower().partition(":")
    sections: list[int] = []
    for part in rest.split(",") if colon else ():
        match = re.fullmatch(r"\s*([0-9]{1,3})(?:-([0-9]{1,3}))?\s*", part)
        first, last = (int(match[1]), int(match[2] or match[1])) if match else (0, 0)
        if not 1 <= first <= last <= _MOST_SECTIONS:
            order = f"; sections are 1 to {_MOST_SECTIONS} at most, the lower end of a range first" if match else ""
            raise TakeError(f"alignment is {text[:60]!r}; allowed: {_ALLOWED}{order}")
        sections.extend(range(first, last + 1))
    return Alignment(kind=kind[:40], sections=tuple(sorted(set(sections))), typed=text.strip()[:60])


@final
@dataclass(frozen=True, kw_only=True)
class Motion:
    """A rigid motion: points x go to rotation x + shift."""

    rotation: np.ndarray
    """Proper rotation, shape (3, 3) [-]."""
    shift: np.ndarray
    """Shape (3,) [m]."""

    def move(self, points: np.ndarray) -> np.ndarray:
        """Points after the motion, shape (..., 3) [m]."""
        moved: np.ndarray = points @ self.rotation.T + self.shift
        return moved


def fit_motion(points: np.ndarray, target: np.ndarray) -> Motion:
    """The rigid motion that brings points nearest to their targets, in the sense of least squares.

    Kabsch (1976): with H the covariance of the centred sets and H = U S V^T, the rotation is V diag(1, 1, d) U^T, d = 1
    or -1 so that it is proper. About the line of points that lie on one any turn is as good.

    Args:
        points: shape (..., 3) [m]; what is not a number is left out.
        target: where they belong, the same shape [m].

    Raises:
        ShapeError: where fewer than three points are left.
    """
    pairs = np.stack([np.reshape(points, (-1, 3)), np.reshape(target, (-1, 3))])
    pairs = pairs[:, np.isfinite(pairs).all(axis=(0, 2))]
    if pairs.shape[1] < FEWEST:
        raise ShapeError(f"{pairs.shape[1]} points seen to fit a rigid motion to; allowed: {FEWEST} or more")
    center = pairs.mean(axis=1, keepdims=True)
    one, other = pairs - center
    u, _, vt = np.linalg.svd(one.T @ other)
    sign = np.sign(np.linalg.det(u) * np.linalg.det(vt))
    rotation = vt.T @ np.diag([1.0, 1.0, sign]) @ u.T
    return Motion(rotation=rotation, shift=center[1, 0] - rotation @ center[0, 0])


def is_straight(points: np.ndarray) -> bool:
    """Whether points lie on a line within 2 mm, root mean square, so that a turn about it cannot be told.

    Args:
        points: finite, shape (n, 3) [m].
    """
    if len(points) < 3:
        return True
    sizes = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(np.sqrt((sizes[1:] ** 2).sum() / len(points)) < _THIN)


def frame_from_markers(markers: np.ndarray) -> np.ndarray:
    """Axes of sections by three markers on an edge each, 120 deg apart, counted from the dorsal one from y to z.

    x is the normal of the markers' plane, towards the tip; y points from their centre to marker 1, as far as it lies in
    that plane.

    Args:
        markers: markers 1 to 3 of each section, shape (..., 3, 3) [m].

    Returns:
        Axes as columns, shape (..., 3, 3) [-]; not a number where a marker is missing or all three are on a line.
    """
    first, second, third = np.moveaxis(markers, -2, 0)
    normal = np.cross(second - first, third - first)
    y = first - markers.mean(axis=-2)
    with np.errstate(invalid="ignore", divide="ignore"):
        x = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
        y = y - (x * y).sum(axis=-1, keepdims=True) * x
        y = y / np.linalg.norm(y, axis=-1, keepdims=True)
    axes = np.stack([x, y, np.cross(x, y)], axis=-1)
    axes[~np.isfinite(axes).all(axis=(-2, -1))] = np.nan
    return axes


def mean_rotation(rotation: np.ndarray) -> np.ndarray:
    """The rotation nearest to given ones, in the sense of least squares of their entries, shape (3, 3) [-].

    What is not a number is left out; without any the answer is not a number.

    Args:
        rotation: shape (n, 3, 3) [-].
    """
    seen = rotation[np.isfinite(rotation).all(axis=(1, 2))]
    if not len(seen):
        return np.full((3, 3), np.nan)
    u, _, vt = np.linalg.svd(seen.mean(axis=0))
    nearest: np.ndarray = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    return nearest


def rotation_from_quaternions(quaternion_wxyz: np.ndarray) -> np.ndarray:
    """Matrices of unit quaternions, shape (..., 3, 3) [-]."""
    w, x, y, z = np.moveaxis(quaternion_wxyz, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    matrix: np.ndarray = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    return matrix
