"""Cameras that frame trunk and object: near enough to fill the picture, far enough that nothing is cut."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import mujoco
import numpy as np

from spiraltrunk.sim.render import VISIBLE_GROUPS, View

FILL = 0.94
"""Width or height of trunk and object over that of the picture, whichever is larger [-] (ours)."""

ASPECTS = (4 / 3, 1.0, 4 / 5, 2 / 3, 1 / 2, 2 / 5)
"""Widths of a picture over its height that are tried [-] (ours)."""

_STEPS = 12
"""Iterations; each reduces the error by the ratio of the bodies' depth to the distance of the camera."""

_NEAR = 0.05
"""Least distance of a body from the camera [m] (ours)."""

_CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))


def frame_view(model: mujoco.MjModel, positions: Sequence[np.ndarray], view: View) -> View:
    """The view moved along and across its direction until trunk and object just fit over all positions.

    Args:
        model: the model to draw.
        positions: generalised positions, each of shape (n_q,).
        view: direction of view and size of the picture.
    """
    data = mujoco.MjData(model)
    points = np.concatenate([_find_corners(model, data, qpos) for qpos in positions])
    ahead, right, up = compute_axes(view)
    half = math.tan(math.radians(view.fovy) / 2)
    halves = np.array([half * view.width / view.height, half])
    lookat, distance = points.mean(axis=0), 3.0
    for _ in range(_STEPS):
        low, high = _project(points, _move(view, lookat, distance))
        across, upwards = (low + high) / 2 * halves * distance
        lookat = lookat + across * right + upwards * up
        nearest = _NEAR - float(((points - lookat) @ ahead).min())
        distance = max(nearest, distance * float(((high - low) / 2).max()) / FILL)
    return _move(view, lookat, distance)


def compute_fill(model: mujoco.MjModel, qpos: np.ndarray, view: View) -> float:
    """Part of the picture that the box round trunk and object covers in it [-]."""
    low, high = _project(_find_corners(model, mujoco.MjData(model), qpos), view)
    return float(np.prod(np.minimum(high, 1.0) - np.maximum(low, -1.0)) / 4)


def choose_size(model: mujoco.MjModel, groups: Sequence[Sequence[np.ndarray]], view: View) -> View:
    """The view with the size, of about as many pixels, in which trunk and object fill the emptiest picture most.

    Upright pictures suit a hanging trunk, wide ones a curled one.

    Args:
        model: the model to draw.
        groups: generalised positions, each of shape (n_q,), that share a view, for each view.
        view: direction of view and number of pixels.
    """
    pixels = view.width * view.height
    sizes = [(round(math.sqrt(pixels * aspect)), round(math.sqrt(pixels / aspect))) for aspect in ASPECTS]
    views = [replace(view, width=width, height=height) for width, height in sizes]

    def fill(each: View) -> float:
        framed = [(frame_view(model, group, each), group) for group in groups]
        return min(compute_fill(model, qpos, found) for found, group in framed for qpos in group)

    return max(views, key=fill)


def compute_axes(view: View) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit vectors ahead, to the right and up in the picture of MuJoCo's free camera, shape (3,) each [-]."""
    turn, rise = math.radians(view.azimuth), math.radians(view.elevation)
    ahead = np.array([math.cos(rise) * math.cos(turn), math.cos(rise) * math.sin(turn), math.sin(rise)])
    right = np.array([math.sin(turn), -math.cos(turn), 0.0])
    return ahead, right, np.cross(right, ahead)


def _project(points: np.ndarray, view: View) -> tuple[np.ndarray, np.ndarray]:
    """Box round points in the picture, shape (2,) each [-]: 1 and -1 are its edges, right and up positive."""
    ahead, right, up = compute_axes(view)
    offset, half = points - np.array(view.lookat), math.tan(math.radians(view.fovy) / 2)
    depth = np.maximum(offset @ ahead + view.distance, _NEAR)
    places = np.stack([offset @ right * view.height / view.width, offset @ up], axis=1) / depth[:, None] / half
    return places.min(axis=0), places.max(axis=0)


def _move(view: View, lookat: np.ndarray, distance: float) -> View:
    x, y, z = (float(value) for value in lookat)
    return replace(view, lookat=(x, y, z), distance=distance)


def find_geoms(model: mujoco.MjModel) -> np.ndarray:
    """Visible geoms of trunk, fingers and object, shape (n,)."""
    names = [model.body(int(body)).name for body in model.geom_bodyid]
    is_shown = [name == "object" or name.startswith(("section_", "finger_")) for name in names]
    return np.flatnonzero(np.array(is_shown) & np.isin(model.geom_group, VISIBLE_GROUPS))


def _find_corners(model: mujoco.MjModel, data: mujoco.MjData, qpos: np.ndarray) -> np.ndarray:
    """Corners of the geoms' bounding boxes in the world, shape (8 n, 3) [m]."""
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    geoms = find_geoms(model)
    center, half = model.geom_aabb[geoms, None, :3], model.geom_aabb[geoms, None, 3:]
    turns = data.geom_xmat[geoms].reshape(-1, 3, 3)
    corners = np.einsum("gij,gcj->gci", turns, center + half * _CORNERS) + data.geom_xpos[geoms, None, :]
    return np.asarray(corners.reshape(-1, 3))
