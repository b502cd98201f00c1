"""Cycle of the strategies that grip with the fingers at the trunk's tip: observe, grip, lift, check, carry, set down.

Source: "Grasping by Spiraling", figure 5, strategies 2, 3 and 7, and Methods (tip gripper). The gripper has no sensor:
the camera measures the object's height, and the arm's torques its weight.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import reduce
from operator import add
from typing import TypeVar, final

import numpy as np

from spiraltrunk.control.messages import CameraObservation, Observation, Task
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.strategies.fingertip.gripped_object import gripper_of, opposed_axis
from spiraltrunk.strategies.fingertip.moves import HOVER, Curl, again, carry, grip, hover, is_tall, put, reach
from spiraltrunk.strategies.fingertip.plan import (
    CLEARANCE,
    closing,
    find_seen_task,
    gripping_base,
    opening,
    set_aside,
    turned_across,
)
from spiraltrunk.strategies.move_strategy import LoadState, MoveStrategy
from spiraltrunk.strategies.moves import (
    Move,
    MoveSequence,
    advance,
    base_position,
    begin,
    edit_moves,
    fraction,
    insert_next,
)
from spiraltrunk.strategies.resting import rest_until_still
from spiraltrunk.strategies.sensing import load_fraction, seen_position, weight

# All of these are ours, tuned in simulated trials.
SLIP = 0.15
"""Sinking of the held object, as seen, that counts as slip, over a finger's length [-]."""
SLIP_MOST = 0.006
"""Sinking that counts as slip with fingers of any length [m]: several errors of a camera."""
TIGHTEN = 1.3
"""Factor on the fingers' tension where the object slips [-]."""
RISEN = 0.5
"""Part of the lift, or of the object's weight, from which the object counts as held [-]."""
TOUCH_DOWN = 0.25
"""Loss of weight that counts as touch-down [N]: more than the noise that is left after smoothing."""
FIRMER = 1.6
"""Factor on the fingers' tension with each attempt after the first [-]: smooth cones slip out of the first grip."""
RETRIES = 1
"""Number of further attempts [-]."""

_SMOOTHING = 0.1
"""Weight of a new reading in the exponential mean of the weight, at 50 readings a second [-]."""


Reading = TypeVar("Reading", float, np.ndarray)


@final
@dataclass(frozen=True, kw_only=True)
class TipState(LoadState):
    """What the strategies remember."""

    start: np.ndarray
    """Orientation of the base at the start, shape (3, 3) [-]."""
    seen: tuple[np.ndarray, ...] = ()
    """Camera observations of the present move: position and axis of the object, and the height of the base above it,
    each of shape (7,) [m, -]."""
    seen_at: float = -1.0
    """Time of the last camera observation [s]."""
    weights: tuple[float, ...] = ()
    """Weights of the present move [N]."""
    weight_held: float = 0.0
    """Weight with the object [N]."""
    offset: tuple[float, float] = (0.0, 0.0)
    """Observed horizontal offset of the held object from the base [m]."""
    rest: np.ndarray | None = None
    """Observed position of the object at the grip, shape (3,) [m]."""
    seen_task: Task | None = None
    """The task with the object as it was seen before the last grip; None before the first."""
    last_look: CameraObservation | None = None
    """What the camera saw of the released object at the end of the move before."""


class TipStrategy(MoveStrategy[TipState]):
    """Grip with the fingers from above; the trunk hangs straight meanwhile."""

    support = "ground"
    needs_camera = True
    holds = "fingers"

    def curl(self, observation: Observation) -> Curl | None:
        """Command of the cables while the object is carried; None keeps the trunk straight."""
        return None

    def widths(self, design: TrunkDesign) -> tuple[float, float]:
        """Smallest and largest graspable width [m]; 0 at least, as the fingers close completely."""
        return (0.0, 0.0 if design.gripper is None else design.gripper.grasp_width)

    def highest_base(self, task: Task) -> float:
        """Height of the base when the object is lifted, or over the grip, whichever is higher [m]."""
        rise = max(task.goal.lift, HOVER * gripper_of(task).finger_length)
        return float(gripping_base(task, task.target.position)[2]) + rise

    def init(self, observation: Observation) -> TipState:
        """Plan the way above the object, turned across its axis as it is seen from the start."""
        task, start, camera = observation.task, observation.T_world_base[:3, :3], observation.camera
        axis = opposed_axis(task, task.target.axis if camera is None else camera.axis)
        rotation = turned_across(start, axis, task)
        moves = reach(observation, seen_position(observation), rotation)
        return TipState(sequence=begin(moves, observation), start=start, weight=weight(observation))

    def sense(self, state: TipState, observation: Observation) -> TipState:
        """Take new readings into account; tighten where the object sinks under the base that carries it: it slips."""
        now, camera, seen = weight(observation), observation.camera, state.seen
        state = replace(
            state,
            weights=(*state.weights, now),
            weight=state.weight + _SMOOTHING * (now - state.weight),
        )
        if camera is None or camera.time <= state.seen_at:
            return state
        below = observation.T_world_base[2, 3] - camera.position[2]
        reading = np.array([*camera.position, *camera.axis, below])
        state = replace(state, seen_at=camera.time, seen=(*seen, reading))
        if len(seen) < 2 or state.sequence.move.action not in ("carry", "hold"):
            return state
        if below - _mean(seen)[6] <= min(SLIP * gripper_of(observation.task).finger_length, SLIP_MOST):
            return state
        return replace(state, sequence=_tighten(state.sequence), seen=())

    def has_ended(self, state: TipState, observation: Observation) -> bool:
        """Whether the present move has ended: the lowering where the ground bears the object."""
        is_down = state.sequence.move.action == "lower" and state.weight_held - state.weight > TOUCH_DOWN
        return is_down or fraction(state.sequence, observation.time) >= 1.0

    def next_move(self, state: TipState, observation: Observation) -> TipState:
        """Plan the grip once observed, the carry once held, and the lowering from the hold or the uncurled trunk."""
        action = state.sequence.move.action
        if action == "look":
            state = _grip(state, observation)
        elif action == "check":
            state = self._carry(state, observation) if _is_held(state, observation) else _try_again(state, observation)
        elif state.sequence.is_last and action in ("hold", "look over"):
            state = _put(state, observation)
        elif action == "lower":
            state = _stay(state, observation)
        elif action in ("leave", "rest"):
            state = _rest(state, observation)
        if state.sequence.is_last or state.gave_up is not None:
            return replace(state, is_done=True)
        sequence = advance(state.sequence, observation.time)
        seen = state.seen if action == "approach" else ()  # The object rests meanwhile.
        return replace(state, sequence=sequence, seen=seen, weights=())

    def _carry(self, state: TipState, observation: Observation) -> TipState:
        """Plan the carry; the object keeps the observed offset from the base."""
        state, checked = _measure_offset(state), state.sequence.move
        moves = carry(checked, observation, self.curl(observation), _place_base(state, observation))
        sequence = insert_next(state.sequence, moves)
        return replace(state, sequence=sequence, weight_held=_mean(state.weights))


