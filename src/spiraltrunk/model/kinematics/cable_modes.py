"""Common and differential pulls of the cables: the mean of all, dorsal against ventral, and one side against the other.

To first order in the bend, a cable at the angle phi round the axis shortens by c + a cos(phi) + b sin(phi): c winds all
in alike, a bends the trunk dorsal, b bends it to the side. The modes are such weighted sums of the pulls, in which the
weights of each side of a difference add up to 1: with the paper's three cables the mean, cable 1 minus the mean of
cables 2 and 3, and cable 2 minus cable 3, which twists a trunk that cable 1 has bent.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.checks import check_count, read_numbers
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.field_docs import explain_fields

_LEAST = 1e-9
"""Weight below which a cable has no part in a difference [-]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class CableModes:
    """Modes of a trunk's cables."""

    names: tuple[str, ...]
    """Name of each mode, the mean first; a difference that the arrangement of the cables cannot make is left out."""
    weights: np.ndarray
    """Weight of each cable's pull in each mode, shape (n_mode, n_cable) [-]."""

    def read(self, pull: ArrayLike) -> np.ndarray:
        """Value of each mode, shape (n_mode,) [m].

        Args:
            pull: pull of each cable, shape (n_cable,) [m].

        Raises:
            ModelError: for numbers that are not finite, or of another count.
        """
        return self.weights @ read_numbers("pull", pull, shape=(self.weights.shape[1],), unit="m")

    def change(self, pull: ArrayLike, mode: int, value: float) -> np.ndarray:
        """Pulls with one mode changed and the others kept, by the least change of the pulls, shape (n_cable,) [m].

        Args:
            pull: pull of each cable, shape (n_cable,) [m].
            mode: index of the mode.
            value: its new value [m].

        Raises:
            ModelError: for numbers that are not finite, or of another count.
            DesignError: for a mode that does not exist.
        """
        check_count("mode", mode, least=0, most=len(self.names) - 1)
        before = read_numbers("pull", pull, shape=(self.weights.shape[1],), unit="m")
        wanted = np.zeros(len(self.names))
        wanted[mode] = float(read_numbers("value", value, shape=(), unit="m")) - self.weights[mode] @ before
        return before + np.linalg.pinv(self.weights) @ wanted


def build_cable_modes(design: TrunkDesign) -> CableModes:
    """Modes of a design's cables."""
    count = design.n_cable
    rows = {"mean": np.full(count, 1 / count)}
    for name, side in (("dorsal - ventral", design.cable_direction[:, 1]), ("side", design.cable_direction[:, 2])):
        first, second = np.maximum(side, 0.0), np.maximum(-side, 0.0)
        if first.sum() > _LEAST and second.sum() > _LEAST:
            rows[name] = first / first.sum() - second / second.sum()
    return CableModes(names=tuple(rows), weights=np.stack(list(rows.values())))
