"""Strategy 1, distal wrap of a suspended object in the vertical plane, by bending alone.

Source: "Grasping by Spiraling", figure 5, strategy 1.

Reach: the arm brings the hanging, straight trunk beside the object.

Prehension: the ventral cables curl the trunk from its tip, and the curvature spreads towards the base as tension grows.
Contact shows in cables that take in less than in free curl. Meanwhile the arm descends to the height at which the
wrapped trunk just bears the object. A small rise measures the load and its lever; a load that unrolls the trunk, or
that may tilt in it, takes a second rise. An object that was not touched or is not held is let go and wrapped again
further ahead; one that is held beside its middle is wrapped again about its middle, after the trunk has damped its
swing.

Transport: the arm lifts, carries and holds. Cable that pays out is slip, answered by more tension.

Release: the arm lowers the object until the table bears it. Slack cables open the trunk from its base.

Limits: round or square-edged objects of one width that hang freely and are long enough not to slip out sideways. Balls
and rings need a better known position. Only the object's nominal position and size are announced.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.strategies.move_strategy import BORNE, LoadState, MoveStrategy
from spiraltrunk.strategies.moves import (
    advance,
    base_position,
    base_velocity,
    begin,
    command_at,
    fraction,
    insert_next,
    raise_tension,
    shift_later,
)
from spiraltrunk.strategies.sensing import (
    base_directions,
    lever,
    limit_ventral_lead,
    load_fraction,
    tipping_displacement,
    ventral_pull,
    ventral_tension,
    weight,
)
from spiraltrunk.strategies.timing import stretch, travel_time
from spiraltrunk.strategies.winder_drag import balance_drag, straighten
from spiraltrunk.strategies.wrap.hung_model import free_curl
from spiraltrunk.strategies.wrap.hung_plan import (
    BACK_OFF,
    HEFT,
    NEAR_TILTED,
    OVERSHOOT,
    bring_higher,
    ease_and_open,
    lowering_time,
    plan_wrap,
    sag_correction,
    touch_speed,
    wrap_again,
)

# All of these are ours, tuned in simulated trials; lengths are over the trunk's own where their unit is [-].
LEAD = 0.03
"""Lead of one ventral cable before the other, over the stroke [-]: keeps the wrap in its plane. A winder yields by its
tension over its stiffness (3 mm at 60 N and 20 N/mm); with a smaller lead no cable would pull in full."""
CONTACT_SHARE = 0.15
"""Cable that stays out, over the pull of free curl at the same tension, that counts as contact [-]."""
SLIP = 0.04
"""Cable that pays out while carrying, over the stroke, that counts as slip [-]."""
RETRIES = 2
"""Number of further attempts [-]."""
REACH_ON = 0.08
"""Displacement ahead of the next attempt where nothing was touched [-]."""
OFF_CENTER = 0.045
"""Lever of the load along the object's axis above which it is wrapped again [-]: less costs no more time at the
set-down than another attempt, and as few trials."""
OFF_CENTER_THIN = 0.625
"""The same over the object's width [-], whichever is less: friction resists tilting with no longer lever."""
OFF_CENTER_HEAVY = 0.03
"""The same over the width times tension over weight [-]: tension is the normal force of friction."""
WORSE = 1.4
"""Factor on these levers after the first attempt [-]: a swinging object may be met worse."""
RECENTER = 0.65
"""Displacement of the next attempt over the lever [-]: in a single loop an object tilts and slides on."""
TIP = 0.5
"""Displacement before setting down, over the one that keeps the tipping object's centre in place and the fourth power
of `stretch` [-]: a long trunk is thick where it lies under the object, which then seems to be tilted further."""
TIP_LEAST = 0.02
"""Displacement from which the object is moved before it is set down [-]."""
TIP_RISE = 0.08
"""Rise of the base for that displacement [-]."""
_SMOOTHING = 0.2
"""Weight of a new reading in the exponential mean of the load, at 50 readings a second [-]."""
_LEVER_SMOOTHING = 0.1
"""The same for the lever, which is noisier [-]."""
_N_TENSION = 31
"""Tensions at which free curl is tabulated."""
_CARRYING = ("lift", "carry", "hold", "bring")
"""Actions in which cable that pays out is slip."""
_COMING_DOWN = ("bring", "come near")
"""Actions that bring the object near the table, and end where they are as slow as the lowering."""


@final
@dataclass(frozen=True, kw_only=True)
class WrapState(LoadState):
    """What the strategy remembers."""

    free: tuple[np.ndarray, np.ndarray]
    """Ventral tension and pull in free curl, shapes (n,) [N], [m]."""
    is_touched: bool = False
    """Whether the curling trunk touched something."""
    pull_held: float = 0.0
    """Mean pull of the ventral cables when the present move began [m]."""
    lever: float = 0.0
    """Offset of the load from the base along the object's axis, smoothed [m]."""
    offset: float = 0.0
    """Offset of the object alone, at the end of the hold [m]."""
    is_moved: bool = False
    """Whether the object was moved after its low end had touched."""


