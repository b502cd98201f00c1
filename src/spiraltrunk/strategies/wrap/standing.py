"""Wraps of an object that stands on the ground: strategies 4 to 6, one family.

Source: "Grasping by Spiraling", figure 5 and Results, strategies 4 to 6: where the object's base is in contact with
the ground, the plane of curvature goes from vertical through oblique to near-horizontal, by the head's tilt and by
twisting, that is by unequal ventral cables.

Reach: beside the object, the head tilted so that the curled trunk will lie in the wanted plane; two cables lift the
tail beyond the object; then sideways until the cables' lengths tell of a touch, and back from it by as much as it
pressed. Prehension: ventral tension grows, and the arm goes where the model says that the curling trunk leaves the
object where it is: a loose object falls over at half a newton, and pressed on it is dragged along, out of a wide wrap.
Tightened, it is lifted a little, and the arm's wrench tells whether it is held; if not, it is set down, let go and
grasped once more where it is then seen.

Transport: equal cables turn the wrap's plane towards level, then the head turns until the camera sees the object stand,
twice; then lift, carry, hold, with the ventral lengths held and the dorsal cable taut against them. Cable is taken in
where a wrap that settles would go slack, and none is paid out: held by lengths alone, an object wider than the tail can
reach round slips out, as the wrap loosens when it moves.

Release: once more upright, over its place; back to tension; down until the ground bears it; tension falls until the
base's joints have opened a little. Opened slowly from there, the tail, which unwinds last, would slide round the object
and drag it over by friction. So the trunk is let spring open at once: damped in proportion to their stiffness, all
joints open in the same time (40 ms, as simulated; on a real trunk it is to be measured), in which the trunk leaves the
object on all sides before it can move. Then the arm draws off.

Limits: upright objects of one width, tall enough that the housing clears the ground, up to about 1 kg. A box is taken
for the cylinder of the same girth, as that much trunk goes round it. A bottle is held at its shoulder, and may slip
where friction is low. A trunk whose cables pull in every direction. It needs a camera's look at where the object stands
and how it leans, and otherwise feels with cables and wrench alone.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.control.strategy import Status, Strategy
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.strategies.moves import (
    Move,
    Progress,
    advance,
    begin,
    command_at,
    fraction,
    insert_next,
    status_of,
)
from spiraltrunk.strategies.options import choose
from spiraltrunk.strategies.sensing import ventral_tension, weight
from spiraltrunk.strategies.stiffening import hold_lengths
from spiraltrunk.strategies.wrap.standing_plan import StandingOptions, plan_moves, side_of
from spiraltrunk.strategies.wrap.upright import carried_upright, set_down_upright

_SMOOTHING = 0.2
"""Share of a new reading in smoothed ones, at 50 readings a second."""


_STIFF = ("lift", "carry", "hold", "bring")
"""Actions in which the ventral lengths are held."""

_TAUT = 1.0
"""Tension of a dorsal cable that is just taut [N]."""

_AGAINST = 0.1
"""Dorsal tension over the ventral one where cables rub [-]."""


@final
@dataclass(frozen=True, kw_only=True)
class StandingState:
    """What the strategy remembers."""

    progress: Progress
    """Moves done and to do."""
    side: np.ndarray
    """Horizontal direction in which the trunk curls, shape (3,) [-]."""
    lean: float = 0.0
    """Dorsal cables' pull beyond the ventral ones', smoothed: it grows as something pushes the trunk back [m]."""
    lean_free: float = 0.0
    """The same before anything was touched [m]."""
    weight: float = 0.0
    """What hangs on the trunk's base, smoothed [N]."""
    weight_empty: float = 0.0
    """The same before the trunk touched the object [N]."""
    pull: np.ndarray
    """Cable pulled in, smoothed, shape (n_cable,) [m]."""
    seen: np.ndarray
    """Where the object was seen when the grasp was planned, shape (3,) [m]."""
    tight: np.ndarray
    """Tensions of the tightened wrap, shape (n_cable,) [N]."""
    shift: float = 0.0
    """How far beyond its expected place the object was touched [m]."""
    retries: int = 0
    """How often the object was let go and grasped once more."""
    is_done: bool = False
    """Whether all moves are done."""
    gave_up: str | None = None
    """Why the grasp was given up, if it was."""


