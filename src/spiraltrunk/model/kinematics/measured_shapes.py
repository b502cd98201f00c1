"""Static shapes of one trunk from motion capture, the input of a calibration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.checks import read_array, read_numbers
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.field_docs import explain_fields

KINDS = ("rest", "bend-dorsal", "bend-ventral", "twist")
"""Cable pulls that lead to a shape."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class MeasuredShapes:
    """Shapes at rest, in the order of their recording; points and rotations that were not measured are NaN.

    Frame: that of `Shape` (base of section 1 in the origin, y up), after registration.
    """

    kind: tuple[str, ...]
    """Cable pull of each shape, one of `KINDS`."""
    take: tuple[str, ...]
    """Recording of each shape; names of averaged takes are joined by "+"."""
    theta_0: np.ndarray
    """Nominal angle of the base axis below the horizontal, shape (n,) [rad]."""
    pull: np.ndarray
    """Commanded cable pull since the straight trunk, NaN for a cable that pays out freely, shape (n, n_cable) [m]."""
    follows: np.ndarray
    """Index of the shape from which loading continued; -1 for a start at rest with slack cables, shape (n,) [-]."""
    marker_offset: np.ndarray
    """Axial distance of each section's measured point from its proximal joint, shape (n_section,) [m]."""
    points: np.ndarray
    """Measured points of the sections, base to tip, shape (n, n_section, 3) [m]."""
    rotation: np.ndarray
    """Axes of the sections as columns, x along the section, shape (n, n_section, 3, 3) [-]."""

    def __post_init__(self) -> None:
        n, n_section = len(self.kind), np.size(self.marker_offset)
        for kind in self.kind:
            if kind not in KINDS:
                raise ModelError(f"kind is {kind!r}; allowed: {', '.join(KINDS)}")
        if len(self.take) != n:
            raise ModelError(f"take has {len(self.take)} names for {n} shapes; allowed: one each")
        for name, size in (("theta_0", n), ("marker_offset", n_section), ("follows", n)):
            read_numbers(name, getattr(self, name), shape=(size,))
        if np.ndim(self.pull) != 2:
            raise ModelError(f"pull has shape {np.shape(self.pull)}; allowed: a row of pulls for each of {n} shapes")
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


def compute_marker_offset(design: TrunkDesign) -> np.ndarray:
    """Axial distance from the proximal joints to the markers on the distal faces' corners, shape (n_section,) [m]."""
    return design.solid.rim_end * design.scale
