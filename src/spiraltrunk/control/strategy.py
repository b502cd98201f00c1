"""What a strategy is: a pure function from what is seen and remembered to what is done."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Generic, TypeVar, final

from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.design.rules import graspable_range
from spiraltrunk.design.trunk import TrunkDesign

State = TypeVar("State")


@final
@dataclass(frozen=True, kw_only=True)
class Status:
    """Where a strategy stands."""

    phase: str
    """reach, prehension, transport or release."""
    action: str
    """What is being done within the phase."""
    is_done: bool = False
    """Whether the strategy has ended."""
    gave_up: str | None = None
    """Why it ended before its goal, if it did."""


class Strategy(ABC, Generic[State]):
    """A way to grasp. The state is passed in and out: the same inputs give the same outputs, on every plant."""

    name: str
    number: int
    """Number in the paper's figure of nine strategies."""
    stage: str = "hung"
    """What it is for: "hung", objects on strings, or "ground", objects that rest on the ground."""
    stance: str = "lying"
    """How its objects rest: "lying", their axis horizontal, or "upright"."""
    looks: bool = False
    """Whether it needs a camera's looks at the object; otherwise the announced place must do."""
    holds: str = "trunk"
    """What holds the object: the "trunk" round it, or the "fingers" at its tip."""
    job: str = "grasp"
    """What counts as success: "grasp" carries the object to its place, "kick" and "sweep" move it along the ground."""
    objects: tuple[str, ...] = ("cylinder-60",)
    """Objects of the catalogue that it is for."""
    position: tuple[float, float] | None = None
    """Where its objects wait on the ground (x, y) in the world [m]; None leaves the choice to the scene."""
    push: tuple[float, float] = (0.0, 0.0)
    """Way that it shall move its objects along the ground (x, y) [m]; none where its job is a grasp."""

    def widths(self, design: TrunkDesign) -> tuple[float, float]:
        """Least and greatest width of what it can take [m]: what the trunk can wrap, unless it takes hold otherwise."""
        return graspable_range(design)

    @abstractmethod
    def init(self, observation: Observation) -> State:
        """Plan from the first observation."""

    @abstractmethod
    def step(self, state: State, observation: Observation) -> tuple[State, Command]:
        """What to remember and what to do now."""

    @abstractmethod
    def status(self, state: State) -> Status:
        """Where the strategy stands."""
