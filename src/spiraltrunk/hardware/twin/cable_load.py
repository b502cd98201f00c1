"""What the cables of a twin pull on: the simulated trunk, or a spring for tests of the motors alone."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence


class CableLoad(ABC):
    """The other end of the cables."""

    @abstractmethod
    def advance(self, wound: Sequence[float], stiffness: Sequence[float], dt: float) -> Sequence[float]:
        """Advance by ``dt`` [s] with so much cable on the drums, and return the mean tension of each cable.

        Args:
            wound: cable wound in since the straight, just taut trunk, per cable [m]; negative when paid out.
            stiffness: stiffness of each cable [N/m]; 0 of a cable that is broken.
            dt: step [s].

        Returns:
            Tension at each drum [N], never negative: a cable cannot push.
        """
