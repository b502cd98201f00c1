"""A fault of a motor, its drum or its cable."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from spiraltrunk.hardware.twin.motors import MotorTwins


class DeviceFault(ABC):
    """Settings of a fault of a device."""

    name: ClassVar[str]
    """Name in the catalogue."""

    @abstractmethod
    def begin(self, motors: MotorTwins) -> None:
        """Let it begin.

        Raises:
            DriveError: where these motors cannot have it, or not any more.
        """

    @abstractmethod
    def end(self, motors: MotorTwins) -> None:
        """Let it end; what it has done to lengths and angles stays."""

    def step(self, motors: MotorTwins, elapsed: float) -> bool:
        """What it does ``elapsed`` [s] after its beginning; True when it is over by itself."""
        return False
