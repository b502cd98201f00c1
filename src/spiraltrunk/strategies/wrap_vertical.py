"""Strategy 1, distal wrap in the vertical plane of a suspended object, by bending alone.

Source: "Grasping by Spiraling", figure 5, strategy 1. The arm reaches the object with the trunk hanging straight beside
it; the ventral cables curl the trunk from the tip, and the curvature spreads towards the base as tension grows while
the arm gives way downwards; the arm lifts, carries, holds, sets down; slack cables open the trunk from its base.

Limits: round or square-edged objects of one width within the graspable range, hung free, lighter than the payload; the
trunk hangs at the start. It knows the object's nominal place and size, and afterwards feels with cables alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.model.wrap import predict_wrap, ventral_cables, wrap_tension
from spiraltrunk.plant import Command, Observation, Target
from spiraltrunk.strategies.base import Status, Strategy
from spiraltrunk.strategies.feel import in_step, lever, ventral_pull, way_to_turn_flat, weight
from spiraltrunk.strategies.phases import (
    Move,
    Progress,
    advance,
    begin,
    command_at,
    fraction,
    insert_next,
    raise_tension,
    shift_later,
)

_OVERSHOOT = 0.3
"""How far beyond the expected touch the arm goes down to find the table, over the trunk's length [-]."""

_SMOOTHING = 0.2
"""Share of a new reading in the smoothed weight, at 50 readings a second."""


@final
@dataclass(frozen=True, kw_only=True)
class WrapOptions:
    """What the strategy chooses; lengths are parts of the trunk's own."""

    contact: float = 0.30
    """Height of the object above the hanging tip, over the trunk's length [-]."""
    clearance: float = 0.16
    """Gap to the object before the approach, over the trunk's length [-]."""
    give_way: float = 0.30
    """How far the arm goes down while the trunk curls, over the trunk's length [-]: the curl climbs."""
    follow: float = 0.15
    """How far the arm goes towards the object meanwhile, over the trunk's length [-]."""
    base_bend: float = 0.40
    """Bend that joint 1 keeps under the load, over its limit [-]; it sets the tension."""
    back_off: float = 0.09
    """How far the arm backs off while the trunk opens, over the trunk's length [-]: straightening, it pushes ahead."""
    ease: float = 0.5
    """Tension kept when the object touches down, over the tension that carried it [-]."""
    ease_rise: float = 0.12
    """How far the arm rises meanwhile, over the trunk's length [-]."""
    curl_time: float = 4.0
    """Time to curl [s]: fast pulls shake the object."""
    lead: float = 0.02
    """How far one ventral cable may be pulled in beyond the other, over the stroke [-]: keeps the wrap in its plane."""
    slip: float = 0.04
    """Cable that pays out while lifting, over the stroke, that counts as unrolling [-]."""
    off_center: float = 0.024
    """Lever of the load along its own axis at which the grasp is tried once more, over the trunk's length [-]."""
    off_center_thin: float = 0.15
    """The same over the object's width, whichever is less: friction has no longer a lever against the tilting [-]."""
    recenter: float = 0.5
    """Part of that lever to move by [-]: in a single loop, an object held beside its centre slides on as it tilts."""
    retries: int = 1
    """How often to try again [-]."""
    borne: float = 0.9
    """Part of the object's weight from which the lever can be trusted: until then the strings bear one end [-]."""
    touch: float = 0.5
    """Part of the object's weight that tells, in the arm's torques, whether it is carried or set down [-]."""
    turn: float = 0.5
    """Part of the way from an object's low end staying put, while it turns flat, to its centre staying put [-]."""
    turn_least: float = 0.02
    """Way over the trunk's length from which it is worth while to move along before setting down [-]."""
    turn_rise: float = 0.08
    """How far the arm rises to move along, over the trunk's length [-]."""


@final
@dataclass(frozen=True, kw_only=True)
class WrapState:
    """What the strategy remembers."""

    progress: Progress
    """Moves done and to do."""
    pull_held: float = 0.0
    """Mean pull of the ventral cables when the present move began [m]."""
    weight: float = 0.0
    """What hangs on the trunk's base, smoothed [N]."""
    weight_empty: float = 0.0
    """The same before the trunk touched the object [N]."""
    lever: float = 0.0
    """Where the load hangs beside the base along the object's axis, smoothed [m]."""
    beside: float = 0.0
    """Where the object alone hung beside the base along its axis, at the end of the hold [m]."""
    is_moved: bool = False
    """Whether the arm moved along once the object's low end had touched."""
    retries: int = 0
    """How often the object was let go and grasped once more."""
    is_done: bool = False
    """Whether all moves are done."""
    gave_up: str | None = None
    """Why the grasp was given up, if it was."""