def _grip(state: TipState, observation: Observation) -> TipState:
    """Plan the grip of the object as observed, or as announced where it was not; end where it cannot be gripped so."""
    task, place, axis = observation.task, observation.task.target.position, observation.task.target.axis
    if state.seen:
        place, axis, _ = np.split(_mean(state.seen), [3, 6])
        task = find_seen_task(task, place, axis)
    axis = opposed_axis(task, axis)
    rotation = turned_across(state.start, axis, task)
    hold = min(1.0, FIRMER**state.retries * closing(task))
    try:
        base, wide = gripping_base(task, place) + set_aside(task, rotation, axis), opening(task)
    except ModelError as error:  # It lies otherwise than announced.
        return replace(state, gave_up=str(error))
    moves = grip(replace(state.sequence.move, gripper=wide), observation, base, rotation, hold)
    sequence = insert_next(state.sequence, moves)
    return replace(state, sequence=sequence, rest=place, seen_task=task, weight_empty=_mean(state.weights))


def _is_held(state: TipState, observation: Observation) -> bool:
    if state.seen and state.rest is not None:
        return bool(_mean(state.seen)[2] - state.rest[2] > RISEN * observation.task.goal.lift)
    return load_fraction(observation, _mean(state.weights), state.weight_empty) > RISEN


def _try_again(state: TipState, observation: Observation) -> TipState:
    if state.retries >= RETRIES:
        return replace(state, gave_up="nothing was lifted: the object is not seen to rise, or weighs nothing")
    checked, task = state.sequence.move, state.seen_task or observation.task
    base = checked.position - np.array([0.0, 0.0, task.goal.lift])
    moves = again(checked, base, hover(observation, base), opening(task))
    return replace(state, sequence=insert_next(state.sequence, moves), retries=state.retries + 1)


def _measure_offset(state: TipState) -> TipState:
    """The state with the object's offset from the base as seen during the present move, at whose end the base is."""
    if not state.seen:
        return state
    x, y = (_mean(state.seen)[:2] - state.sequence.move.position[:2]).tolist()
    return replace(state, offset=(x, y))


def _place_base(state: TipState, observation: Observation) -> np.ndarray:
    """Position of the base, as high as now, with the object over its place, shape (3,) [m]."""
    return np.array([*(observation.task.goal.place[:2] - state.offset), state.sequence.move.position[2]])


def _put(state: TipState, observation: Observation) -> TipState:
    """Plan the lowering of the base to the height at which the object, by its observed offset, touches its support."""
    state, task = _measure_offset(state), state.seen_task or observation.task
    base, length = gripping_base(task, _place_base(state, observation)), gripper_of(task).finger_length
    if state.seen and state.rest is not None:
        low = state.rest[2] + _mean(state.seen)[6] - base[2]
        base[2] += max(-2 * CLEARANCE * length, min(low, length))
    moves = put(state.sequence.move, observation, base, opening(task))
    return replace(state, sequence=insert_next(state.sequence, moves), weight_held=_mean(state.weights))


def _stay(state: TipState, observation: Observation) -> TipState:
    """Open where the ground was met, not deeper."""
    sequence = state.sequence
    deeper = sequence.move.position - base_position(sequence, observation.time)

    def stay(move: Move) -> Move:
        return replace(move, position=move.position - deeper) if move.action in ("ease", "open") else move

    return replace(state, sequence=edit_moves(sequence, sequence.index + 1, stay))


def _rest(state: TipState, observation: Observation) -> TipState:
    """Add rests until a tall object, which rocks once it is let go, is seen to stand still."""
    sequence = state.sequence
    if sequence.move.action == "rest" and is_tall(observation.task):
        sequence = rest_until_still(sequence, observation, state.last_look)
    return replace(state, sequence=sequence, last_look=observation.camera)


def _mean(readings: tuple[Reading, ...]) -> Reading:
    """Mean of at least one reading, summed in order."""
    return reduce(add, readings) / len(readings)


def _tighten(sequence: MoveSequence) -> MoveSequence:
    """The sequence with the fingers pulled harder wherever they are closed from now on."""

    def tighten(move: Move) -> Move:
        return replace(move, gripper=min(1.0, TIGHTEN * move.gripper)) if move.gripper > 0 else move

    return edit_moves(sequence, sequence.index, tighten)
