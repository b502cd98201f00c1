"""Wraps of an object that stands on the ground, strategies 4 to 6: oblique near the ground, oblique, near-horizontal.

Source: "Grasping by Spiraling", figure 5 and Results, strategies 4 to 6: where the object's base is in contact with the
ground, the plane of curvature goes from vertical through oblique to near-horizontal, by the head's tilt and by
twisting, that is by unequal ventral cables. Angles and heights are ours, tuned in simulated trials.

Reach: the arm brings the trunk beside the object, the head tilted for the wanted plane. Two cables lift the tail beyond
the object. The arm moves sideways until the cables' lengths show a touch, and retreats by as much as the trunk pressed.
What topples easily is not touched (`unsteady`).

Prehension: ventral tension grows, and the arm follows the model so that the curling trunk leaves the object in place: a
loose one falls over at half a newton. Tensions wait for the arm, which lags behind its commands (`arm_lag`). A trunk
that comes down on a handle or a rim yields upwards, and the arm stops where a distal wrap jams. After tightening, a
small rise tests the load, and rises further where none is felt: the closed trunk may have pressed on the ground. An
object that is not held is let go and, if it stands, grasped once more where it is then seen.

Transport: equal cables turn the plane of the wrap towards level. Twice, the head turns by the lean that the camera
sees. The arm lifts (further where the object sagged), carries and holds, with the ventral lengths held and the dorsal
cable taut against them. Cable is taken in where a settling wrap would go slack, and none is paid out.

Release: the object is set upright over its place once more. The arm lowers it under tension control until the ground
bears it. Then tension falls in small steps (`opening`): the arm presses the object on the ground and follows the tail,
which unwinds last, until it holds by little and the trunk springs open (in 40 ms as simulated). The arm then retreats.

Limits: upright objects up to about 1 kg, from about 70 mm of height on, as the housing has to clear the ground. In a
distal wrap (`distal_plan`), of an object too short for the base beside it, the base closes once the object is borne.
Slender ones are taken above their middle by the oblique wraps, where the head can turn away the whole lean. What is not
round is taken for the cylinder of the same girth, from a direction that suits how it is turned (`approach`), as far as
the arm can turn. The cables pull in every direction. A camera sees where the object stands and how it leans.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.control.messages import CameraObservation, Command, Observation
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.strategies.move_strategy import LoadState, MoveStrategy
from spiraltrunk.strategies.moves import (
    PHASES,
    MoveSequence,
    advance,
    base_position,
    begin,
    build_frame,
    fraction,
    insert_next,
    shift_later,
    turn_left,
)
from spiraltrunk.strategies.resting import has_toppled, rest_until_still
from spiraltrunk.strategies.sensing import measure_lean, seen_position, ventral_tension, weight
from spiraltrunk.strategies.stiffening import counter_tension, hold_lengths, hold_lengths_in
from spiraltrunk.strategies.winder_drag import balance_drag
from spiraltrunk.strategies.wrap.approach import approach_direction
from spiraltrunk.strategies.wrap.arm_lag import Tensions, delay_tension
from spiraltrunk.strategies.wrap.attempts import (
    PRESS,
    carry_higher,
    go_on,
    is_jammed,
    lift_further,
    may_rise,
    rise_further,
    stay_here,
    tighten_here,
    try_again,
    yield_upwards,
)
from spiraltrunk.strategies.wrap.distal_plan import find_height, plan_wrap
from spiraltrunk.strategies.wrap.light_object import HIGH, describe_no_load, is_off_ground, is_too_light
from spiraltrunk.strategies.wrap.opening import plan_opening, press_down, right
from spiraltrunk.strategies.wrap.set_down import (
    DISTAL_DRAG,
    DRAG,
    center_place,
    is_on_ground,
    set_down_clear,
)
from spiraltrunk.strategies.wrap.standing_model import least_width
from spiraltrunk.strategies.wrap.standing_plan import OVERSHOOT, SLOWLY, WrapPlane
from spiraltrunk.strategies.wrap.unsteady import is_unsteady, stop_before
from spiraltrunk.strategies.wrap.upright import carry_upright

# All of these are ours, tuned in simulated trials.
EARLY = 0.05
"""Distance before the expected touch from which one is accepted, over the trunk's length [-]: a tail may brush the
ground."""
TOUCH = 0.012
"""Cable by which the trunk bends back, over the stroke, that counts as a touch [-]."""
RELIEF = 0.02
"""Retreat of the arm from the touch, over the trunk's length [-]: an object that is pressed on is dragged."""
RETRIES = 1
"""Number of further attempts [-]."""
CORNER = 0.8
"""Part of a move after which the next one begins, where the base may round the corner between them [-]."""

