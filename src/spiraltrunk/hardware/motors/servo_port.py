"""The gripper's servo: hobby PWM without feedback."""

from __future__ import annotations

from abc import ABC, abstractmethod


class ServoPort(ABC):
    """One servo that follows the width of a pulse."""

    @abstractmethod
    def set_pulse(self, pulse_us: float) -> None:
        """Command the width of the pulse [us].

        Raises:
            DriveError: where it is not finite or outside the limits measured at calibration, before anything is sent.
        """

    @abstractmethod
    def release(self) -> None:
        """Send no more pulses: the servo goes limp."""
