"""Moves of arm and cables to wrap a standing object, from its position and size, the design, and the model.

Lengths are over the trunk's own where their unit is [-] and nothing else is said.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.control.messages import Observation
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.strategies.moves import Move, tilted_base
from spiraltrunk.strategies.object_measures import widths_between
from spiraltrunk.strategies.sensing import seen_position
from spiraltrunk.strategies.timing import stretch
from spiraltrunk.strategies.wrap.approach import approach_direction
from spiraltrunk.strategies.wrap.hung_plan import wrap_move
from spiraltrunk.strategies.wrap.standing_model import (
    cable_pulls,
    curl_tilt,
    loop_band,
    object_center,
    shut_pull,
    wrap_start,
    wrapped_width,
)

# All of these are ours, tuned in simulated trials.
STEPS = (0.0, 0.07, 0.15, 0.22, 0.30, 0.41, 0.56, 0.75, 1.1)
"""Ventral pulls at which the model places the arm, over the pull that shuts joint 1 [-]; denser where the tip curls."""
TURNING = (0.30, 0.75)
"""Ventral pulls between which the plane turns from the reach's to the wrap's, over the pull that shuts joint 1 [-]."""
TAIL = 0.8
"""Pull that lifts the tail, over the one that shuts the last joint [-]."""
OPENED_TAIL = 1.6
"""The same as the trunk springs open [-]: the tail swings up past the object, which its rebound would hit. Of 90 drawn
things that topple at 0.035 to 0.2 N, 73 were lifted and set down; with no lift instead 62, and with 5.0, 56
(docs/validation/grasp_limits.md)."""
TAIL_END = 0.30
"""Ventral pull from which the tail is no longer lifted, over the one that shuts joint 1 [-]."""
GRIP = 1.2
"""Ventral pull of the tightened wrap, over the one that shuts joint 1 [-]."""
CARRY = 1.0
"""Addition to it for the load, over the pull that balances the object's weight beside the base [-]."""
SPRING = 0.56
"""Ventral pull from which the trunk springs open, over the one that shuts joint 1 [-]."""
SLENDER = math.radians(15.0)
"""Angle of toppling below which an object counts as slender [rad]: the head of an oblique wrap, which turns only as far
as its housing clears the ground, may leave it such a lean."""
HIGHEST, HIGHEST_NARROW = 0.85, 0.76
"""Largest height of the wrap, over the object's length, and that of a narrow one [-] (ours): a full wrap near the rim
climbs over it as it tightens. Of 42 drawn things whose full wrap would be higher than 0.76, up to 95 mm wide, full
wraps lifted and set down 27 and distal ones 36; of 15 wider ones full wraps 10 and distal ones 3."""
NARROW = 0.19
"""Largest width of a narrow object, over the trunk's length [-]."""
SAG = 0.08
"""Sinking of the base while a falling plane is turned back, over the trunk's length and that turn [1/rad]: equal
tensions also turn the object."""
HOUSING_ROOM = 0.014
"""Least gap of a wrapped object to the housing in a plane that falls ahead [m]: there the object leans towards it, and
the tightening loop draws it near."""
REST = 2
"""Section, from 0 at the base, at which a tightly wrapped object rests, and from which it is released."""
CLEARANCE = 0.24
"""Gap to the object before the touch [-]."""
NEAR = 0.10
"""The same where the slow part of the reach begins [-]: a trunk in motion lags behind its base, as if pushed back."""
OVERSHOOT = 0.03
"""Travel of the arm beyond the expected touch [-]."""
BACK_OFF = 0.20
"""Sideways retreat of the arm while the tail opens [-]: the tail would push the object."""
TEST = 0.02
"""Rise of the test of the load [m]."""
SINK = 0.012
"""Depth below the start to which the base is lowered in search of the ground [m]."""
TIMES = {
    "turn": 2.0, "descend": 1.1, "near": 1.0, "touch": 1.8,
    "curl": 0.3, "tighten": 1.1, "try": 0.4,
    "level": 0.2, "steady": 0.5, "lift": 1.2, "carry": 1.1,
    "bring": 0.9, "lower": 2.0, "uncurl": 0.4, "settle": 0.2, "draw off": 1.0, "leave": 1.0, "rest": 0.5,
}  # fmt: skip
"""Duration of each move by its action, those of "curl" and "uncurl" for one step of the ventral pull [s].
They last longer for long trunks (`stretch`), and where the base would pass `ACCELERATION`."""
LONG_TURN = 4
"""Exponent of `stretch` for "turn" [-]: turned faster, the fingers of a long trunk swing into the arm's pedestal."""
ACCELERATION = (1.3, 2.6)
"""Largest acceleration of the base [m/s^2] and of its orientation [rad/s^2]: the arm's last joints bear 12 N m."""
WRIST = (0.060, 0.280, 0.004)
"""Radius of the arm's wrist, its distance behind the trunk's base, and its gap to the ground [m]: where the base points
upwards, it is lower than the housing. Measures fit the Panda at the tilts at which it touched the ground."""
HEAVY, SLOWLY = 0.45, 1.3
"""Mass from which an object is lowered more slowly [kg], and the factor of the duration [-]: at 30 to 40 mm/s the
ground's blow takes the arm's wrist to its torque limit. Distal wraps lower all objects so."""
OPEN_TIME = 0.06
"""Time in which the trunk goes slack [s]: as fast as winders can. It then comes to rest in the time of "settle"."""

