"""What there is to draw of measured shapes beside a model's."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.errors import ShapeError


@final
@dataclass(frozen=True, kw_only=True)
class Judged:
    """Shapes of one run, or of several runs of one shape each, in the frame of `Shape`."""

    title: str
    """What they are."""
    labels: tuple[str, ...]
    """Name of each shape, such as its step or tilt."""
    label: str
    """What the names are, with their unit."""
    measured: np.ndarray
    """Measured points, not a number where unseen, shape (n, n_section, 3) [m]."""
    predicted: np.ndarray
    """Where the model says they are, shape (n, n_section, 3) [m]."""

    def __post_init__(self) -> None:
        shape = np.shape(self.measured)
        if len(shape) != 3 or shape[2] != 3 or shape != np.shape(self.predicted) or shape[0] != len(self.labels):
            told = f"measured {shape}, predicted {np.shape(self.predicted)}, {len(self.labels)} labels"
            raise ShapeError(f"{told}; allowed: (n, n_section, 3) twice and n labels, n from 1")
        if not shape[0] or not np.isfinite(self.predicted).all():
            raise ShapeError("no shapes, or predictions that are not finite; allowed: one shape or more")

    @property
    def distance(self) -> np.ndarray:
        """Distances of the points, not a number where unseen, shape (n, n_section) [m]."""
        apart: np.ndarray = np.linalg.norm(self.measured - self.predicted, axis=-1)
        return apart

    @property
    def sections(self) -> np.ndarray:
        """Indices of the sections that were seen, shape (k,) [-]."""
        return np.flatnonzero(np.isfinite(self.distance).any(axis=0))
