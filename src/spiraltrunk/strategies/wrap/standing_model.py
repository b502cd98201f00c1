"""Planning model of a trunk that curls sideways round a standing object: position of the object from the trunk's base.

The base axis points ahead, at a tilt from hanging straight down; the ventral side points aside. Up to the first section
in contact, the trunk is in free equilibrium (`statics`), as the object stands loose and contact forces are negligible.
Vectors are level, from the base: (aside to ventral, ahead, up). Tests compare the predictions with the simulated trunk.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from spiraltrunk.control.messages import Target
from spiraltrunk.design.rules import graspable_range
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.model import statics
from spiraltrunk.model.kinematics.cables import planar_lever
from spiraltrunk.model.kinematics.frames import base_orientation
from spiraltrunk.strategies.moves import tilted_base
from spiraltrunk.strategies.object_measures import girth_width_between, height_of
from spiraltrunk.strategies.sensing import find_ventral
from spiraltrunk.strategies.wrap.hung_model import bisect, predict_wrap

_AHEAD = np.array([0.0, 1.0, 0.0])

_TILT_RANGE = math.radians(30.0), math.radians(150.0)
"""Range of the tilts sought [rad]: beyond it the trunk topples over or hangs."""

THIN, THIN_HEIGHT = 0.85, 0.178
"""Least width of a tall object that a wrap takes, over the least that the trunk's shape encloses, and least height of
such an object over the trunk's length [-] (ours): the sections need not close round it. Of 13 trials with drawn things
of 27.7 to 32.6 mm, 90 mm tall or more, 8 succeeded, of 13 with lower ones none."""


def cable_pulls(design: TrunkDesign, ventral: float, aside: float) -> np.ndarray:
    """Least tensions with the resultant ``ventral`` and, along the trunk's z, ``aside`` [N], shape (n_cable,) [N].

    Unequal ventral cables turn the plane of bending. Non-negative least squares.

    Raises:
        ModelError: where the cables cannot pull that way.
    """
    from scipy.optimize import nnls  # Takes 0.3 s: not at the start.

    across = design.cable_direction[:, 1:].T
    tension, missing = nnls(across, np.array([-ventral, aside]))
    if missing > 1e-9 * max(1.0, abs(ventral), abs(aside)):
        raise ModelError(f"no cables of {design.name} pull to ({ventral:g}, {aside:g}) N; allowed: three cables around")
    return np.asarray(tension)


def shut_pull(design: TrunkDesign) -> np.ndarray:
    """Ventral pull at which each joint reaches its limit, gravity apart, shape (n_joint,) [N].

    Raises:
        ModelError: where no cable pulls ventral.
    """
    ventral = find_ventral(design)
    lever = -planar_lever(design, np.full(design.n_joint, -design.joint_limit))[:, ventral].sum(axis=1)
    sum_pull = float(-design.cable_direction[ventral, 1].sum())
    return np.asarray(design.joint_stiffness * design.joint_limit / lever * sum_pull)


def cylinder_width(target: Target) -> float:
    """Width of an object, of a box that of the cylinder of the same girth, if the box is square [m]."""
    return target.width * (4 / math.pi if target.kind == "box" else 1.0)


def wrapped_width(target: Target) -> float:
    """Width of the cylinder of the same girth as a standing object in the middle half of its height [m]."""
    return cylinder_width(target) if target.profile is None else girth_width_between(target, *loop_band(target))


def loop_band(target: Target) -> tuple[float, float]:
    """Heights between which a full wrap goes round an object, from its foot [m]."""
    return 0.25 * height_of(target), 0.75 * height_of(target)


def girth_width(target: Target, height: float) -> float:
    """Diameter of the cylinder of an object's girth at a ``height`` [m] from its foot, by its profile if known [m]."""
    return cylinder_width(target) if target.profile is None else target.profile.at(height)[2] / math.pi


def least_width(design: TrunkDesign, height: float = math.inf) -> float:
    """Least width of a standing object of ``height`` [m] that a wrap takes [m]: less of a tall one (`THIN`)."""
    return (THIN if height >= THIN_HEIGHT * design.length else 1.0) * graspable_range(design).minimum


