"""What simulator and hardware both are: something that takes commands and gives observations.

A strategy sees nothing else. An observation holds what the real robot has (motor angles as cable lengths, motor
currents as tension estimates, arm joints), and the task as it was given; where the object truly is, only a simulator
knows.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

from spiraltrunk.control.messages import Command, Observation


class Plant(ABC):
    """A robot with its surroundings, advanced one control period at a time."""

    @property
    @abstractmethod
    def control_period(self) -> float:
        """Time between two commands [s]."""

    @abstractmethod
    def reset(self) -> Observation:
        """Bring everything to the start of the task and return the first observation."""

    @abstractmethod
    def step(self, command: Command) -> Observation:
        """Carry out a command for one control period and return what is seen then.

        Raises:
            RunError: where the command is none (`read_command`), or the plant cannot go on.
        """
