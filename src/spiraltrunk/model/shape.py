"""What every model of the trunk answers with: one shape, or a batch of them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import final

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


_ADVICE = {
    Status.CONVERGED: "converged",
    Status.ALL_SHUT: "every joint is at its limit and cable is left over: pull less",
    Status.STALLED: "a cable reached its largest tension before its length: pull less, or raise the tension limit",
    Status.NOT_CONVERGED: "not converged, the shape is the best found: load in smaller increments, or start elsewhere",
    Status.OUT_OF_REACH: "the target is out of reach, the shape is the nearest found: see the distance left",
}


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

    @property
    def advice(self) -> str:
        """The gravest status in words."""
        return Status(int(np.max(self.status))).advice
