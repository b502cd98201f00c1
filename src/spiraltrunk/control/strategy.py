"""Strategies: pure functions from state and observation to state and command."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import Enum
from typing import Generic, TypeVar, final

import numpy as np

from spiraltrunk.control.messages import Command, Observation, Task
from spiraltrunk.design.rules import graspable_range
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.field_docs import explain_fields

State = TypeVar("State")

SCENE_FIELDS = (
    "job", "support", "orientation", "has_fixed_orientation", "holds", "needs_camera", "objects", "position", "push",
)  # fmt: skip
"""Attributes of a strategy on which its scenes and its verdict depend: what stands in for it takes them over."""


@final
class Milestone(Enum):
    """What a strategy achieves with the object; the value is its name in reports.

    Every step of an attempt carries the milestone that it works towards: the first and the last step that carry LIFTED
    are the start and the end of the lift. The verdict on a grasp needs LIFTED, CARRIED and HELD; on a sweep also
    PUSHED.
    """

    PUSHED = "pushed"
    """The object rests where it was pushed along the ground, and the trunk has withdrawn from it."""
    TOUCHED = "touched"
    """The trunk or its fingers touch the object."""
    LIFTED = "lifted"
    """The object is raised by the goal's lift, off the strings or the ground."""
    CARRIED = "carried"
    """The lifted object is moved aside by the goal's way."""
    HELD = "held"
    """The object is held in the air for the goal's time, the arm at rest."""
    SET_DOWN = "set down"
    """The object is on the table or the ground again."""
    RELEASED = "released"
    """The trunk has let go and rests away from the object."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Status:
    """Phase, action and milestone of a strategy at one step, and whether it has ended."""

    phase: str
    """"reach", "prehension", "transport" or "release"."""
    action: str
    """Name of the action within the phase, in the strategy's own words; nothing depends on it."""
    milestone: Milestone | None = None
    """What the step works towards; None between milestones."""
    is_done: bool = False
    """Whether the strategy has ended."""
    gave_up: str | None = None
    """Why it ended before its goal, if it did."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Assessment:
    """Whether a strategy can do a task, as its model predicts before anything moves."""

    feasible: bool
    """Whether it can."""
    score: float
    """Predicted chance of success, from 0 (infeasible) to 1 [-]."""
    reason: str
    """What decides, in words and numbers."""


class Strategy(ABC, Generic[State]):
    """A grasping strategy. The state is passed in and out: equal inputs yield equal outputs, on every plant."""

    name: str
    """Name on the command line."""
    number: int
    """Number in the paper's figure of nine strategies."""
    support: str = "hung"
    """What supports its objects: "hung" for strings, or "ground"."""
    orientation: str = "lying"
    """Orientation of its objects: "lying", their axis horizontal, or "upright"."""
    has_fixed_orientation: bool = False
    """Whether `orientation` was chosen for the object at hand; otherwise fingers are told that a long object lies."""
    needs_camera: bool = False
    """Whether it needs a camera; otherwise it works with the announced position."""
    holds: str = "trunk"
    """What holds the object: "trunk", "fingers" at its tip, or "nothing" where the object is only pushed."""
    job: str = "grasp"
    """What counts as success: a "grasp" carries the object to its place, a "kick" sends it along the ground, a "sweep"
    pushes it to its place and grasps it there."""
    objects: tuple[str, ...] = ("cylinder-60",)
    """Objects of the catalogue for which it is meant."""
    position: tuple[float, float] | None = None
    """Position of its objects on the ground (x, y) in the world [m]; None leaves the choice to the scene."""
    push: tuple[float, float] = (0.0, 0.0)
    """Displacement of its objects along the ground (x, y) [m]; 0 where its job is a grasp."""

    def widths(self, design: TrunkDesign) -> tuple[float, float]:
        """Least and greatest width of its objects [m]: what the trunk can wrap, unless it grasps otherwise."""
        return graspable_range(design)

    def grasp_task(self, task: Task) -> Task:
        """The task with the object where it is grasped: where it is announced, unless it is pushed elsewhere first."""
        return task

    def highest_base(self, task: Task) -> float | None:
        """Largest height of the trunk's base, hanging over the object, that it plans [m]; None where it plans none.

        ``task`` is that of `grasp_task`.

        Raises:
            ModelError: where the robot cannot do what the task asks.
        """
        return None

    def base_path(self, observation: Observation) -> tuple[np.ndarray, ...] | None:
        """Frames of the trunk's base that it plans to go through, each of shape (4, 4) [-, m]; None where it tells
        none.

        The observation's task is that of `grasp_task`.

        Raises:
            ModelError: where the robot cannot do what the task asks.
        """
        return None

    @abstractmethod
    def init(self, observation: Observation) -> State:
        """First state, planned from the first observation.

        Raises:
            ModelError: where the robot cannot do what the task asks.
        """

    @abstractmethod
    def step(self, state: State, observation: Observation) -> tuple[State, Command]:
        """Next state and command."""

    @abstractmethod
    def status(self, state: State) -> Status:
        """Status in a state."""