_SMOOTHING = 0.2
"""Weight of a new reading in exponential means, at 50 readings a second [-]."""
_STIFF = ("lift", "carry", "hold", "bring", "center")
"""Actions in which the ventral lengths are held."""
_ROUNDED = ("lift", "draw off")
"""Actions at whose end the base need not come to rest."""
_TURNED = 0.005
"""Rest of a turn that may be cut short there [rad]: only velocity is continuous, not turning."""


@final
@dataclass(frozen=True, kw_only=True)
class StandingState(LoadState):
    """What the strategy remembers."""

    side: np.ndarray
    """Horizontal direction in which the trunk curls, shape (3,) [-]."""
    lean: float = 0.0
    """Dorsal cables' pull minus the ventral ones', smoothed [m]: it grows as something pushes the trunk back."""
    lean_free: float = 0.0
    """The same before anything was touched [m]."""
    pull: np.ndarray
    """Cable pulls, smoothed, shape (n_cable,) [m]."""
    seen: np.ndarray
    """Position of the object when the grasp was planned, shape (3,) [m]."""
    tight: np.ndarray
    """Tensions of the tightened wrap, shape (n_cable,) [N]."""
    shift: float = 0.0
    """Distance beyond its expected position at which the object was touched [m]."""
    is_distal: bool = False
    """Whether the wrap is a distal one."""
    stood: float = 0.0
    """Height of the object's centre as it was first seen [m]."""
    height: float = 0.0
    """Height above the object's foot at which its girth counts as the trunk opens [m]."""
    is_unsteady: bool = False
    """Whether the object is not touched before the trunk curls."""
    last_look: CameraObservation | None = None
    """What the camera saw of the released object at the end of the move before."""
    recent: Tensions = ()
    """Planned tensions of the last periods, which are delayed by the arm's lag."""

    def is_carried(self, observation: Observation) -> bool:
        """Whether the trunk bears the object: by its weight or, as a camera sees it, by its rise."""
        if is_too_light(observation):
            return is_off_ground(observation, self.stood)
        return super().is_carried(observation) or is_off_ground(observation, self.stood, HIGH)