_AHEAD, _UP = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])


@final
@dataclass(frozen=True, kw_only=True)
class WrapPlane:
    """Plane of a wrap, by which the strategies of the family differ."""

    slope: float
    """Slope at which the plane of the curled, unloaded trunk falls ahead of the base [rad]; 0 is level."""
    reach_slope: float = math.radians(-12.0)
    """The same while the tail goes round the object [rad]: rising, as a slack tail hangs."""
    differential: float
    """Cable pull along the trunk's z over the ventral one [-]: unequal ventral cables turn the plane of bending."""
    height: float
    """Height of the wrap over the object's length [-]; larger where the housing would touch the ground."""
    slender_height: float = 0.0
    """The same at least for slender objects [-]."""
    ground_gap: float = 0.03
    """Gap between housing and ground [m]."""
    opening_height: float = 0.5
    """Height over the object's length at which its girth counts as a full wrap opens [-]."""
    lowering: float = 1.0
    """Duration of lowering the object over the usual one [-]."""
    distal_height: float = 0.65
    """Height of a distal wrap over the object's length [-]: above its centre, so that its weight keeps it upright."""


@final
@dataclass(frozen=True, kw_only=True)
class _Step:
    """Arm and cables at one ventral pull; positions are level, from the ground below the object."""

    pull: float
    """Ventral pull over the one that shuts joint 1 [-]."""
    tension: np.ndarray
    """Cable tensions as the trunk closes, shape (n_cable,) [N]."""
    slackening: np.ndarray
    """Cable tensions as it opens, its plane level, shape (n_cable,) [N]."""
    rotation: np.ndarray
    """Orientation of the base in the world, shape (3, 3) [-]."""
    closing: np.ndarray
    """Position of the base as the trunk closes, shape (3,) [m]."""
    opening: np.ndarray
    """Position of the base as it opens, shape (3,) [m]: a wrapped object lies deeper in the curl."""


def move_time(design: TrunkDesign, action: str) -> float:
    """Duration of a move for a trunk, as of TIMES [s]."""
    return TIMES[action] * stretch(design) ** (LONG_TURN if action == "turn" else 1)


def plan_moves(observation: Observation, plane: WrapPlane, *, may_be_near_rim: bool = False) -> tuple[Move, ...]:
    """All moves from a hanging trunk over grasp and release to the trunk beside the object.

    Args:
        observation: what is seen at the start.
        plane: of the wrap.
        may_be_near_rim: whether a narrow object may be wrapped as near to its rim as a wide one.

    Raises:
        ModelError: where the cables cannot pull as needed, or the object is too short.
    """
    steps, lever = _plan_steps(observation, plane, may_be_near_rim)
    design, shut = observation.task.design, shut_pull(observation.task.design)
    load = observation.task.target.mass * GRAVITY * lever
    grip = GRIP + CARRY * load / float(design.joint_stiffness[0] * design.joint_limit)
    tight, level = (_tension(design, part * plane.differential, float(grip * shut[0])) for part in (1.0, 0.0))
    return _moves(observation, plane, steps, tight, level)