@final
class WrapVertical(Strategy[WrapState]):
    """Distal wrap of a suspended object in the vertical plane."""

    name = "wrap-vertical"
    number = 1

    def __init__(self, options: WrapOptions | None = None) -> None:
        self.options = WrapOptions() if options is None else options

    def init(self, observation: Observation) -> WrapState:
        """Plan places and tension from design and object.

        Raises:
            ModelError: where no cable pulls ventral.
        """
        return WrapState(progress=begin(_plan(observation, self.options), observation), weight=weight(observation))

    def step(self, state: WrapState, observation: Observation) -> tuple[WrapState, Command]:
        """Follow the moves; feel for slip while lifting and for the table while lowering."""
        state = replace(
            state,
            weight=state.weight + _SMOOTHING * (weight(observation) - state.weight),
            lever=state.lever + _SMOOTHING * (lever(observation) - state.lever),
        )
        state = self._feel(state, observation)
        if fraction(state.progress, observation.time) >= 1.0:
            state = self._next(state, observation)
        command = command_at(state.progress, observation.time)
        pull = in_step(observation, self.options.lead)
        return state, replace(command, cable_pull=pull)

    def status(self, state: WrapState) -> Status:
        """Where the strategy stands."""
        move = state.progress.move
        return Status(phase=move.phase, action=move.action, is_done=state.is_done, gave_up=state.gave_up)

    def _feel(self, state: WrapState, observation: Observation) -> WrapState:
        action = state.progress.move.action
        if action in ("curl", "settle") and self._is_off_center(state, observation):
            return self._try_again(state, observation)
        if action == "lift":
            return self._answer_slip(state, observation)
        if action == "lower" and not self._is_carried(state, observation):
            return self._set_down(state, observation)
        return state

    def _answer_slip(self, state: WrapState, observation: Observation) -> WrapState:
        """Pull harder where the load unrolls the trunk."""
        design, pull = observation.task.design, ventral_pull(observation)
        if state.pull_held - pull <= self.options.slip * design.cable_stroke:
            return state
        tighter = raise_tension(state.progress, 1.25, 0.95 * design.cable.tension_max)
        return replace(state, progress=tighter, pull_held=pull)

    def _aim(self, state: WrapState, observation: Observation) -> WrapState:
        """Shift what follows so that the object, hanging beside the base along its axis, comes over its place."""
        load = state.weight - state.weight_empty
        beside = state.lever * state.weight / load if load > 0 else 0.0
        reach = observation.task.target.length / 2
        beside = max(-reach, min(reach, beside))
        progress = shift_later(state.progress, -beside * observation.task.target.axis)
        return replace(state, beside=beside, progress=progress)

    def _set_down(self, state: WrapState, observation: Observation) -> WrapState:
        """Let go of what touches level; move along first, once, with what touches with one end.

        Turning flat about that end, the object would come to lie beside its place. The low end is where it hung beside
        the base, as its weight tilted it.
        """
        progress, design = state.progress, observation.task.design
        way = math.copysign(self.options.turn * self._way_to_turn(progress, observation), state.beside)
        if state.is_moved or state.beside == 0.0 or abs(way) < self.options.turn_least * design.length:
            return replace(state, progress=self._ease(progress, observation))
        along = way * observation.task.target.axis
        up = -self.options.turn_rise * design.length * observation.T_world_base[:3, 0]
        above = command_at(progress, observation.time).T_world_base[:3, 3] + up
        raised = replace(progress.move, action="raise", duration=1.0, position=above)
        aside = replace(raised, action="move along", position=above + along)
        low = progress.move.position + along
        again = replace(progress.move, duration=_lowering_time(above + along, low), position=low)
        progress = insert_next(shift_later(progress, along), (raised, aside, again))
        return replace(state, is_moved=True, progress=advance(progress, observation.time))

    def _way_to_turn(self, progress: Progress, observation: Observation) -> float:
        """How far the centre moves while what just touched turns flat about its low end [m]."""
        expected = progress.move.position[2] + _OVERSHOOT * observation.task.design.length
        target, height = observation.task.target, float(observation.T_world_base[2, 3]) - expected
        return 0.0 if target.kind == "sphere" else way_to_turn_flat(target.length, target.width, height)

    def _ease(self, progress: Progress, observation: Observation) -> Progress:
        """Slacken and rise from wherever the object touched down: unloaded, a tight trunk climbs to the housing."""
        now = command_at(progress, observation.time)
        rise = self.options.ease_rise * observation.task.design.length * observation.T_world_base[:3, 0]
        tension = self.options.ease * progress.move.tension
        ease = replace(
            progress.move, action="ease", duration=0.8, position=now.T_world_base[:3, 3] - rise, tension=tension
        )
        return advance(insert_next(progress, (ease,)), observation.time)

    def _next(self, state: WrapState, observation: Observation) -> WrapState:
        action = state.progress.move.action
        if action == "approach":
            state = replace(state, weight_empty=state.weight)
        if action == "lift" and not self._is_carried(state, observation):
            return replace(state, is_done=True, gave_up="nothing was lifted: the arm feels no load")
        if action == "hold":
            state = self._aim(state, observation)
        if state.progress.is_last:
            return replace(state, is_done=True)
        progress = advance(state.progress, observation.time)
        return replace(state, progress=progress, pull_held=ventral_pull(observation))

    def _is_off_center(self, state: WrapState, observation: Observation) -> bool:
        options, task = self.options, observation.task
        most = min(options.off_center * task.design.length, options.off_center_thin * task.target.width)
        is_borne = self._load(state, observation) > options.borne
        return state.retries < options.retries and is_borne and abs(state.lever) > most

    def _try_again(self, state: WrapState, observation: Observation) -> WrapState:
        """Let the object back onto its strings, move along it, and wrap again; all that follows moves along as well."""
        progress, axis = state.progress, observation.task.target.axis
        shift = self.options.recenter * state.lever * axis
        last = {move.action: i for i, move in enumerate(progress.moves)}
        beside, curl, settle = (progress.moves[last[action]] for action in ("touch", "curl", "settle"))
        slack = beside.tension
        again = (
            replace(curl, action="let go", duration=3.0, position=beside.position, tension=slack),
            replace(beside, phase="prehension", action="touch", duration=2.0, position=beside.position + shift),
            *(replace(move, position=move.position + shift) for move in (curl, settle)),
        )
        left = replace(progress, moves=progress.moves[: progress.index + 1] + progress.moves[last["settle"] + 1 :])
        progress = advance(insert_next(shift_later(left, shift), again), observation.time)
        return replace(state, progress=progress, retries=state.retries + 1)

    def _is_carried(self, state: WrapState, observation: Observation) -> bool:
        return self._load(state, observation) > self.options.touch

    def _load(self, state: WrapState, observation: Observation) -> float:
        """Part of the object's weight that the arm feels [-]."""
        return (state.weight - state.weight_empty) / (observation.task.target.mass * GRAVITY)


