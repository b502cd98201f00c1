"""What every model of the trunk answers with: one shape, or a batch of them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Any, TypeVar, final

import numpy as np


@final
class Status(IntEnum):
    """How a solution ended; ``advice`` says it in words and what to do."""

    CONVERGED = 0
    ALL_SHUT = 1
    STALLED = 2
    NOT_CONVERGED = 3
    OUT_OF_REACH = 4

    @property
    def advice(self) -> str:
        """What it means and what to do."""
        return _ADVICE[self]

    @staticmethod
    def worst(status: np.ndarray) -> Status:
        """The gravest of an array of statuses; CONVERGED for an empty one."""
        return Status(int(np.max(status, initial=Status.CONVERGED)))


_ADVICE = {
    Status.CONVERGED: "converged",
    Status.ALL_SHUT: "every joint is at its limit and cable is left over: pull less",
    Status.STALLED: "a cable reached its largest tension before its length: pull less, or raise the tension limit",
    Status.NOT_CONVERGED: "not converged, the shape is the best found: load in smaller increments, or start elsewhere",
    Status.OUT_OF_REACH: "the target is out of reach, the shape is the nearest found: see the distance left",
}


@final
@dataclass(frozen=True, kw_only=True)
class Forces:
    """With which forces a shape is in equilibrium; leading axes ``...`` are those of the batch."""

    cable_tension: np.ndarray
    """Tension at the winders, shape (..., n_cable) [N]."""
    gap_tension: np.ndarray
    """Tension of each cable across each gap, less than the winder's by friction, shape (..., n_joint, n_cable) [N]."""
    limit_reaction: np.ndarray
    """Moment with which the faces at each joint press on each other, shape (..., n_joint) [N m]."""
    tip_compliance: np.ndarray
    """Displacement of the tip per force on it, cables held as they are, shape (..., 3, 3) [m/N]."""
    residual: np.ndarray
    """Largest moment that is left at a joint, shape (...) [N m]."""


@final
@dataclass(frozen=True, kw_only=True)
class History:
    """What a later solution needs to go on from a shape."""

    bend: np.ndarray
    """Bends of the joints about y, z and x (torsion), shape (..., n_joint, 3) [rad]."""
    anchor: np.ndarray
    """Cable beyond each hole at which the hole holds nothing, shape (..., n_joint, n_cable) [m]."""


@final
@dataclass(frozen=True, kw_only=True)
class Shape:
    """Where the trunk is, what its cables did, and, from the equilibrium, with which forces.

    Frame: the base of section 1 in the origin, y up against gravity, the base axis in the plane z = 0 at theta_0 below
    the horizontal x (the authors' frame: 0 lies along +x, 90 deg hangs along -y); at roll 0 the dorsal side is in that
    plane too, towards +x where the trunk hangs. Leading axes ``...`` are those of the batch.
    """

    points: np.ndarray
    """Section ends, base to tip, shape (..., n_section, 3) [m]."""
    joint_rotation: np.ndarray
    """Turn of each section against the one before it, shape (..., n_joint, 3, 3) [-]."""
    joint_angle: np.ndarray
    """Angle between the axes of neighbouring sections, whatever its direction, shape (..., n_joint) [rad]."""
    gap: np.ndarray
    """Length of each cable across each joint's gap, shape (..., n_joint, n_cable) [m]."""
    cable_change: np.ndarray
    """Straight length minus length, positive = pulled in, shape (..., n_cable) [m]."""
    is_shut: np.ndarray
    """Whether the faces at each joint meet, shape (..., n_joint) [bool]."""
    status: np.ndarray
    """`Status` of each solution, shape (...) [-]."""
    forces: Forces | None = None
    """Forces, where the model knows them."""
    history: History | None = None
    """What a later solution can start from, where the model has one."""

    @property
    def advice(self) -> str:
        """The gravest status in words."""
        return Status.worst(self.status).advice


_Part = TypeVar("_Part", Shape, Forces, History)

_SETTERS = {kind: vars(kind)["__dict__"].__set__ for kind in (Shape, Forces, History)}


def build(kind: type[_Part], fields: dict[str, Any]) -> _Part:
    """A `Shape` or a part of one of all its fields, in a fourth of the time in which a frozen dataclass sets them."""
    part = object.__new__(kind)
    _SETTERS[kind](part, fields)
    return part