@final
class WrapVertical(MoveStrategy[WrapState]):
    """Distal wrap of a suspended object in the vertical plane."""

    name = "wrap-vertical"
    number = 1
    objects = ("cylinder-33", "cylinder-60", "cylinder-90", "cylinder-120", "box-60", "box-80", "bottle-70")

    def init(self, observation: Observation) -> WrapState:
        """Plan positions and tension from design and object."""
        moves, design = plan_wrap(observation), observation.task.design
        tension = np.linspace(0.0, design.cable.tension_max, _N_TENSION)
        return WrapState(
            sequence=begin(moves, observation), free=(tension, free_curl(design, tension)), weight=weight(observation),
        )  # fmt: skip

    def sense(self, state: WrapState, observation: Observation) -> WrapState:
        """Measure load and lever; react to contact, slip and touch-down."""
        state = replace(
            state,
            weight=state.weight + _SMOOTHING * (weight(observation) - state.weight),
            lever=state.lever + _LEVER_SMOOTHING * (lever(observation) - state.lever),
        )
        action = state.sequence.move.action
        if action == "curl":
            return _sense_contact(state, observation)
        if action in _CARRYING:
            return _answer_slip(state, observation)
        if action == "lower" or _is_near(state, observation):
            now = load_fraction(observation, weight(observation), state.weight_empty)
            return _set_down(state, observation) if now <= BORNE else state
        return state

    def has_ended(self, state: WrapState, observation: Observation) -> bool:
        """Whether the present move has ended: the way down to near the table where it is as slow as the lowering."""
        if _is_near(state, observation):
            velocity = base_velocity(state.sequence, observation.time)
            return float(np.linalg.norm(velocity)) <= touch_speed(observation.task.design)
        return super().has_ended(state, observation)

    def next_move(self, state: WrapState, observation: Observation) -> WrapState:
        """Decide on another attempt after the test of the load; correct the position after the hold."""
        action = state.sequence.move.action
        if action == "approach":
            state = replace(state, weight_empty=state.weight)
        if action in ("heft", "rise on"):
            decide = _decide if _hangs_freely(state, observation) else _rise_on
            return decide(state, observation)
        if action == "lift" and not state.is_carried(observation):
            return replace(state, is_done=True, gave_up="nothing was lifted: the arm feels no load")
        if action == "hold":
            state = _correct_position(state, observation)
        if state.sequence.is_last:
            return replace(state, is_done=True)
        state = _go_on(state, observation)
        return _straight_down(state, observation.task.design) if action in _COMING_DOWN else state

    def command(self, state: WrapState, observation: Observation) -> Command:
        """Command of the present move, the ventral cables kept together."""
        command = command_at(state.sequence, observation.time)
        command = replace(command, cable_pull=limit_ventral_lead(observation, LEAD, command.cable_tension))
        action = state.sequence.move.action
        return straighten(command, observation) if action == "steady" else balance_drag(command, observation, action)


def _go_on(state: WrapState, observation: Observation) -> WrapState:
    sequence = advance(state.sequence, observation.time)
    return replace(state, sequence=sequence, pull_held=ventral_pull(observation))


def _sense_contact(state: WrapState, observation: Observation) -> WrapState:
    """Compare the pull with free curl; where nothing is touched at half of the tension, try again further ahead."""
    part = fraction(state.sequence, observation.time)
    if state.is_touched or part < 0.25:
        return state
    empty = float(np.interp(ventral_tension(observation), *state.free))
    if ventral_pull(observation) < (1 - CONTACT_SHARE) * empty:
        return replace(state, is_touched=True)
    return state if part < 0.5 or state.retries >= RETRIES else _try_ahead(state, observation)


def _answer_slip(state: WrapState, observation: Observation) -> WrapState:
    """Raise the tension where the load unrolls the trunk."""
    if not _is_slipping(state, observation):
        return state
    tighter = raise_tension(state.sequence, 1.25, observation.task.design.cable.tension_max)
    return replace(state, sequence=tighter, pull_held=ventral_pull(observation))


def _is_slipping(state: WrapState, observation: Observation) -> bool:
    """Whether the load has unrolled the trunk since the present move began, or since the last answer."""
    return state.pull_held - ventral_pull(observation) > SLIP * observation.task.design.cable_stroke


def _hangs_freely(state: WrapState, observation: Observation) -> bool:
    """Whether the load and its lever are measured well enough to decide.

    The string of a low end may still bear after the first rise, and hides the lever.
    """
    is_light = _friction_lever(state, observation) >= _light_lever(observation)
    return state.sequence.move.action == "rise on" or (is_light and not _is_slipping(state, observation))


def _rise_on(state: WrapState, observation: Observation) -> WrapState:
    """Rise a second time before the lift."""
    up = -HEFT * observation.task.design.length * base_directions(observation)[0]
    sequence, move = shift_later(state.sequence, up, ("transport",)), state.sequence.move
    again = replace(move, action="rise on", position=move.position + up)
    return _go_on(replace(state, sequence=insert_next(sequence, (again,))), observation)