def _plan_steps(observation: Observation, plane: WrapPlane, may_be_near_rim: bool) -> tuple[tuple[_Step, ...], float]:
    """Steps of the curl, and the final distance of the object from the base, level [m]."""
    design, target = observation.task.design, observation.task.target
    width, shut = wrapped_width(target), float(shut_pull(design)[0])
    side = approach_direction(observation)
    frame = np.column_stack([side, np.cross(_UP, side), _UP])
    full = cable_pulls(design, STEPS[-1] * shut, 0.0)
    slope, section = _choose_loop(design, plane, width, full)
    ends = [curl_tilt(design, width, full, each) for each in (plane.reach_slope, slope)]
    tilts = np.interp(STEPS, TURNING, ends)
    tensions, slackening = (
        [_tension(design, differential, pull * shut) for pull in STEPS] for differential in (plane.differential, 0.0)
    )
    at = zip(tilts, tensions, strict=True)
    first = np.array([object_center(design, width, tilt, tension, section) for tilt, tension in at])
    deep = np.array([object_center(design, width, tilts[0], tension, REST) for tension in slackening])
    middle = np.array([0.0, 0.0, _wrap_height(observation, plane, tilts, first, may_be_near_rim)])
    closing = (middle - first) @ frame.T
    opening = closing[-1] + (deep[-1] - deep) @ frame.T
    opening[:, 2] = closing[0, 2]  # The housing clears the ground on this way.
    off = -BACK_OFF * design.length * frame[:, 0]
    steps = tuple(
        _Step(
            pull=pull, tension=tensions[i], slackening=slackening[i], rotation=frame @ tilted_base(_AHEAD, tilts[i]),
            closing=closing[i], opening=opening[i] + max(0.0, 1.0 - pull / TAIL_END) * off,
        )
        for i, pull in enumerate(STEPS)
    )  # fmt: skip
    return steps, float(np.linalg.norm(first[-1, :2]))


def _choose_loop(design: TrunkDesign, plane: WrapPlane, width: float, tension: np.ndarray) -> tuple[float, int]:
    """Slope of the plane [rad], and the section that closes on the object first.

    A wide object in the loop of a short trunk is near the housing. It is then wrapped one section further out, in a
    level plane: in simulated trials 6 of 8 fresh ones were grasped so, where 8 of 8 had touched it
    (docs/validation/robustness.md).
    """
    section, tilt = wrap_start(design, width), curl_tilt(design, width, tension, plane.slope)
    center = object_center(design, width, tilt, tension, section)
    if plane.slope <= 0.0 or housing_gap(design, tilt, center) - width / 2 >= HOUSING_ROOM:
        return plane.slope, section
    return 0.0, min(section + 1, design.n_section - 1)


def _moves(
    observation: Observation, plane: WrapPlane, steps: tuple[_Step, ...], tight: np.ndarray, level: np.ndarray
) -> tuple[Move, ...]:
    design, goal, target = observation.task.design, observation.task.goal, observation.task.target
    ground = float(target.position[2] - target.length / 2) if goal.ground is None else goal.ground
    side, open_, last = approach_direction(observation), steps[0], steps[-1]
    start, place = (np.array([*where[:2], ground]) for where in (seen_position(observation), goal.place))
    clear, near, beyond = (way * design.length * side for way in (-CLEARANCE, -NEAR, OVERSHOOT))
    high, test = goal.lift * _UP, TEST * _UP
    touch, wrapped, away = start + open_.closing, start + last.closing, place + open_.opening
    lifted, lowered = wrapped + test + high, place + last.closing

    def move(action: str, position: np.ndarray, tension: np.ndarray, step: _Step = last) -> Move:
        return wrap_move(action, move_time(design, action), position, tension, step.rotation)

    slack, eased = open_.tension, [step for step in steps if step.pull >= SPRING]
    sprung = cable_pulls(design, 0.0, OPENED_TAIL * float(shut_pull(design)[-1]))
    lowering = SLOWLY if target.mass > HEAVY else plane.lowering
    opened = place + eased[0].opening
    return (
        move("turn", touch + clear + high, slack, open_),
        move("descend", touch + clear, slack, open_),
        move("near", touch + near, slack, open_),
        move("touch", touch + beyond, slack, open_),
        *(move("curl", start + step.closing, step.tension, step) for step in steps[1:]),
        move("tighten", wrapped, tight),
        move("try", wrapped + test, tight),
        move("level", wrapped + test, level),
        move("steady", wrapped + test, level),
        move("lift", lifted, level),
        move("carry", lifted + goal.aside, level),
        wrap_move("hold", goal.hold, lifted + goal.aside, level, last.rotation),
        move("bring", lowered + test + high, level),
        wrap_move("lower", lowering * move_time(design, "lower"), lowered - SINK * _UP, level, last.rotation),
        *(move("uncurl", place + step.opening, step.slackening, open_) for step in reversed(eased)),
        wrap_move("open", OPEN_TIME, opened, sprung, open_.rotation),
        wrap_move("open", move_time(design, "settle"), opened, sprung, open_.rotation),
        move("draw off", away, slack, open_),
        move("leave", away + high, slack, open_),
        move("rest", away + high, slack, open_),
    )


