"""Relation between the lengths of a trunk's cables that holds for every shape.

A joint i that is bent by q_i shortens its gap at a cable, whose direction makes the angle psi_i with the bend, by

    2 R_i (sin(delta / 2) (1 - cos(q_i / 2)) + cos(delta / 2) sin(q_i / 2) cos psi_i),   0 <= q_i <= delta,

with the distance R_i from joint to hole. So cable c with direction d_c takes in l_c = A + d_c . a with a vector a
across the trunk and a length A that is common to all cables. For a given |a|, A is least where all joints are bent
alike (1 - cos is convex in sin):

    A(a) = C sin(delta / 2) (1 - sqrt(1 - (|a| / (C cos(delta / 2)))^2)),   C = sum of 2 R_i,

and at most C sin(delta / 2) (1 - cos(delta / 2)): 4.4 mm on the paper's trunk, whose cables go 130 mm. The taper is
left out: for its sake a cable beside the plane of the bend takes in less, by up to a third of A.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from operator import mul
from typing import final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.field_docs import explain_fields

_ITERATIONS = 3
"""Fixed-point iterations for a [-]: dA/d|a| is at most tan(delta / 2)^2, 0.07 on the paper's trunk."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class CableRelation:
    """The relation of one trunk."""

    size: float
    """C, twice the sum of the distances from joints to holes [m]."""
    half_gap: float
    """Half of the angle of a gap, delta / 2 [rad]."""
    directions: tuple[tuple[float, float], ...]
    """Directions d_c across the trunk, shape (n_cable, 2) [-]."""
    inverses: tuple[tuple[tuple[float, ...], tuple[float, ...]], ...]
    """For each cable the pseudoinverse of the directions of the others, shape (n_cable, 2, n_cable) [-]; 0 for
    itself."""

    @classmethod
    def from_design(cls, design: TrunkDesign) -> CableRelation:
        """The relation of a design."""
        across = np.asarray(design.cable_direction[:, 1:], dtype=float)
        inverses = []
        for cable in range(len(across)):
            rows = np.insert(np.linalg.pinv(np.delete(across, cable, axis=0)), cable, 0.0, axis=1)
            inverses.append((tuple(rows[0].tolist()), tuple(rows[1].tolist())))
        return cls(
            size=2.0 * float(design.hole_to_joint.sum()), half_gap=design.delta_theta / 2,
            directions=tuple((float(y), float(z)) for y, z in across), inverses=tuple(inverses),
        )  # fmt: skip

    def compute_common(self, bend: float) -> float:
        """The least A for |a| = ``bend`` [m]; that of shut gaps beyond what the trunk can bend."""
        sine = min(bend / (self.size * math.cos(self.half_gap)), math.sin(self.half_gap))
        return self.size * math.sin(self.half_gap) * (1.0 - math.sqrt(1.0 - sine * sine))

    def compute_excess(self, lengths: tuple[float, ...]) -> tuple[float, ...]:
        """Excess of each cable over the length that follows from the others [m]; ``lengths``: taken in [m].

        The others give a by least squares, of least norm where they do not span the plane. Three cables have nearly
        the same excess: their sum less 3 A. It is 0 for bends alike but for the taper, at most
        3 C sin(delta / 2) (1 - cos(delta / 2)) for other shapes, less where a cable is slack, and grows by the length
        by which a cable slips.
        """
        excess = []
        for length, (p, q), (ys, zs), (per_y, per_z) in zip(
            lengths, self.directions, self.inverses, self._sums, strict=True
        ):
            y, z, common = sum(map(mul, ys, lengths)), sum(map(mul, zs, lengths)), 0.0
            for _ in range(_ITERATIONS):
                common = self.compute_common(math.hypot(y - common * per_y, z - common * per_z))
            excess.append(length - common - p * (y - common * per_y) - q * (z - common * per_z))
        return tuple(excess)

    @cached_property
    def _sums(self) -> tuple[tuple[float, float], ...]:
        """Sums of the inverses' rows."""
        return tuple((sum(ys), sum(zs)) for ys, zs in self.inverses)
