"""Cables that end at fixed points, for tests of motors without a trunk."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

from spiraltrunk.hardware.twin.cable_load import CableLoad

CABLE_DAMPING_TIME = 5e-4
"""Damping over stiffness of a cable [s] (ours): 2 % of critical with a GM6020's rotor on a drum of 10 mm."""


@final
class Anchor(CableLoad):
    """Cables tied to a wall: ``T = max(0, k e + k tau de/dt)`` with the elongation ``e = wound - slack > 0``."""

    def __init__(self, *slack: float, damping_time: float = CABLE_DAMPING_TIME) -> None:
        """Cables with so much slack when nothing is wound [m], 0 by default, and this damping over stiffness [s]."""
        self._slack, self._damping_time = slack, damping_time
        self._before: Sequence[float] | None = None

    def advance(self, wound: Sequence[float], stiffness: Sequence[float], dt: float) -> Sequence[float]:
        """Tension at each drum [N]; a wall does not move."""
        slack, rate = self._slack or (0.0,) * len(wound), self._damping_time / dt
        before, self._before = wound if self._before is None else self._before, tuple(wound)
        return [
            max(0.0, k * (w - s + rate * (w - w0))) if w > s else 0.0
            for w, w0, k, s in zip(wound, before, stiffness, slack, strict=True)
        ]