def _decide(state: WrapState, observation: Observation) -> WrapState:
    """Lift an object that is held near its middle; otherwise try again, as often as allowed."""
    may_retry = state.retries < RETRIES
    if not state.is_carried(observation):
        return _try_ahead(state, observation) if may_retry else _go_on(state, observation)
    offset = _load_offset(state, observation)
    most = min(_light_lever(observation), _friction_lever(state, observation))
    most *= 1.0 if state.retries == 0 else WORSE
    if not may_retry or abs(offset) <= most:
        return _go_on(state, observation)
    return _try_again(state, observation, RECENTER * offset * observation.task.target.axis)


def _light_lever(observation: Observation) -> float:
    """Largest lever at which a light object is lifted [m]."""
    return min(OFF_CENTER * observation.task.design.length, OFF_CENTER_THIN * observation.task.target.width)


def _friction_lever(state: WrapState, observation: Observation) -> float:
    """Lever at which a held object tilts: friction, pressed by the tension, acts at the object's width [m]."""
    target = observation.task.target
    tension = float(state.sequence.move.tension.max())
    return OFF_CENTER_HEAVY * tension / (target.mass * GRAVITY) * target.width


def _load_offset(state: WrapState, observation: Observation) -> float:
    """Offset of the object alone from the base along its axis [m]."""
    load = state.weight - state.weight_empty
    reach = observation.task.target.length / 2
    return max(-reach, min(reach, state.lever * state.weight / load)) if load > 0 else 0.0


def _try_ahead(state: WrapState, observation: Observation) -> WrapState:
    ahead = base_directions(observation)[1]
    return _try_again(state, observation, REACH_ON * observation.task.design.length * ahead)


def _try_again(state: WrapState, observation: Observation, shift: np.ndarray) -> WrapState:
    """Put the object back onto its strings, let go, and wrap it again, all displaced by ``shift``, shape (3,) [m]."""
    back = BACK_OFF * observation.task.design.length * observation.T_world_base[:3, 1]
    sequence = advance(wrap_again(state.sequence, shift, back), observation.time)
    return replace(state, sequence=sequence, retries=state.retries + 1, is_touched=False)


def _correct_position(state: WrapState, observation: Observation) -> WrapState:
    """Shift the remaining moves so that the object, and not the base, comes over its place."""
    offset, task = _load_offset(state, observation), observation.task
    sequence = shift_later(state.sequence, -offset * task.target.axis)
    if any(move.action == "rise on" for move in sequence.moves[: sequence.index]):
        sequence = shift_later(sequence, sag_correction(observation))
    return replace(state, offset=offset, sequence=bring_higher(task.design, sequence, NEAR_TILTED * abs(offset)))


def _is_near(state: WrapState, observation: Observation) -> bool:
    """Whether the object comes down to near the table, and slows down already."""
    return state.sequence.move.action in _COMING_DOWN and fraction(state.sequence, observation.time) > 0.5


def _straight_down(state: WrapState, design: TrunkDesign) -> WrapState:
    """The lowering that begins straight down and at its speed, which the base nearly has."""
    return replace(state, sequence=replace(state.sequence, velocity=np.array([0.0, 0.0, -touch_speed(design)])))


def _set_down(state: WrapState, observation: Observation) -> WrapState:
    """Let go of an object that touches level; displace once, first, one that touches with an end.

    Tipped flat about that end, it would lie beside its place. The end is on the side on which it hung beside the base.
    """
    if state.sequence.move.action != "lower":  # It touched on the way down: the lowering begins here.
        state = replace(state, sequence=advance(state.sequence, observation.time))
    sequence, design = state.sequence, observation.task.design
    way = TIP / stretch(design) ** 4 * math.copysign(_tipping_displacement(state, observation), state.offset)
    if state.is_moved or state.offset == 0.0 or abs(way) < TIP_LEAST * design.length:
        return replace(state, sequence=ease_and_open(sequence, observation))
    along = way * observation.task.target.axis
    up = -TIP_RISE * design.length * base_directions(observation)[0]
    touched = np.array([*sequence.move.position[:2], base_position(sequence, observation.time)[2]])
    raised = replace(sequence.move, action="raise", duration=travel_time(up), position=touched + up)
    aside = replace(raised, action="move along", duration=travel_time(along), position=touched + up + along)
    again = replace(aside, action="come near", duration=travel_time(up), position=touched + along)
    low = sequence.move.position + along
    lower = replace(sequence.move, duration=lowering_time(design, again.position, low), position=low)
    sequence = insert_next(shift_later(sequence, along), (raised, aside, again, lower))
    return replace(state, is_moved=True, sequence=advance(sequence, observation.time))


def _tipping_displacement(state: WrapState, observation: Observation) -> float:
    """Displacement of the centre while the object that just touched tips flat about its low end [m]."""
    expected = state.sequence.move.position[2] + OVERSHOOT * observation.task.design.length
    target, height = observation.task.target, float(observation.T_world_base[2, 3]) - expected
    if target.kind == "sphere":
        return 0.0
    return tipping_displacement(target.length, target.width, height, state.offset)
