"""Planning model of a trunk wrapped round a hanging object, in one vertical plane.

The trunk hangs from its base and bends ventral. Beyond the first joint that touches, joints follow the object's outline
up to their limit. Before it, each joint balances cable tension, its own elasticity and the weights beyond it, without
friction and contact forces. Tests compare the predictions with the simulated trunk.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.checks import check_number
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.design.trunk import TrunkDesign, ventral_cables
from spiraltrunk.model.kinematics.cables import planar_gap, planar_lever
from spiraltrunk.model.kinematics.enclosure import first_wrapped, snug_bend
from spiraltrunk.model.kinematics.joint_limits import clip_bend

_ROUNDS = 30
"""Rounds of the damped iteration: enough where the cables carry the load; with less tension it need not settle."""


@final
@dataclass(frozen=True, kw_only=True)
class Wrap:
    """Shape of a wrapped trunk; lengths in the bending plane, from the base: down along its axis, ahead to ventral."""

    bend: np.ndarray
    """Ventral bend of each joint, shape (n_joint,) [rad]."""
    first: int
    """Index of the first wrapped joint."""
    center: np.ndarray
    """Centre of the object (down, ahead), shape (2,) [m]."""
    pull: np.ndarray
    """Cable pulled in since the straight trunk, shape (n_cable,) [m]."""


def predict_wrap(design: TrunkDesign, width: float, mass: float, tension: float) -> Wrap:
    """The trunk wrapped round an object of ``width`` [m] and ``mass`` [kg], all ventral cables at ``tension`` [N]."""
    check_number("width", width, above=0.0)
    check_number("mass", mass, least=0.0)
    bend = snug_bend(design, width)
    first = first_wrapped(bend)
    for _ in range(_ROUNDS):
        center = _object_center(design, bend, first, width)
        bend[:first] += 0.5 * (_balance(design, bend, tension, mass, center)[:first] - bend[:first])
    return Wrap(bend=bend, first=first, center=_object_center(design, bend, first, width), pull=_pull(design, bend))


def unrolled_center(design: TrunkDesign, width: float, pull: float) -> np.ndarray:
    """Centre (down, ahead) of an object of ``width`` [m] whose weight has unrolled the trunk, shape (2,) [m].

    Joints from the base on are straight and the others bent round the object, as many as leave the ventral cables the
    mean ``pull`` since the straight trunk [m].
    """
    snug, ventral = snug_bend(design, width), ventral_cables(design)
    pulls, centers = np.zeros(design.n_joint + 1), np.zeros((design.n_joint + 1, 2))
    for straight in range(design.n_joint + 1):
        bend = np.where(np.arange(design.n_joint) < straight, 0.0, snug)
        pulls[straight] = _pull(design, bend)[ventral].mean()
        centers[straight] = _object_center(design, bend, max(straight, first_wrapped(snug)), width)
    return np.array([np.interp(pull, pulls[::-1], centers[::-1, axis]) for axis in range(2)])


def free_curl(design: TrunkDesign, tension: ArrayLike) -> np.ndarray:
    """Mean pull of the ventral cables of a hanging trunk, each at ``tension`` [N], without contact, same shape [m]."""
    tensions = np.asarray(tension, float)
    bend = np.zeros((*tensions.shape, design.n_joint))
    for _ in range(_ROUNDS):
        bend += 0.5 * (_balance(design, bend, tensions[..., None], 0.0, np.zeros(2)) - bend)
    return np.asarray(_pull(design, bend)[..., ventral_cables(design)].mean(axis=-1))


def wrap_tension(design: TrunkDesign, width: float, mass: float, base_bend: float) -> float:
    """Tension at which joint 1 bends by ``base_bend`` [rad], of each ventral cable, at most the motors' largest [N].

    The trunk bears itself and an object of ``width`` [m] and ``mass`` [kg].
    """
    return bisect(
        lambda tension: predict_wrap(design, width, mass, tension).bend[0] < base_bend, 0.0, design.cable.tension_max
    )


def bisect(is_below: Callable[[float], bool], low: float, high: float) -> float:
    """Least value that `is_below` does not hold for, to 1/4096 of the interval."""
    for _ in range(12):
        middle = (low + high) / 2
        low, high = (middle, high) if is_below(middle) else (low, middle)
    return high


def _balance(
    design: TrunkDesign, bend: np.ndarray, tension: float | np.ndarray, mass: float, center: np.ndarray
) -> np.ndarray:
    """Bends at equilibrium of each joint's moments, within the limits, shape (..., n_joint) [rad]."""
    lever = -planar_lever(design, -bend)[..., ventral_cables(design)].sum(axis=-1)
    moment = tension * lever - _weight_moment(design, bend, mass, center)
    return clip_bend(moment / design.joint_stiffness, design.joint_limit)


def _weight_moment(design: TrunkDesign, bend: np.ndarray, mass: float, center: np.ndarray) -> np.ndarray:
    """Moment of the weights beyond each joint about it, opening positive, shape (..., n_joint) [N m]."""
    starts, heading = _backbone(design, bend)
    centers = starts[..., 1] + design.section_center * heading[..., 1]
    ahead = centers[..., None, :] - starts[..., 1:, None, 1]
    own = (_weights_beyond(design) * ahead).sum(axis=-1)
    load = mass * (center[1] - starts[..., 1:, 1]) if mass > 0 else 0.0
    return np.asarray(GRAVITY * (own + load))


@lru_cache(maxsize=16)
def _weights_beyond(design: TrunkDesign) -> np.ndarray:
    """Mass of each section where it lies beyond a joint, shape (n_joint, n_section) [kg]; never written to."""
    return np.asarray(np.triu(np.ones((design.n_joint, design.n_section)), k=1) * design.section_mass)


def _backbone(design: TrunkDesign, bend: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Proximal joint centres and directions (down, ahead) of all sections, shapes (..., n_section, 2) [m], [-]."""
    angle = np.cumsum(bend, axis=-1)
    angle = np.concatenate([np.zeros((*angle.shape[:-1], 1)), angle], axis=-1)
    heading = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    ends = np.cumsum(design.section_length[:, None] * heading, axis=-2)
    return np.concatenate([np.zeros_like(ends[..., :1, :]), ends[..., :-1, :]], axis=-2), heading


def _object_center(design: TrunkDesign, bend: np.ndarray, first: int, width: float) -> np.ndarray:
    """Centre of the circle that the first wrapped section touches with its middle (down, ahead), shape (2,) [m]."""
    n = min(first, design.n_section - 1)
    starts, heading = _backbone(design, bend)
    down, ahead = heading[n]
    room = design.section_length[n] / 2 / math.tan(design.joint_limit / 2)  # The tightest circle that joints allow.
    away = max(width / 2 + design.section_radius[n], room)
    return starts[n] + design.section_length[n] / 2 * heading[n] + away * np.array([-ahead, down])


def _pull(design: TrunkDesign, bend: np.ndarray) -> np.ndarray:
    return np.asarray(design.cable_stroke - planar_gap(design, -bend).sum(axis=-2))