def _plan(observation: Observation, options: WrapOptions) -> tuple[Move, ...]:
    design, target = observation.task.design, observation.task.target
    ventral = ventral_cables(design)
    if not ventral.any():
        raise ModelError("no cable pulls ventral; allowed: a design with a cable more than 90 deg from dorsal")
    tension = wrap_tension(design, target.width, target.mass, options.base_bend * design.joint_limit)
    wrap = predict_wrap(design, target.width, target.mass, tension)
    return _moves(observation, options, tension * ventral, wrap.center)


def _moves(observation: Observation, options: WrapOptions, pull: np.ndarray, center: np.ndarray) -> tuple[Move, ...]:
    design, target, goal = observation.task.design, observation.task.target, observation.task.goal
    down, ahead = observation.T_world_base[:3, 0], -observation.T_world_base[:3, 1]
    length, slack = design.length, 0.0 * pull
    beside = target.position + _beside(design, target, options, down, ahead)
    wrapped = beside + options.give_way * length * down + options.follow * length * ahead
    lifted = wrapped - goal.lift * down
    over = lifted + goal.aside
    placing = goal.place - center[0] * down - center[1] * ahead
    above = placing + np.array([0.0, 0.0, (over - placing)[2]])
    low = placing + _OVERSHOOT * length * down
    clear = placing - options.back_off * length * ahead
    opened = clear + np.dot(goal.place + _beside(design, target, options, down, ahead) - clear, down) * down

    def move(phase: str, action: str, duration: float, position: np.ndarray, tension: np.ndarray) -> Move:
        return Move(phase=phase, action=action, duration=duration, position=position, tension=tension)

    return (
        move("reach", "approach", 2.0, beside - options.clearance * length * ahead, slack),
        move("reach", "touch", 1.0, beside, slack),
        move("prehension", "curl", options.curl_time, wrapped, pull),
        move("prehension", "settle", 1.0, wrapped, pull),
        move("transport", "lift", 2.0, lifted, pull),
        move("transport", "carry", 2.0, over, pull),
        move("transport", "hold", goal.hold, over, pull),
        move("release", "bring", 1.5, above, pull),
        move("release", "lower", _lowering_time(above, low), low, pull),
        move("release", "uncurl", 4.0, opened, slack),
        move("release", "leave", 2.0, opened - options.clearance * length * ahead, slack),
        move("release", "rest", 2.5, opened - options.clearance * length * ahead, slack),
    )


def _lowering_time(above: np.ndarray, low: np.ndarray, speed: float = 0.05) -> float:
    return float(np.linalg.norm(low - above)) / speed


def _beside(
    design: TrunkDesign, target: Target, options: WrapOptions, down: np.ndarray, ahead: np.ndarray
) -> np.ndarray:
    """From the object to the place of the base at which the hanging trunk just touches it, shape (3,) [m]."""
    along = (1 - options.contact) * design.length
    radius = np.interp(along, np.cumsum(design.section_length) - design.section_length / 2, design.section_radius)
    return -along * down - (target.width / 2 + radius) * ahead
