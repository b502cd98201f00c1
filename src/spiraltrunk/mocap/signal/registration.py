"""Registration of recordings to the model's frame by rigid motions; the choice of the motion affects every error.

- ``base``: moves the rigid body at the trunk's base to the model's base. Errors of base and model count in full.
- ``run``: one least-squares motion for all shapes of a take (Kabsch). Cameras and base do not move within a take.
- ``shape``: one least-squares motion for each shape. It hides the most, such as a wrong tilt of the base.

The last two may be fitted to chosen sections: ``shape:1-5`` fits the first five sections.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.spatial.transform import Rotation

from spiraltrunk.errors import ShapeError, TakeError

KINDS = ("base", "run", "shape")
"""Alignments by name."""

FEWEST = 3
"""Least number of points for a fit [-]."""

_MOST_SECTIONS = 200
_THIN = 2e-3


@final
@dataclass(frozen=True, kw_only=True)
class Alignment:
    """Kind of motion, one of `KINDS`, and the sections it is fitted to."""

    kind: str = "run"
    sections: tuple[int, ...] = ()
    """Sections that it is fitted to, from 1; empty for all that are seen."""

    def __str__(self) -> str:
        return self.kind + (f":{','.join(map(str, self.sections))}" if self.sections else "")

    def __post_init__(self) -> None:
        if self.kind not in KINDS or (self.sections and self.kind == "base"):
            raise TakeError(f"alignment is {self}; allowed: {_ALLOWED}")
        if self.sections and len(self.sections) < FEWEST:
            raise TakeError(f"alignment is {self}; allowed: {FEWEST} sections or more")


_ALLOWED = "base, run or shape; the last two also on chosen sections, such as run:1-5 or shape:1,3,8-10"


def read_alignment(text: str) -> Alignment:
    """Parse an alignment.

    Raises:
        TakeError: for any other text.
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
    return Alignment(kind=kind[:40], sections=tuple(sorted(set(sections))))


@final
@dataclass(frozen=True, kw_only=True)
class Motion:
    """A rigid motion: points x go to rotation x + shift, shapes (3, 3) [-] and (3,) [m]."""

    rotation: np.ndarray
    shift: np.ndarray

    def move(self, points: np.ndarray) -> np.ndarray:
        """Points after the motion, shape (..., 3) [m]."""
        moved: np.ndarray = points @ self.rotation.T + self.shift
        return moved


def fit_motion(points: np.ndarray, target: np.ndarray) -> Motion:
    """The least-squares rigid motion of points to their targets.

    Kabsch (1976): with H the covariance of the centred sets and H = U S V^T, the rotation is V diag(1, 1, d) U^T, d = 1
    or -1 so that it is proper. For collinear points the rotation about their line is undetermined.

    Args:
        points: shape (..., 3) [m]; points that are not a number are left out.
        target: the same shape [m].

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
    """Whether finite points, shape (n, 3) [m], are collinear within 2 mm, root mean square."""
    sizes = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(np.sqrt((sizes[1:] ** 2).sum() / len(points)) < _THIN)


def frame_from_markers(markers: np.ndarray) -> np.ndarray:
    """Axes of sections as columns, not a number where a marker is missing or all three are collinear [-].

    x is the normal of the markers' plane, towards the tip; y is the direction from their centre to marker 1, projected
    onto that plane.

    Args:
        markers: three on an edge, 120 deg apart, from the dorsal one (y) towards z, shape (..., 3, 3) [m].
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
    """Least-squares mean of those of n rotations that are numbers, not a number without any, shape (3, 3) [-]."""
    seen = rotation[np.isfinite(rotation).all(axis=(1, 2))]
    return Rotation.from_matrix(seen).mean().as_matrix() if len(seen) else np.full((3, 3), np.nan)
