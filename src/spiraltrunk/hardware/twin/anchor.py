"""Cables that end at fixed points, for tests of motors without a trunk."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

from spiraltrunk.hardware.twin.cable_load import CableLoad


@final
class Anchor(CableLoad):
    """Cables tied to a wall: ``T = max(0, k (wound - slack))``."""

    def __init__(self, *slack: float) -> None:
        """Cables with so much slack when nothing is wound [m]; 0 for the others."""
        self._slack = slack

    def advance(self, wound: Sequence[float], stiffness: Sequence[float], dt: float) -> Sequence[float]:
        """Tension at each drum [N]; a wall does not move."""
        slack = self._slack or (0.0,) * len(wound)
        return [max(0.0, k * (w - s)) for w, k, s in zip(wound, stiffness, slack, strict=True)]
