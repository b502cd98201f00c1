"""The cycle of the strategies that grip with the fingers at the trunk's tip: look, grip, lift, check, carry, set down.

Source: "Grasping by Spiraling", figure 5, strategies 2, 3 and 7, and Methods (tip gripper). What the gripper holds it
has no sensor for; the camera tells how high the object is, the arm's torques how heavy.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.control.strategy import Status, Strategy
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.strategies.fingertip.moves import Curl, again, carry, grip, gripping_base, holding, opened, put, reach
from spiraltrunk.strategies.fingertip.plan import TipOptions, gripper_of, turned_across
from spiraltrunk.strategies.moves import Progress, advance, begin, command_at, fraction, insert_next, status_of
from spiraltrunk.strategies.options import choose
from spiraltrunk.strategies.sensing import weight


@final
@dataclass(frozen=True, kw_only=True)
class Mean:
    """Mean of readings over one move."""

    total: np.ndarray
    """Sum of the readings."""
    count: int = 0
    """How many."""

    @property
    def value(self) -> np.ndarray:
        """The mean; 0 before the first reading."""
        return self.total / max(self.count, 1)

    def with_reading(self, reading: np.ndarray) -> Mean:
        """One more reading."""
        return Mean(total=self.total + reading, count=self.count + 1)


@final
@dataclass(frozen=True, kw_only=True)
class TipState:
    """What the strategies remember."""

    progress: Progress
    """Moves done and to do."""
    start: np.ndarray
    """Orientation of the base at the start, shape (3, 3) [-]."""
    seen: Mean
    """Looks of the present move: object's place, its axis, and the height of the base above it, shape (7,) [m, -]."""
    looked: float
    """When the camera looked last [s]."""
    weight: float
    """What hangs on the trunk's base, smoothed [N]."""
    weights: Mean
    """The same as the mean of the present move, shape () [N]."""
    weight_empty: float = 0.0
    """What hung on the base before gripping [N]."""
    weight_held: float = 0.0
    """What hung on the base with the object [N]."""
    rest: np.ndarray | None = None
    """Where the object rested when it was gripped, as seen, shape (3,) [m]."""
    retries: int = 0
    """How often it was gripped once more."""
    is_done: bool = False
    """Whether all moves are done."""
    gave_up: str | None = None
    """Why the grip was given up, if it was."""