@lru_cache(maxsize=256)  # A plan asks for the same widths at every tilt and pull.
def wrap_start(design: TrunkDesign, width: float) -> int:
    """First section of a wrap round an object of ``width`` [m], counted from 0 at the base."""
    return min(predict_wrap(design, width, 0.0, 0.0).first, design.n_section - 1)


def object_center(
    design: TrunkDesign, width: float, tilt: float, tension: np.ndarray, section: int | None = None
) -> np.ndarray:
    """Centre of an upright object of ``width`` [m] that a section touches with its middle, level, shape (3,) [m].

    Args:
        design: the trunk.
        width: extent of the object across [m].
        tilt: of the base axis from hanging straight down [rad].
        tension: of the cables, shape (n_cable,) [N].
        section: which one, counted from 0 at the base; None is the first of a wrap.
    """
    ends = _ends(design, tilt, tension)
    first = wrap_start(design, width) if section is None else section
    heading = (ends[first + 1] - ends[first])[:2]
    to_object = np.array([heading[1], -heading[0], 0.0]) / max(float(np.linalg.norm(heading)), 1e-9)
    return (ends[first] + ends[first + 1]) / 2 + (width / 2 + design.section_radius[first]) * to_object


def band_heights(design: TrunkDesign, width: float, tilt: float, tension: np.ndarray) -> tuple[float, float]:
    """Mean height of the sections that wrap an object of ``width`` [m], and of their lowest point, from the base [m].

    Args:
        design: the trunk.
        width: extent of the object across [m].
        tilt: of the base axis from hanging straight down [rad].
        tension: of the cables, shape (n_cable,) [N].
    """
    first = wrap_start(design, width)
    ends = _ends(design, tilt, tension)[first:, 2]
    middle = (ends[:-1] + ends[1:]) / 2
    return float(middle.mean()), float((middle - design.section_radius[first:]).min())


def curl_tilt(design: TrunkDesign, width: float, tension: np.ndarray, slope: float) -> float:
    """Tilt of the base at which the curled trunk's plane falls ahead by ``slope`` [rad], 0 for level [rad]."""
    first = wrap_start(design, width)
    return bisect(lambda tilt: _fall_ahead(_ends(design, tilt, tension)[first:]) > slope, *_TILT_RANGE)


def section_ends(design: TrunkDesign, rotation: np.ndarray, tension: np.ndarray) -> np.ndarray:
    """Base and ends of all sections of the free trunk from its base, in the world's directions, shape (n + 1, 3) [m].

    The model's frame has its x level, in the vertical plane of the base axis, and its y up.

    Args:
        design: the trunk.
        rotation: orientation of the base in the world, shape (3, 3) [-]: x along the trunk, y dorsal.
        tension: of the cables, shape (n_cable,) [N].
    """
    down = math.asin(max(-1.0, min(1.0, -float(rotation[2, 0]))))
    level = rotation[:, 0] * [1.0, 1.0, 0.0] / max(math.cos(down), 1e-9)
    frame = np.column_stack([level, [0.0, 0.0, 1.0], np.cross(level, [0.0, 0.0, 1.0])])
    turned = base_orientation(down).T @ frame.T @ rotation
    loads = statics.Loads(mass=0.0 if design.gripper is None else design.gripper.mass)
    roll = math.atan2(float(turned[2, 1]), float(turned[1, 1]))
    shape = statics.solve(design, tension=tension, theta_0=down, roll=roll, loads=loads)
    return np.vstack([np.zeros(3), np.asarray(shape.points) @ frame.T])


def _ends(design: TrunkDesign, tilt: float, tension: np.ndarray) -> np.ndarray:
    """Base and ends of all sections, level, shape (n_section + 1, 3) [m]."""
    return section_ends(design, tilted_base(_AHEAD, tilt), tension)


def _fall_ahead(points: np.ndarray) -> float:
    """Slope ahead of the plane that fits points best, falling positive [rad]."""
    normal = np.linalg.svd(points - points.mean(axis=0))[2][2]
    return math.atan2(float(normal[1]), float(abs(normal[2]))) * (1.0 if normal[2] >= 0 else -1.0)
