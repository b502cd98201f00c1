"""Planning model of the hook: the tip part of the trunk that stays closed round a standing object as the trunk opens.

As the ventral pull falls, joints open from the base on: a joint stays bent round the object while its free bend is at
least its bend round the object. The tip, whose joints are the weakest, opens last. Up to the first section that still
touches, the trunk is in free equilibrium.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.model.kinematics.enclosure import first_wrapped, snug_bend
from spiraltrunk.strategies.wrap.standing_model import cable_pulls, section_ends, shut_pull

SPAN = 7
"""Sections of the hook that tell its plane [-] (ours): about a turn."""


@final
@dataclass(frozen=True, kw_only=True)
class Hook:
    """Where the hook is, from the base, in the world's directions."""

    center: np.ndarray
    """Centre of an upright object in it, at the mean height of the hook, shape (3,) [m]."""
    normal: np.ndarray
    """Upward normal of its plane, shape (3,) [-]."""
    lowest: float
    """Height of the trunk's lowest point [m]."""


def find_first(design: TrunkDesign, width: float, pull: float) -> int:
    """First joint that stays bent round an object of ``width`` [m] at a ventral ``pull`` [N]; the last if none does."""
    snug = snug_bend(design, width)
    free = np.minimum(1.0, pull / shut_pull(design)) * design.joint_limit
    stays = np.flatnonzero(free >= snug - 1e-9)
    stays = stays[stays >= first_wrapped(snug)]
    return int(stays[0]) if stays.size else design.n_joint - 1


def find_hook(design: TrunkDesign, width: float, rotation: np.ndarray, pull: float) -> Hook:
    """The hook of a trunk with equal ventral cables.

    Args:
        design: the trunk.
        width: extent of the object across [m].
        rotation: orientation of the base in the world, shape (3, 3) [-].
        pull: ventral pull of the cables [N].
    """
    ends, first = section_ends(design, rotation, cable_pulls(design, pull, 0.0)), find_first(design, width, pull)
    part = ends[first : first + SPAN + 1]
    heading = (part[1] - part[0])[:2]
    to_object = np.array([heading[1], -heading[0], 0.0]) / max(float(np.linalg.norm(heading)), 1e-9)
    center = (part[0] + part[1]) / 2 + (width / 2 + design.section_radius[first]) * to_object
    normal = np.linalg.svd(part - part.mean(axis=0))[2][2]
    return Hook(
        center=np.array([*center[:2], part[:, 2].mean()]), normal=normal * math.copysign(1.0, float(normal[2])),
        lowest=float((ends[1:, 2] - design.section_radius).min()),
    )  # fmt: skip
