"""Measured and predicted shapes side by side, as the figures of a validation take them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np


@final
@dataclass(frozen=True, kw_only=True)
class ShapeComparison:
    """Shapes of one run, or of several runs of one shape each, in the frame of `Shape`."""

    title: str
    """Title of the figures."""
    labels: tuple[str, ...]
    """Label of each shape, such as its step or tilt."""
    label: str
    """Quantity and unit of the labels."""
    measured: np.ndarray
    """Measured points, NaN where unseen, shape (n, n_section, 3), n from 1 [m]."""
    predicted: np.ndarray
    """Points that the model predicts, shape (n, n_section, 3) [m]."""

    @property
    def distance(self) -> np.ndarray:
        """Distances of measured from predicted points, NaN where unseen, shape (n, n_section) [m]."""
        return np.asarray(np.linalg.norm(self.measured - self.predicted, axis=-1))

    @property
    def sections(self) -> np.ndarray:
        """Indices of the sections that were seen at least once, shape (k,) [-]."""
        return np.flatnonzero(np.isfinite(self.distance).any(axis=0))
