"""Static shapes of one trunk as a motion capture saw them: what recordings become and calibration reads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.checks import read_array, read_numbers
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError

KINDS = ("rest", "bend-dorsal", "bend-ventral", "twist")
"""What the cables did before a shape was held."""


@final
@dataclass(frozen=True, kw_only=True)
class MeasuredShapes:
    """Shapes at rest, in the order in which they were taken; arrays are finite but where nothing was seen.

    Frame: that of `Shape` (base of section 1 in the origin, y up), after registration.
    """

    kind: tuple[str, ...]
    """What was pulled, one of `KINDS`, one a shape."""
    take: tuple[str, ...]
    """Recording that each shape comes from; several where takes were averaged, joined by "+"."""
    theta_0: np.ndarray
    """Angle of the base axis below the horizontal as it was set, shape (n,) [rad]."""
    pull: np.ndarray
    """Cable that the winders were told to have pulled in since the straight trunk; not a number for a relaxed cable,
    which pays out freely, shape (n, n_cable) [m]."""
    follows: np.ndarray
    """Index of the shape from which the cables went on; -1 where they began slack at rest, shape (n,) [-]."""
    seat: np.ndarray
    """Distance of each section's measured point from the section's proximal joint, along its axis, (n_section,) [m]."""
    points: np.ndarray
    """Measured points of the sections, base to tip; not a number where unseen, shape (n, n_section, 3) [m]."""
    rotation: np.ndarray
    """Axes of the sections (x along the section, as columns); not a number where unseen, shape (n, n_section, 3, 3)."""

    def __post_init__(self) -> None:
        n, n_section = len(self.kind), np.size(self.seat)
        for kind in self.kind:
            if kind not in KINDS:
                raise ModelError(f"kind is {kind!r}; allowed: {', '.join(KINDS)}")
        if len(self.take) != n:
            raise ModelError(f"take has {len(self.take)} names for {n} shapes; allowed: one each")
        for name, size in (("theta_0", n), ("seat", n_section), ("follows", n)):
            read_numbers(name, getattr(self, name), shape=(size,))
        read_array("pull", self.pull, (n, np.shape(self.pull)[-1]))
        read_array("points", self.points, (n, n_section, 3))
        read_array("rotation", self.rotation, (n, n_section, 3, 3))
        for name in ("pull", "points", "rotation"):
            if np.isinf(getattr(self, name)).any():
                raise ModelError(f"{name} is infinite; allowed: finite numbers, or NaN where nothing was seen")
        self._check_follows()

    def _check_follows(self) -> None:
        follows = np.asarray(self.follows)
        wrong = np.flatnonzero((follows != np.rint(follows)) | (follows < -1) | (follows >= np.arange(len(follows))))
        if len(wrong):
            shape = int(wrong[0])
            raise ModelError(f"shape {shape} follows {follows[shape]:g}; allowed: -1, or a shape before it")


def compute_seat(design: TrunkDesign) -> np.ndarray:
    """Where the markers are on each section: its lower edge, the distal face's outer corner, shape (n_section,) [m]."""
    return design.solid.rim_end * design.scale