def _tension(design: TrunkDesign, differential: float, ventral: float) -> np.ndarray:
    """Cable tensions for a ventral pull [N]: small ones lift the tail, larger ones curl in the wanted plane."""
    shut = shut_pull(design)
    tail = TAIL * shut[-1] * max(0.0, 1.0 - ventral / (TAIL_END * shut[0]))
    turn = float(np.interp(ventral / shut[0], TURNING, (0.0, differential)))
    tension = cable_pulls(design, ventral, float(tail) + turn * ventral)
    return tension * min(1.0, 0.95 * design.cable.tension_max / max(float(tension.max()), 1e-9))


def _wrap_height(
    observation: Observation, plane: WrapPlane, tilts: np.ndarray, first: np.ndarray, may_be_near_rim: bool
) -> float:
    """Height of the wrap over the ground at which the housing clears the ground at every step [m].

    It also clears the ground at release: an object that was wrapped in a falling plane is turned back until it is
    level, about itself, and the base behind it sinks.

    Raises:
        ModelError: where the object is too short.
    """
    length, design = observation.task.target.length, observation.task.design
    sink = np.array([housing_sink(design, float(tilt)) for tilt in tilts])
    behind, turn = float(first[-1, 1]), float(tilts[0] - tilts[-1])
    back = first[-1, 2] * math.cos(turn) + behind * math.sin(turn)
    is_slender = math.atan(observation.task.target.width / length) < SLENDER
    asked = max(plane.height, plane.slender_height) if is_slender else plane.height
    height = max(asked * length, float((sink + first[:, 2]).max()) + plane.ground_gap)
    height = max(height, float(sink[0] + back) + plane.ground_gap + SAG * design.length * turn)
    target = observation.task.target
    is_narrow = widths_between(target, *loop_band(target))[1] <= NARROW * design.length
    highest = HIGHEST_NARROW if is_narrow and not may_be_near_rim else HIGHEST
    if height > highest * length:
        least = f"{math.ceil(1e3 * height / highest - 1e-6)} mm"
        raise ModelError(f"the object is {1e3 * length:.0f} mm tall; allowed: {least} or more, to clear the ground")
    return height


def housing_sink(design: TrunkDesign, tilt: float) -> float:
    """Depth of the housing's lowest point below the trunk's base at a ``tilt`` from hanging [rad] [m]."""
    housing = design.housing
    end = housing.neck_length + (housing.length if tilt > math.pi / 2 else 0.0)
    return housing.radius * math.sin(tilt) - end * math.cos(tilt)


def housing_gap(design: TrunkDesign, tilt: float, center: np.ndarray) -> float:
    """Horizontal distance between the housing and the vertical line through a point [m].

    Args:
        design: the trunk.
        tilt: of the base axis from hanging straight down [rad].
        center: the point, level, from the base, shape (3,) [m].
    """
    aside, ahead = abs(float(center[0])), float(center[1])
    housing, back = design.housing, -math.sin(tilt)
    ends = np.array([housing.neck_length, housing.neck_length + housing.length])
    angle = np.linspace(0.0, math.pi, 181)[:, None]
    # A disc about the axis: half of its rim on the side of the point, seen from above.
    x, y = housing.radius * np.sin(angle), back * ends + housing.radius * math.cos(tilt) * np.cos(angle)
    return float(np.hypot(np.maximum(aside - x, 0.0), ahead - y).min())


def clear_height(design: TrunkDesign, rotation: np.ndarray, gap: float) -> float:
    """Least height of the trunk's base over the ground at which housing and wrist clear it [m].

    Args:
        design: the trunk.
        rotation: orientation of the base in the world, shape (3, 3) [-].
        gap: height of the housing over the ground [m].
    """
    tilt = math.acos(max(-1.0, min(1.0, -float(rotation[2, 0]))))
    radius, behind, wrist_gap = WRIST
    wrist = radius * math.sin(tilt) - behind * math.cos(tilt) + wrist_gap
    return max(housing_sink(design, tilt) + gap, wrist)
