"""Deviations of measured shapes from a model: distances of points, and their root mean squares.

With d the distance between measured and predicted point of a section,

    RMSE of a shape = sqrt(mean of d^2 over its sections),   RMSE of a section = sqrt(mean of d^2 over the shapes),

over what was seen. The mean RMSE is the mean of the shapes' RMSE, the largest deviation the largest d.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, final

import numpy as np

from spiraltrunk.errors import ShapeError

PAPER: dict[str, Any] = {
    "source": "Huang et al., Grasping by Spiraling, npj Robotics 2025, Results, Model Validation",
    "what": "the authors' model against their robot; neither their recordings nor how they were aligned are public",
    "bend_dorsal": {"mean_rmse_m": 0.01041, "max_deviation_m": 0.03214},
    "rest": {
        "0": {"rmse_m": 0.00548},
        "45": {"rmse_m": 0.01057},
        "90": {"rmse_m": 0.01045},
        "135": {"rmse_m": 0.01986},
    },
}
"""The paper's figures, by tilt from hanging [deg] at rest."""


@final
@dataclass(frozen=True, kw_only=True)
class Deviation:
    """Distances of measured points from predicted ones."""

    distance: np.ndarray
    """Not a number where a section was not seen, shape (n, n_section) [m]."""
    turn: np.ndarray
    """Angle between measured and predicted axes, not a number where unknown, shape (n, n_section) [rad]."""

    @property
    def sections(self) -> list[int]:
        """Sections that were seen in some shape, from 1."""
        return [int(number) + 1 for number in np.flatnonzero(np.isfinite(self.distance).any(axis=0))]

    @property
    def per_shape(self) -> np.ndarray:
        """RMSE of each shape, shape (n,) [m]."""
        return _root_mean_square(self.distance, axis=1)

    @property
    def per_section(self) -> np.ndarray:
        """RMSE of each section, not a number where it was never seen, shape (n_section,) [m]."""
        return _root_mean_square(self.distance, axis=0)

    @property
    def mean_rmse(self) -> float:
        """Mean of the shapes' RMSE [m]."""
        return float(self.per_shape.mean())

    @property
    def max_rmse(self) -> float:
        """Largest RMSE of a shape [m]."""
        return float(self.per_shape.max())

    @property
    def max_deviation(self) -> float:
        """Largest distance of a section [m]."""
        return float(np.nanmax(self.distance))

    @property
    def mean_turn(self) -> float:
        """Mean angle between measured and predicted axes, not a number where none is known [rad]."""
        return float(np.nanmean(self.turn)) if np.isfinite(self.turn).any() else float("nan")


def compute_deviation(
    points: np.ndarray, predicted: np.ndarray, rotation: np.ndarray | None = None, target: np.ndarray | None = None
) -> Deviation:
    """Distances and turns of measured shapes from predicted ones.

    Args:
        points: measured, not a number where unseen, shape (n, n_section, 3) [m].
        predicted: shape (n, n_section, 3) [m].
        rotation: measured axes, shape (n, n_section, 3, 3) [-].
        target: predicted axes, the same shape [-].

    Raises:
        ShapeError: where shapes do not fit, or a shape has no point that was seen.
    """
    if points.shape != predicted.shape or points.ndim != 3:
        raise ShapeError(f"points have shape {points.shape}, predicted {predicted.shape}; allowed: equal, (n, k, 3)")
    distance = np.linalg.norm(points - predicted, axis=-1)
    unseen = np.flatnonzero(~np.isfinite(distance).any(axis=1))
    if len(unseen):
        raise ShapeError(f"shape {unseen[0] + 1} has no section that was seen; allowed: at least one")
    turn = np.full(distance.shape, np.nan)
    if rotation is not None and target is not None:
        trace = np.einsum("...ij,...ij->...", rotation, target)
        turn = np.arccos(np.clip((trace - 1) / 2, -1.0, 1.0))
    return Deviation(distance=distance, turn=turn)


def _root_mean_square(values: np.ndarray, axis: int) -> np.ndarray:
    with np.errstate(invalid="ignore"):  # A section that was never seen has no mean.
        root: np.ndarray = np.sqrt(np.nansum(values**2, axis=axis) / np.isfinite(values).sum(axis=axis))
    return root