class StandingWrap(MoveStrategy[StandingState]):
    """Wrap of a standing object; the members of the family differ in their plane alone."""

    support = "ground"
    orientation = "upright"
    needs_camera = True
    objects = ("cylinder-60", "cylinder-90", "cylinder-120", "box-60", "box-80", "bottle-70")
    position = (0.46, 0.12)
    plane: WrapPlane

    def widths(self, design: TrunkDesign) -> tuple[float, float]:
        """Least and greatest width of its objects [m]: what the trunk can wrap, and thinner ones that are tall."""
        return least_width(design), super().widths(design)[1]

    def base_path(self, observation: Observation) -> tuple[np.ndarray, ...]:
        """Frames of the base at the ends of all moves of the first attempt."""
        return tuple(build_frame(move.position, move.rotation) for move in plan_wrap(observation, self.plane)[0])

    def init(self, observation: Observation) -> StandingState:
        """Plan positions and tensions from design and object."""
        moves, is_distal = plan_wrap(observation, self.plane)
        task, side, unsteady = observation.task, approach_direction(observation, is_distal), is_unsteady(observation)
        moves = stop_before(moves, OVERSHOOT * task.design.length * side) if unsteady else moves
        height = find_height(task, self.plane) if is_distal else self.plane.opening_height * task.target.length
        return StandingState(
            sequence=begin(moves, observation), side=side, weight=weight(observation),
            lean=measure_lean(observation), pull=observation.cable_pull, seen=seen_position(observation),
            tight=next(move.tension for move in moves if move.action == "tighten"), is_distal=is_distal,
            stood=float(seen_position(observation)[2]), height=height, is_unsteady=unsteady,
        )  # fmt: skip

    def step(self, state: StandingState, observation: Observation) -> tuple[StandingState, Command]:
        """Next state and command, its tensions delayed by `delay_tension`."""
        state, command = super().step(state, observation)
        action = state.sequence.move.action
        recent, tension = delay_tension(state.recent, action, command.cable_tension)
        command = balance_drag(replace(command, cable_tension=tension), observation, action)
        return replace(state, recent=recent), command

    def sense(self, state: StandingState, observation: Observation) -> StandingState:
        """Measure lean, load and pulls; react to the touch, to slack cable and to touch-down."""
        state = replace(
            state,
            weight=state.weight + _SMOOTHING * (weight(observation) - state.weight),
            lean=state.lean + _SMOOTHING * (measure_lean(observation) - state.lean),
            pull=state.pull + _SMOOTHING * (observation.cable_pull - state.pull),
        )
        action = state.sequence.move.action
        if action == "touch":
            return _sense_touch(state, observation)
        if action == "curl" and state.is_distal and is_jammed(observation, state.weight_empty):
            return replace(state, sequence=go_on(tighten_here(state.sequence, observation.time), observation))
        if action in ("curl", "tighten") and state.weight_empty - state.weight > PRESS:
            return replace(state, sequence=yield_upwards(state.sequence))
        if action in _STIFF:
            return replace(state, sequence=_take_in(state, observation))
        if action == "lower" and not state.is_carried(observation) and is_on_ground(observation):
            sequence = plan_opening(stay_here(state.sequence, observation), observation, state.height)
            return replace(state, sequence=go_on(sequence, observation))
        if action == "uncurl":
            load = state.weight - state.weight_empty
            return replace(state, sequence=press_down(state.sequence, observation, load))
        return state

    def next_move(self, state: StandingState, observation: Observation) -> StandingState:
        """Decide on another attempt after the test of the load; turn the object upright; stiffen the trunk."""
        action = state.sequence.move.action
        if action == "descend":
            state = replace(state, weight_empty=state.weight)
        if action in ("try", "lift") and not state.is_carried(observation):
            return _rise_or_try_again(state, observation)
        if action == "touch":
            return _accept_touch(state, observation)
        if action == "back off" and has_toppled(observation):
            return replace(state, is_done=True, gave_up="nothing was lifted: the object has toppled")
        sequence = self._edit_moves(state, observation)
        if action == "back off":
            state = replace(state, seen=seen_position(observation))
        if action in ("leave", "rest"):
            state = replace(state, last_look=observation.camera)
        if sequence.is_last:
            return replace(state, is_done=True)
        sequence = go_on(sequence, observation)
        if sequence.move.action == "lower":  # What the winders pulled with to hold their lengths, not what they may.
            tension = np.clip(observation.cable_tension, 0.0, observation.task.design.cable.tension_max)
            sequence = replace(sequence, start=replace(sequence.start, cable_tension=tension))
        return replace(state, sequence=sequence)

    def _edit_moves(self, state: StandingState, observation: Observation) -> MoveSequence:
        """The moves with the later ones suited to what was measured during the present one."""
        action, sequence = state.sequence.move.action, state.sequence
        if action == "try":
            return carry_higher(sequence)
        if action == "back off":
            return shift_later(sequence, (seen_position(observation) - state.seen) * [1.0, 1.0, 0.0], PHASES[:3])
        if action in ("level", "steady"):
            sequence = carry_upright(sequence, observation, self.plane.ground_gap)
            if action == "level":
                return sequence
            return lift_further(_stiffen(sequence, state, observation), observation, state.stood)
        if action == "bring":
            return center_place(sequence, observation, state.side, DISTAL_DRAG if state.is_distal else DRAG)
        if action == "lower":
            return plan_opening(sequence, observation, state.height)
        if action == "uncurl":
            return right(sequence, observation, state.height)
        if action == "hold":
            return set_down_clear(sequence, observation, self.plane.ground_gap)
        return rest_until_still(sequence, observation, state.last_look) if action == "rest" else sequence

    def has_ended(self, state: StandingState, observation: Observation) -> bool:
        """Whether the present move has ended: shortly before its end where the next one may round the corner."""
        sequence, time = state.sequence, observation.time
        is_rounded = sequence.move.action in _ROUNDED and turn_left(sequence, time) < _TURNED
        return fraction(sequence, time) >= (CORNER if is_rounded else 1.0)