class StandingWrap(Strategy[StandingState]):
    """Wrap of a standing object; what differs within the family are its options."""

    stage = "ground"
    stance = "upright"
    looks = True
    objects = ("cylinder-60", "cylinder-90", "cylinder-120", "box-60", "box-80", "bottle-70")
    position = (0.46, 0.12)

    def __init__(self, options: StandingOptions | None = None) -> None:
        self.options = choose(options, self.default_options())

    @staticmethod
    @abstractmethod
    def default_options() -> StandingOptions:
        """Plane of the wrap and all else that the strategy chooses."""

    def init(self, observation: Observation) -> StandingState:
        """Plan places and tensions from design and object.

        Raises:
            ModelError: where the cables cannot pull as needed, or the object is too short.
        """
        moves = plan_moves(observation, self.options)
        return StandingState(
            progress=begin(moves, observation), side=side_of(observation), weight=weight(observation),
            lean=_lean(observation), pull=observation.cable_pull, seen=_seen(observation),
            tight=next(move.tension for move in moves if move.action == "tighten"),
        )  # fmt: skip

    def step(self, state: StandingState, observation: Observation) -> tuple[StandingState, Command]:
        """Follow the moves; feel for the touch, for the load, for cable that goes slack and for the ground."""
        state = replace(
            state,
            weight=state.weight + _SMOOTHING * (weight(observation) - state.weight),
            lean=state.lean + _SMOOTHING * (_lean(observation) - state.lean),
            pull=state.pull + _SMOOTHING * (observation.cable_pull - state.pull),
        )
        state = self._feel(state, observation)
        if fraction(state.progress, observation.time) >= 1.0:
            state = self._next(state, observation)
        return state, command_at(state.progress, observation.time)

    def status(self, state: StandingState) -> Status:
        """Where the strategy stands."""
        return status_of(state.progress, is_done=state.is_done, gave_up=state.gave_up)

    def _feel(self, state: StandingState, observation: Observation) -> StandingState:
        action = state.progress.move.action
        if action == "touch":
            return self._feel_touch(state, observation)
        if action in _STIFF:
            return replace(state, progress=_take_in(state, observation))
        if action == "lower" and self._load(state, observation) < self.options.borne:
            return replace(state, progress=_stay(state.progress, observation))
        return state

    def _feel_touch(self, state: StandingState, observation: Observation) -> StandingState:
        """Stop where the object bends the trunk back, and do from there all that comes before the release."""
        if self._beyond_touch(state, observation) < -self.options.early * observation.task.design.length:
            return replace(state, lean_free=state.lean)
        if state.lean - state.lean_free < self.options.touch * observation.task.design.cable_stroke:
            return state
        return self._touched(state, observation)

    def _touched(self, state: StandingState, observation: Observation) -> StandingState:
        """The next move at once, all until the release shifted sideways to where the object was touched."""
        progress = state.progress
        shift = self._beyond_touch(state, observation) - self.options.relief * observation.task.design.length
        moves = _shifted_until_release(progress, (shift - state.shift) * state.side)
        progress = advance(replace(progress, moves=moves), observation.time)
        return replace(state, progress=progress, shift=shift)

    def _beyond_touch(self, state: StandingState, observation: Observation) -> float:
        """How far beyond the expected touch the arm has come sideways [m]."""
        progress = state.progress
        now = command_at(progress, observation.time).T_world_base[:3, 3]
        overshoot = self.options.overshoot * observation.task.design.length
        return float(state.side @ (now - progress.move.position)) + overshoot

    def _next(self, state: StandingState, observation: Observation) -> StandingState:
        action, progress = state.progress.move.action, state.progress
        if action == "descend":
            state = replace(state, weight_empty=state.weight)
        if action in ("try", "lift") and self._load(state, observation) < self.options.borne:
            if action == "lift" or state.retries >= self.options.retries:
                return replace(state, is_done=True, gave_up="nothing was lifted: the arm feels no load")
            progress = advance(insert_next(progress, _once_more(progress)), observation.time)
            return replace(state, progress=progress, retries=state.retries + 1)
        if action == "touch":
            return self._touched(state, observation)
        if action == "back off":
            state, progress = _aimed_anew(state, observation)
        if action in ("level", "steady"):
            progress = carried_upright(progress, observation, self.options)
        if action == "steady":
            progress = _stiffened(progress, state, observation)
        if action == "hold":
            progress = set_down_upright(progress, observation, self.options)
        if progress.is_last:
            return replace(state, is_done=True)
        progress = advance(progress, observation.time)
        if action == "bring":  # What the winders pulled with to hold their lengths, and not what they were allowed.
            progress = replace(progress, tension_start=np.maximum(observation.cable_tension, 0.0))
        return replace(state, progress=progress)

    def _load(self, state: StandingState, observation: Observation) -> float:
        """Part of the object's weight that the arm feels [-]."""
        return (state.weight - state.weight_empty) / (observation.task.target.mass * GRAVITY)