class TipStrategy(Strategy[TipState]):
    """Grips with the fingers from above; the trunk hangs straight meanwhile."""

    stage = "ground"
    looks = True
    holds = "fingers"

    def __init__(self, options: TipOptions | None = None) -> None:
        self.options = choose(options, TipOptions())

    @abstractmethod
    def curl(self, observation: Observation) -> Curl | None:
        """What the cables do while the object is carried; None keeps the trunk straight."""

    def widths(self, design: TrunkDesign) -> tuple[float, float]:
        """Least and greatest width of what it can take [m]: fingers that close upon each other take anything thin."""
        return (0.0, 0.0 if design.gripper is None else design.gripper.grasp_width)

    def init(self, observation: Observation) -> TipState:
        """Plan the way above the object.

        Raises:
            ModelError: where the trunk has no gripper, or one that does not open as wide as the object.
        """
        place = observation.task.target.position if observation.look is None else observation.look.position
        return TipState(
            progress=begin(reach(observation, place, self.options), observation),
            start=observation.T_world_base[:3, :3], seen=_UNSEEN, looked=-1.0, weight=weight(observation),
            weights=_WEIGHTLESS,
        )  # fmt: skip

    def step(self, state: TipState, observation: Observation) -> tuple[TipState, Command]:
        """Follow the moves; look and weigh all along, answer slip, stop at the ground."""
        state = self._answer_slip(state, _notice(state, observation), observation)
        if self._has_ended(state, observation):
            state = self._next(state, observation)
        return state, command_at(state.progress, observation.time)

    def status(self, state: TipState) -> Status:
        """Where the strategy stands."""
        return status_of(state.progress, is_done=state.is_done, gave_up=state.gave_up)

    def _has_ended(self, state: TipState, observation: Observation) -> bool:
        if state.progress.move.action == "lower" and state.weight_held - state.weight > self.options.touch:
            return True
        return fraction(state.progress, observation.time) >= 1.0

    def _next(self, state: TipState, observation: Observation) -> TipState:
        action = state.progress.move.action
        if action == "look":
            state = self._grip(state, observation)
        elif action == "check":
            state = self._weigh(state, observation)
        elif action == "bring":
            state = self._put(state, observation)
        elif action == "lower":
            state = _stay(state, observation)
        if state.progress.is_last or state.gave_up is not None:
            return replace(state, is_done=True)
        progress = advance(state.progress, observation.time)
        return replace(state, progress=progress, seen=_UNSEEN, weights=_WEIGHTLESS)

    def _grip(self, state: TipState, observation: Observation) -> TipState:
        """Plan the grip for what was seen, or for what was announced where nothing was."""
        target, gripper = observation.task.target, gripper_of(observation)
        place, axis = (
            (state.seen.value[:3], state.seen.value[3:6]) if state.seen.count else (target.position, target.axis)
        )
        base = gripping_base(observation, place, self.options)
        rotation = turned_across(state.start, axis, gripper.n_finger)
        hold = min(1.0, self.options.firmer**state.retries * holding(observation, self.options))
        moves = grip(state.progress.move, base, rotation, observation.task.goal.lift, hold)
        progress = insert_next(state.progress, moves)
        return replace(state, progress=progress, rest=place, weight_empty=float(state.weights.value))

    def _weigh(self, state: TipState, observation: Observation) -> TipState:
        """Go on with what is held, or try again."""
        if self._is_held(state, observation):
            return self._carry(state, observation)
        if state.retries >= self.options.retries:
            return replace(state, gave_up="nothing was lifted: the object is not seen to rise, or weighs nothing")
        checked, goal = state.progress.move, observation.task.goal
        base = checked.position - goal.lift * _UP
        above = base + self.options.hover * gripper_of(observation).finger_length * _UP
        moves = again(checked, base, above, opened(observation, self.options))
        return replace(state, progress=insert_next(state.progress, moves), retries=state.retries + 1)

    def _is_held(self, state: TipState, observation: Observation) -> bool:
        task = observation.task
        if state.seen.count and state.rest is not None:
            return bool(state.seen.value[2] - state.rest[2] > self.options.risen * task.goal.lift)
        load = float(state.weights.value) - state.weight_empty
        return load > self.options.risen * task.target.mass * GRAVITY

    def _carry(self, state: TipState, observation: Observation) -> TipState:
        """Plan the carry; the object hung below the base with the offset that was seen."""
        task, checked = observation.task, state.progress.move
        beside = state.seen.value[:2] - checked.position[:2] if state.seen.count else np.zeros(2)
        place = np.array([*(task.goal.place[:2] - beside), checked.position[2]])
        moves = carry(checked, observation, self.curl(observation), place)
        progress = insert_next(state.progress, moves)
        return replace(state, progress=progress, weight_held=float(state.weights.value))

    def _put(self, state: TipState, observation: Observation) -> TipState:
        """Plan the lowering to where the object, hanging as low as it is seen to, just stands."""
        brought, gripper = state.progress.move, gripper_of(observation)
        base = gripping_base(observation, brought.position, self.options)
        if state.seen.count and state.rest is not None:
            low = state.rest[2] + state.seen.value[6] - base[2]
            most = self.options.clearance * gripper.finger_length
            base[2] += max(-2 * most, min(low, gripper.finger_length))
        moves = put(brought, base, opened(observation, self.options))
        return replace(state, progress=insert_next(state.progress, moves))

    def _answer_slip(self, before: TipState, state: TipState, observation: Observation) -> TipState:
        """Tighten where a new look sees the object lower under the base that carries it than the looks before did."""
        look, seen = observation.look, before.seen
        is_new = look is not None and state.looked > before.looked
        if look is None or not is_new or seen.count < 2 or state.progress.move.action not in _CARRYING:
            return state
        sunk = observation.T_world_base[2, 3] - look.position[2] - seen.value[6]
        if sunk <= self.options.slip * gripper_of(observation).finger_length:
            return state
        return replace(state, progress=_tightened(state.progress, self.options.tighten), seen=_UNSEEN)


_UP = np.array([0.0, 0.0, 1.0])
_UNSEEN = Mean(total=np.zeros(7))
_WEIGHTLESS = Mean(total=np.zeros(()))
_CARRYING = ("carry", "hold")
_SMOOTHING = 0.1
"""Share of a new reading in the smoothed weight, at 50 readings a second."""


def _notice(state: TipState, observation: Observation) -> TipState:
    """Take a new look and a new weight into account."""
    now = weight(observation)
    state = replace(
        state,
        weights=state.weights.with_reading(np.asarray(now)),
        weight=state.weight + _SMOOTHING * (now - state.weight),
    )
    look = observation.look
    if look is None or look.time <= state.looked:
        return state
    above = observation.T_world_base[2, 3] - look.position[2]
    return replace(state, looked=look.time, seen=state.seen.with_reading(np.array([*look.position, *look.axis, above])))


def _stay(state: TipState, observation: Observation) -> TipState:
    """Open where the ground was met, not deeper."""
    progress = state.progress
    here = command_at(progress, observation.time).T_world_base[:3, 3]
    i = progress.index + 1
    opened = replace(progress.moves[i], position=here)
    return replace(state, progress=replace(progress, moves=(*progress.moves[:i], opened, *progress.moves[i + 1 :])))


def _tightened(progress: Progress, factor: float) -> Progress:
    """The same moves, the fingers pulled harder by ``factor`` wherever they are closed from now on."""
    moves = tuple(
        replace(move, gripper=min(1.0, factor * move.gripper)) if i >= progress.index and move.gripper > 0 else move
        for i, move in enumerate(progress.moves)
    )
    return replace(progress, moves=moves)
