"""Strategy 1, distal wrap in the vertical plane of a suspended object, by bending alone.

Source: "Grasping by Spiraling", figure 5, strategy 1.

Reach: the arm brings the trunk, hanging straight, beside the object. Prehension: the ventral cables curl it from the
tip, and the curvature spreads towards the base as tension grows; that the cables take in less than those of a trunk in
the air tells of contact. Meanwhile the arm goes down to where the wrapped trunk would just bear the object, so that the
strings keep it level until the set tension makes the wrap tight. A first small rise tells whether it is held, and where
it hangs: what was not touched or not held is let go and wrapped anew, further on; what hangs beside its middle, about
there; before that, the trunk leans on it until it no longer swings. What is heavy enough to unroll the trunk, or tilts
at a short lever, takes a second rise before it is judged. Transport: the arm lifts, carries and holds; cables that pay
out tell of slip and are answered with more tension. Release: the arm lowers the object until the table bears it; slack
cables open the trunk from its base.

Limits: round or square-edged objects of one width, hung free, long enough not to slip out sideways where they are held
beside their middle: a ball or a ring needs its place known better. The trunk hangs at the start. The object's nominal
place and size are told; everything else is felt with cables and the arm's torques.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.control.strategy import Milestone, Status, Strategy
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.design.trunk import ventral_cables
from spiraltrunk.strategies.moves import (
    Progress,
    advance,
    begin,
    command_at,
    fraction,
    insert_next,
    raise_tension,
    shift_later,
    status_of,
)
from spiraltrunk.strategies.options import choose
from spiraltrunk.strategies.sensing import in_step, lever, ventral_pull, ventral_tension, way_to_turn_flat, weight
from spiraltrunk.strategies.wrap.hung_model import free_curl, unrolled_center
from spiraltrunk.strategies.wrap.hung_plan import (
    OVERSHOOT,
    WrapOptions,
    lowering_time,
    plan_grip,
    plan_wrap,
    wrap_again,
)

_SMOOTHING = 0.2
"""Share of a new reading in the smoothed weight, at 50 readings a second."""

_SLOWER = 0.05
"""The same for the lever, which noise covers more."""

_STEPS = 31
"""Tensions at which the free curl is worked out."""

_CARRYING = ("lift", "carry", "hold", "bring")
"""Actions in which cable that pays out is a slip."""


@final
@dataclass(frozen=True, kw_only=True)
class WrapState:
    """What the strategy remembers."""

    progress: Progress
    """Moves done and to do."""
    free: tuple[np.ndarray, np.ndarray]
    """Tension of the ventral cables, and what a trunk that touches nothing takes in, shapes (n,) [N], [m]."""
    is_felt: bool = False
    """Whether the curling trunk met something."""
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
    objects = ("cylinder-33", "cylinder-60", "cylinder-90", "cylinder-120", "box-60", "box-80", "bottle-70")

    def __init__(self, options: WrapOptions | None = None) -> None:
        self.options = choose(options, WrapOptions())

    def init(self, observation: Observation) -> WrapState:
        """Plan places and tension from design and object.

        Raises:
            ModelError: where no cable pulls ventral.
        """
        moves, design = plan_wrap(observation, self.options), observation.task.design
        tension = np.linspace(0.0, design.cable.tension_max, _STEPS)
        return WrapState(
            progress=begin(moves, observation), free=(tension, free_curl(design, tension)), weight=weight(observation),
        )  # fmt: skip

    def step(self, state: WrapState, observation: Observation) -> tuple[WrapState, Command]:
        """Follow the moves; feel for the object, for what it weighs and where, for slip, and for the table."""
        state = replace(
            state,
            weight=state.weight + _SMOOTHING * (weight(observation) - state.weight),
            lever=state.lever + _SLOWER * (lever(observation) - state.lever),
        )
        state = self._feel(state, observation)
        if fraction(state.progress, observation.time) >= 1.0:
            state = self._next(state, observation)
        command = command_at(state.progress, observation.time)
        pull = in_step(observation, self.options.lead)
        return state, replace(command, cable_pull=pull)

    def status(self, state: WrapState) -> Status:
        """Where the strategy stands."""
        return status_of(state.progress, is_done=state.is_done, gave_up=state.gave_up)

    def _feel(self, state: WrapState, observation: Observation) -> WrapState:
        action = state.progress.move.action
        if action == "curl":
            return self._feel_contact(state, observation)
        if action in _CARRYING:
            return self._answer_slip(state, observation)
        if action == "lower" and not self._is_carried(state, observation):
            return self._set_down(state, observation)
        return state

    def _feel_contact(self, state: WrapState, observation: Observation) -> WrapState:
        """Notice that the cables take in less than those of a trunk in the air; at half the tension, reach further."""
        part = fraction(state.progress, observation.time)
        if state.is_felt or part < 0.25:
            return state
        empty = float(np.interp(ventral_tension(observation), *state.free))
        if ventral_pull(observation) < (1 - self.options.felt) * empty:
            return replace(state, is_felt=True)
        return state if part < 0.5 or not self._may_try(state) else self._reach_on(state, observation)

    def _answer_slip(self, state: WrapState, observation: Observation) -> WrapState:
        """Pull harder where the load unrolls the trunk."""
        if not self._pays_out(state, observation):
            return state
        tighter = raise_tension(state.progress, 1.25, observation.task.design.cable.tension_max)
        return replace(state, progress=tighter, pull_held=ventral_pull(observation))

    def _pays_out(self, state: WrapState, observation: Observation) -> bool:
        """Whether the load has unrolled the trunk since the present move began, or since that was answered."""
        most = self.options.slip * observation.task.design.cable_stroke
        return state.pull_held - ventral_pull(observation) > most

    def _hangs(self, state: WrapState, observation: Observation) -> bool:
        """Whether the arm has risen enough to judge: what unrolls the trunk, or may tilt in it, takes a further rise.

        An end that dips still hangs on its string, which hides how far beside its middle the object is held.
        """
        is_light = self._friction_lever(state, observation) >= self._most_beside(observation)
        return state.progress.move.action == "rise on" or (is_light and not self._pays_out(state, observation))

    def _rise_on(self, state: WrapState, observation: Observation) -> WrapState:
        """Rise once more before the lift."""
        up = -self.options.heft * observation.task.design.length * observation.T_world_base[:3, 0]
        progress, move = shift_later(state.progress, up, "transport"), state.progress.move
        again = replace(move, action="rise on", position=move.position + up)
        return self._go_on(replace(state, progress=insert_next(progress, (again,))), observation)

    def _aim(self, state: WrapState, observation: Observation) -> WrapState:
        """Shift what follows so that the object, hanging beside the base along its axis, comes over its place."""
        beside = self._hangs_beside(state, observation)
        progress = shift_later(state.progress, -beside * observation.task.target.axis)
        if any(move.action == "rise on" for move in progress.moves[: progress.index]):
            progress = shift_later(progress, self._way_of_sag(observation))
        return replace(state, beside=beside, progress=progress)

    def _way_of_sag(self, observation: Observation) -> np.ndarray:
        """Way of the base that makes up for joints which the load opened more than planned, shape (3,) [m]."""
        design, width = observation.task.design, observation.task.target.width
        down, ahead = observation.T_world_base[:3, 0], -observation.T_world_base[:3, 1]
        wrap = plan_grip(observation, self.options)[1]
        planned = unrolled_center(design, width, float(wrap.pull[ventral_cables(design)].mean()))
        lower, further = unrolled_center(design, width, ventral_pull(observation)) - planned
        return np.asarray(-lower * down - further * ahead)

    def _set_down(self, state: WrapState, observation: Observation) -> WrapState:
        """Let go of what touches level; move along first, once, with what touches with one end.

        Turning flat about that end, the object would come to lie beside its place. The low end is where it hung beside
        the base, as its weight tilted it.
        """
        progress, design = state.progress, observation.task.design
        way = math.copysign(self.options.turn * self._way_to_turn(state, observation), state.beside)
        if state.is_moved or state.beside == 0.0 or abs(way) < self.options.turn_least * design.length:
            return replace(state, progress=self._ease(progress, observation))
        along = way * observation.task.target.axis
        up = -self.options.turn_rise * design.length * observation.T_world_base[:3, 0]
        above = command_at(progress, observation.time).T_world_base[:3, 3] + up
        raised = replace(progress.move, action="raise", duration=1.0, position=above)
        aside = replace(raised, action="move along", position=above + along)
        low = progress.move.position + along
        again = replace(progress.move, duration=lowering_time(above + along, low), position=low)
        progress = insert_next(shift_later(progress, along), (raised, aside, again))
        return replace(state, is_moved=True, progress=advance(progress, observation.time))

    def _way_to_turn(self, state: WrapState, observation: Observation) -> float:
        """How far the centre moves while what just touched turns flat about its low end [m]."""
        expected = state.progress.move.position[2] + OVERSHOOT * observation.task.design.length
        target, height = observation.task.target, float(observation.T_world_base[2, 3]) - expected
        if target.kind == "sphere":
            return 0.0
        return way_to_turn_flat(target.length, target.width, height, state.beside)

    def _ease(self, progress: Progress, observation: Observation) -> Progress:
        """Slacken and rise from wherever the object touched down: unloaded, a tight trunk climbs to the housing.

        Then open there, backing off; a trunk that is drawn up while its tip is still curled drags the object along.
        """
        length, options = observation.task.design.length, self.options
        rise = -options.ease_rise * length * observation.T_world_base[:3, 0]
        place = command_at(progress, observation.time).T_world_base[:3, 3] + rise
        eased = options.ease * progress.move.tension
        ease = replace(
            progress.move, action="ease", milestone=Milestone.RELEASED, duration=0.8, position=place, tension=eased
        )
        back = options.back_off * length * observation.T_world_base[:3, 1]
        uncurl = replace(ease, action="uncurl", duration=options.open_time, position=place + back, tension=0.0 * eased)
        return advance(insert_next(progress, (ease, uncurl)), observation.time)

    def _next(self, state: WrapState, observation: Observation) -> WrapState:
        action = state.progress.move.action
        if action == "approach":
            state = replace(state, weight_empty=state.weight)
        if action in ("heft", "rise on"):
            decide = self._judge if self._hangs(state, observation) else self._rise_on
            return decide(state, observation)
        if action == "lift" and not self._is_carried(state, observation):
            return replace(state, is_done=True, gave_up="nothing was lifted: the arm feels no load")
        if action == "hold":
            state = self._aim(state, observation)
        if state.progress.is_last:
            return replace(state, is_done=True)
        return self._go_on(state, observation)

    def _go_on(self, state: WrapState, observation: Observation) -> WrapState:
        progress = advance(state.progress, observation.time)
        return replace(state, progress=progress, pull_held=ventral_pull(observation))

    def _judge(self, state: WrapState, observation: Observation) -> WrapState:
        """Lift what is held near its middle; wrap anew, further on, what is not held, or beside."""
        options, task = self.options, observation.task
        if not self._is_carried(state, observation):
            return self._reach_on(state, observation) if self._may_try(state) else self._go_on(state, observation)
        beside = self._hangs_beside(state, observation)
        most = min(self._most_beside(observation), self._friction_lever(state, observation))
        most *= 1.0 if state.retries == 0 else options.worse
        if not self._may_try(state) or abs(beside) <= most:
            return self._go_on(state, observation)
        return self._try_again(state, observation, options.recenter * beside * task.target.axis)

    def _most_beside(self, observation: Observation) -> float:
        """Lever at which the grasp of a light object is tried once more [m]."""
        options, task = self.options, observation.task
        return min(options.off_center * task.design.length, options.off_center_thin * task.target.width)

    def _friction_lever(self, state: WrapState, observation: Observation) -> float:
        """Lever at which what is held tilts: friction, pressed by the tension, has the object's width for one [m]."""
        target = observation.task.target
        tension = float(state.progress.move.tension.max())
        return self.options.off_center_heavy * tension / (target.mass * GRAVITY) * target.width

    def _may_try(self, state: WrapState) -> bool:
        return state.retries < self.options.retries

    def _reach_on(self, state: WrapState, observation: Observation) -> WrapState:
        ahead = -observation.T_world_base[:3, 1]
        return self._try_again(state, observation, self.options.reach_on * observation.task.design.length * ahead)

    def _try_again(self, state: WrapState, observation: Observation, shift: np.ndarray) -> WrapState:
        """Put the object back onto its strings, let go, and wrap it again with all that follows shifted."""
        back = self.options.back_off * observation.task.design.length * observation.T_world_base[:3, 1]
        progress = advance(wrap_again(state.progress, shift, back, self.options), observation.time)
        return replace(state, progress=progress, retries=state.retries + 1, is_felt=False)

    def _hangs_beside(self, state: WrapState, observation: Observation) -> float:
        """Where the object alone hangs beside the base along its axis [m]."""
        load = state.weight - state.weight_empty
        reach = observation.task.target.length / 2
        return max(-reach, min(reach, state.lever * state.weight / load)) if load > 0 else 0.0

    def _is_carried(self, state: WrapState, observation: Observation) -> bool:
        return self._load(state, observation) > self.options.touch

    def _load(self, state: WrapState, observation: Observation) -> float:
        """Part of the object's weight that the arm feels [-]."""
        return (state.weight - state.weight_empty) / (observation.task.target.mass * GRAVITY)