def _lean(observation: Observation) -> float:
    direction = observation.task.design.cable_direction[:, 1]
    pull = observation.cable_pull
    return float(pull[direction > 0].mean() - pull[direction < 0].mean())


def _seen(observation: Observation) -> np.ndarray:
    return observation.task.target.position if observation.look is None else observation.look.position


def _aimed_anew(state: StandingState, observation: Observation) -> tuple[StandingState, Progress]:
    """The next try where the object is seen by now."""
    seen = _seen(observation)
    way = (seen - state.seen) * [1.0, 1.0, 0.0]
    progress = replace(state.progress, moves=_shifted_until_release(state.progress, way))
    return replace(state, seen=seen), progress


def _shifted_until_release(progress: Progress, way: np.ndarray) -> tuple[Move, ...]:
    return tuple(
        replace(move, position=move.position + way) if i > progress.index and move.phase != "release" else move
        for i, move in enumerate(progress.moves)
    )


def _stiffened(progress: Progress, state: StandingState, observation: Observation) -> Progress:
    """The same sequence, the trunk stiffened while it carries: ventral lengths held, dorsal cables against them.

    The dorsal ones are just taut where cables run freely, since more would only soften; where they rub, they pull with
    a tenth of the ventral tension (docs/validation/stiffness.md).
    """
    design = observation.task.design
    dorsal = max(_TAUT, _AGAINST * ventral_tension(observation) if design.cable.friction > 0 else 0.0)
    pull, ceiling = hold_lengths(design, state.pull, state.tight, dorsal=dorsal)
    return _carried_with(progress, pull, ceiling)


def _take_in(state: StandingState, observation: Observation) -> Progress:
    """The same sequence, cable taken in where a wrap that settles would go slack: it pays out none, but pulls on."""
    design, held = observation.task.design, state.progress.move.pull
    pull, ceiling = hold_lengths(design, state.pull, state.tight)
    if held is None or not (pull > held).any():
        return state.progress
    return _carried_with(state.progress, np.maximum(pull, held), np.maximum(ceiling, state.progress.move.tension))


def _carried_with(progress: Progress, pull: np.ndarray, tension: np.ndarray) -> Progress:
    moves = tuple(
        replace(move, pull=pull, tension=tension) if move.action in _STIFF else move for move in progress.moves
    )
    return replace(progress, moves=moves)


def _stay(progress: Progress, observation: Observation) -> Progress:
    """What opens the trunk from as high as it is now."""
    now = command_at(progress, observation.time).T_world_base[2, 3]
    rise = np.array([0.0, 0.0, now - progress.move.position[2]])
    moves = tuple(
        replace(move, position=move.position + rise) if i > progress.index else move
        for i, move in enumerate(progress.moves)
    )
    return advance(replace(progress, moves=moves), observation.time)


def _once_more(progress: Progress) -> tuple[Move, ...]:
    """Set down, let the trunk spring open as in the release, back off, and all of it again."""
    done = progress.moves[: progress.index + 1]
    last = {move.action: i for i, move in enumerate(done)}
    release = [move for move in progress.moves if move.phase == "release"]
    eased = sum(move.action == "uncurl" for move in release)
    again = progress.moves[last["touch"] : progress.index + 1]
    back = [_letting_go(move) for move in reversed(again) if move.action != "try"][: eased + 1]
    spring = [
        replace(_letting_go(move), phase="prehension", position=back[-1].position, rotation=back[-1].rotation)
        for move in release
        if move.action == "open"
    ]
    first = replace(_letting_go(again[0]), duration=1.0)
    apart = replace(progress.moves[last["descend"]], phase="prehension", action="back off", duration=2.0)
    return (*back, *spring, first, apart, *again)


def _letting_go(move: Move) -> Move:
    return replace(move, action="let go", milestone=None)
