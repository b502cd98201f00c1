"""Devices of a twin, which a clock advances in steps."""

from __future__ import annotations

from abc import ABC, abstractmethod


class TwinDevice(ABC):
    """A simulated device: motors, watchdog, servo."""

    @abstractmethod
    def advance(self, dt: float) -> None:
        """Advance by ``dt`` [s]: read what arrived, integrate, answer."""