@final
class WrapObliqueLow(StandingWrap):
    """Wrap in a plane that falls ahead, as near the ground as the housing allows; ventral cables unequal."""

    name = "wrap-oblique-low"
    number = 4
    plane = WrapPlane(
        slope=math.radians(7.0), reach_slope=math.radians(-8.0), differential=-0.12, height=0.3, slender_height=0.62,
        ground_gap=0.022, opening_height=0.4, distal_height=0.6,
    )  # fmt: skip


@final
class WrapOblique(StandingWrap):
    """Wrap in a plane that falls ahead, at half the height; ventral cables unequal."""

    name = "wrap-oblique"
    number = 5
    plane = WrapPlane(
        slope=math.radians(8.0), reach_slope=math.radians(-8.0), differential=-0.14, height=0.5, slender_height=0.62,
        ground_gap=0.022, opening_height=0.45, distal_height=0.62,
    )  # fmt: skip


@final
class WrapHorizontal(StandingWrap):
    """Wrap in a plane that rises ahead and that the load makes level, at half the height; ventral cables equal."""

    name = "wrap-horizontal"
    number = 6
    plane = WrapPlane(slope=math.radians(-12.0), differential=0.0, height=0.55, lowering=SLOWLY)


def _sense_touch(state: StandingState, observation: Observation) -> StandingState:
    """End the reach where the object bends the trunk back; until shortly before the object, measure the free lean."""
    design = observation.task.design
    if state.is_unsteady:
        return state
    if _beyond_touch(state, observation) < -EARLY * design.length:
        return replace(state, lean_free=state.lean)
    is_touched = state.lean - state.lean_free >= TOUCH * design.cable_stroke
    return _accept_touch(state, observation) if is_touched else state


def _rise_or_try_again(state: StandingState, observation: Observation) -> StandingState:
    """Where no load is felt: rise further in the test, try again from the start, or end."""
    action, sequence = state.sequence.move.action, state.sequence
    if action == "try" and may_rise(sequence):
        return replace(state, sequence=advance(rise_further(sequence), observation.time))
    if action == "lift" or state.retries >= RETRIES:
        return replace(state, is_done=True, gave_up=describe_no_load(observation))
    sequence = go_on(insert_next(sequence, try_again(sequence)), observation)
    return replace(state, sequence=sequence, retries=state.retries + 1)


def _accept_touch(state: StandingState, observation: Observation) -> StandingState:
    """Begin the next move, all moves before the release shifted sideways to where the object was touched."""
    relief = RELIEF * observation.task.design.length
    shift = 0.0 if state.is_unsteady else _beyond_touch(state, observation) - relief
    sequence = shift_later(state.sequence, (shift - state.shift) * state.side, PHASES[:3])
    return replace(state, sequence=go_on(sequence, observation), shift=shift)


def _beyond_touch(state: StandingState, observation: Observation) -> float:
    """Sideways distance of the arm beyond the expected touch [m]."""
    now, overshoot = base_position(state.sequence, observation.time), OVERSHOOT * observation.task.design.length
    return float(state.side @ (now - state.sequence.move.position)) + overshoot


def _stiffen(sequence: MoveSequence, state: StandingState, observation: Observation) -> MoveSequence:
    """Hold the ventral lengths while carrying, dorsal cables against them."""
    design = observation.task.design
    dorsal = counter_tension(design, ventral_tension(observation))
    return hold_lengths_in(sequence, _STIFF, *hold_lengths(design, state.pull, state.tight, dorsal=dorsal))


def _take_in(state: StandingState, observation: Observation) -> MoveSequence:
    """Take cable in where a settling wrap would go slack; pay none out."""
    held, sequence = state.sequence.move.pull, state.sequence
    pull, ceiling = hold_lengths(observation.task.design, state.pull, state.tight)
    if held is None or not (pull > held).any():
        return sequence
    return hold_lengths_in(sequence, _STIFF, np.maximum(pull, held), np.maximum(ceiling, sequence.move.tension))
