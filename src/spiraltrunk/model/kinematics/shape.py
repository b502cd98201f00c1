"""Shape: the result of every model of the trunk, single or a batch."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, TypeVar, final

import numpy as np

from spiraltrunk.field_docs import explain_fields

MOST_TURNED = 1e6
"""Largest angle that is accepted [rad]: beyond, an angle says little about a direction."""


@final
class Status(IntEnum):
    """Status of a solution; ``advice`` explains it."""

    CONVERGED = 0
    ALL_SHUT = 1
    STALLED = 2
    NOT_CONVERGED = 3
    OUT_OF_REACH = 4

    @property
    def advice(self) -> str:
        """Explanation and remedy in one line."""
        return _ADVICE[self]

    @staticmethod
    def worst(status: np.ndarray) -> Status:
        """The most severe of an array of statuses; CONVERGED for an empty one."""
        return Status(int(np.max(status, initial=Status.CONVERGED)))


_ADVICE = {
    Status.CONVERGED: "converged",
    Status.ALL_SHUT: "every joint is at its limit and cable is left over: pull less",
    Status.STALLED: "a cable reached its largest tension before its length: pull less, or raise the tension limit",
    Status.NOT_CONVERGED: "not converged, the shape is the best found: load in smaller increments, or start elsewhere",
    Status.OUT_OF_REACH: "the target is out of reach, the shape is the nearest found: see the distance left",
}


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Forces:
    """Forces of an equilibrium; leading axes ``...`` are those of the batch."""

    cable_tension: np.ndarray
    """Tension at the winders, shape (..., n_cable) [N]."""
    gap_tension: np.ndarray
    """Tension of each cable across each gap, after friction, shape (..., n_joint, n_cable) [N]."""
    limit_reaction: np.ndarray
    """Contact moment of the faces at each joint, shape (..., n_joint) [N m]."""
    tip_compliance: np.ndarray
    """Displacement of the tip per force on it, cables held by length or tension as solved, shape (..., 3, 3) [m/N]."""
    residual: np.ndarray
    """Largest residual moment at a joint, shape (...) [N m]."""

    @property
    def tip_stiffness(self) -> np.ndarray:
        """Force per displacement of the tip, the inverse of its compliance, shape (..., 3, 3) [N/m].

        Along directions with a compliance below 1 nm/N, such as the axis of the straight trunk, it is 1e9 N/m.
        """
        size, axes = np.linalg.eigh((self.tip_compliance + np.swapaxes(self.tip_compliance, -1, -2)) / 2)
        return np.einsum("...ij,...j,...kj->...ik", axes, 1 / np.maximum(size, 1e-9), axes)


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class History:
    """State from which a later solution can continue."""

    bend: np.ndarray
    """Bends of the joints about y, z and x (torsion), shape (..., n_joint, 3) [rad]."""
    anchor: np.ndarray
    """Cable length beyond each hole at which the hole's friction force is 0, shape (..., n_joint, n_cable) [m]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, repr=False)
class Shape:
    """Section ends, joints and cables of the trunk, and the forces of an equilibrium.

    Frame: the base of section 1 in the origin, y up against gravity, the base axis in the plane z = 0 at theta_0 below
    the horizontal x (the authors' frame: 0 lies along +x, 90 deg hangs along -y); at roll 0 the dorsal side is in that
    plane too, towards +x where the trunk hangs. Leading axes ``...`` are those of the batch.
    """

    points: np.ndarray
    """Section ends, base to tip, shape (..., n_section, 3) [m]."""
    joint_rotation: np.ndarray
    """Rotation of each section against the one before it, shape (..., n_joint, 3, 3) [-]."""
    joint_angle: np.ndarray
    """Angle between the axes of neighbouring sections, at least 0, shape (..., n_joint) [rad]."""
    gap: np.ndarray
    """Length of each cable across each joint's gap, shape (..., n_joint, n_cable) [m]."""
    cable_change: np.ndarray
    """Straight length minus length, positive = pulled in, shape (..., n_cable) [m]."""
    is_shut: np.ndarray
    """Whether the faces at each joint touch, shape (..., n_joint) [bool]."""
    status: np.ndarray
    """`Status` of each solution, shape (...) [-]."""
    forces: Forces | None = None
    """Forces, if the model computes them."""
    history: History | None = None
    """State for a later solution, if the model has one."""

    @property
    def advice(self) -> str:
        """The most severe status in words."""
        return Status.worst(self.status).advice

    def __repr__(self) -> str:
        sections, cables = self.points.shape[-2], self.cable_change.shape[-1]
        x, y, z = (describe_range(self.points[..., -1, axis]) for axis in range(3))
        parts = [
            f"{sections} sections", f"{cables} cables", f"tip x {x}, y {y}, z {z} m",
            f"pull {describe_range(self.cable_change)} m",
        ]  # fmt: skip
        return describe_batch(self, self.status, parts)


def describe_batch(part: object, status: np.ndarray, parts: list[str]) -> str:
    """One line: class, batch axes, ``parts``, and how many solutions have each status."""
    names = [Status(int(value)).name for value in np.ravel(status)]
    if np.ndim(status) == 0:
        return f"{type(part).__name__}({', '.join([*parts, *names])})"
    each = [f"{name} {count}" for name, count in sorted(Counter(names).items())]
    return f"{type(part).__name__}({', '.join([f'batch {np.shape(status)}', *parts, *each])})"


def describe_range(array: np.ndarray) -> str:
    """Least and largest number of an array, "0.012 to 0.5"; one number where both are the same."""
    if np.size(array) == 0:
        return "none"
    least, most = f"{np.min(array):.3g}", f"{np.max(array):.3g}"
    return least if least == most else f"{least} to {most}"


_Part = TypeVar("_Part", Shape, Forces, History)

_SETTERS = {kind: vars(kind)["__dict__"].__set__ for kind in (Shape, Forces, History)}


def build(kind: type[_Part], fields: dict[str, Any]) -> _Part:
    """A `Shape` or a part of one from all its fields; four times as fast as the frozen dataclass's own constructor."""
    part = object.__new__(kind)
    _SETTERS[kind](part, fields)
    return part
