"""Plant: the interface of simulator and hardware.

A strategy sees nothing else. Observations hold what the real robot measures. Ground truth, such as the object's pose,
is known to the simulator only.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

from spiraltrunk.control.messages import Command, Observation

CONTROL_PERIOD = 0.02
"""Time between commands [s]: the 50 Hz at which a Python program can feed a Franka controller."""

TENSION_SLEW = 240.0
"""Largest rate of change of a winder's tension [N/s] (ours); a jump to full tension bends joints past their limit."""


class Plant(ABC):
    """A robot in its environment, advanced one control period at a time."""

    @property
    @abstractmethod
    def control_period(self) -> float:
        """Time between two commands [s]."""

    @abstractmethod
    def reset(self) -> Observation:
        """Restore the initial state of the task and return the first observation."""

    @abstractmethod
    def step(self, command: Command) -> Observation:
        """Execute a command for one control period and return the observation at its end.

        Raises:
            RunError: where the command is invalid (`read_command`), or the plant cannot continue.
        """
