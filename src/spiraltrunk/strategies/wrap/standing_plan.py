"""Where arm and cables go to wrap an object that stands: from its place and size, the design, and the model."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.control.messages import Observation, Target
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, ModelError
from spiraltrunk.strategies.moves import Move
from spiraltrunk.strategies.options import check_choices
from spiraltrunk.strategies.wrap.standing_model import cable_pulls, curl_tilt, object_center, shut_pull

STEPS = (0.0, 0.07, 0.15, 0.22, 0.30, 0.41, 0.56, 0.75, 1.1)
"""Ventral pulls at which the model places the arm, over the pull that shuts joint 1 [-]; closer where the tip curls."""

SLENDER = math.radians(15.0)
"""Lean that may be left when the head of an oblique wrap has turned as far as its housing clears the ground [rad], as
simulated: what topples at less is wrapped higher, where the head can turn all of it away."""

_ACTIONS = {
    "reach": ("turn", "descend", "touch"),
    "prehension": ("curl", "tighten", "try"),
    "transport": ("level", "steady", "lift", "carry", "hold"),
    "release": ("bring", "lower", "uncurl", "open", "draw off", "leave", "rest"),
}
_PHASE = {action: phase for phase, actions in _ACTIONS.items() for action in actions}
"""What belongs to which phase."""

_MILESTONES = {
    "touch": Milestone.TOUCHED,
    "lift": Milestone.LIFTED,
    "carry": Milestone.CARRIED,
    "hold": Milestone.HELD,
    "lower": Milestone.SET_DOWN,
    **dict.fromkeys(("uncurl", "open", "draw off", "leave", "rest"), Milestone.RELEASED),
}
"""What the actions work towards."""


@final
@dataclass(frozen=True, kw_only=True)
class StandingOptions:
    """What the strategy chooses."""

    plane: float
    """How far the plane of the curled trunk, not yet loaded, falls ahead of the base [rad]; 0 is level."""
    reach_plane: float = math.radians(-12.0)
    """The same while the tail goes round the object: rising, as a slack tail hangs [rad]."""
    turning: tuple[float, float] = (0.30, 0.75)
    """Ventral pulls between which the plane turns from the one to the other, over the pull that shuts joint 1 [-]."""
    differential: float
    """Pull along the trunk's z over the ventral one [-]: unequal ventral cables, which turn the plane of bending."""
    height: float
    """Where to wrap, over the object's length [-]; higher where the housing would touch the ground."""
    slender_height: float = 0.0
    """The same at least for what topples at less than ``SLENDER`` [-]."""
    highest: float = 0.85
    """Where to wrap at most, over the object's length [-]."""
    ground_gap: float = 0.03
    """Gap between housing and ground [m]."""
    tail: float = 0.8
    """Pull that lifts the tail, over the one that shuts the last joint [-]."""
    tail_end: float = 0.30
    """Ventral pull at which the tail is no longer lifted, over the one that shuts joint 1 [-]."""
    sag: float = 0.08
    """How far the base sinks besides while a falling plane is turned back, over the trunk's length and that turn, as
    simulated [1/rad]: cables made equal also turn what is held."""
    clearance: float = 0.24
    """Gap to the object before the touch, over the trunk's length [-]."""
    overshoot: float = 0.03
    """How far the arm goes beyond the expected touch, over the trunk's length [-]."""
    early: float = 0.05
    """How far before the expected touch one is believed, over the trunk's length [-]: a tail may brush the ground."""
    touch: float = 0.012
    """Cable by which the trunk bends back, over the stroke, that counts as a touch [-]."""
    relief: float = 0.02
    """How far the arm goes back from the touch, over the trunk's length [-]: what is pressed on is dragged."""
    curl_time: float = 0.9
    """Time from one step of the ventral pull to the next [s]."""
    grip: float = 1.2
    """Ventral pull of the tightened wrap, over the one that shuts joint 1 [-]."""
    carry: float = 1.0
    """What is added to it for the load, over the pull that balances the object's weight beside the base [-]."""
    rest: int = 2
    """Section, from 0 at the base, at which a tightly wrapped object rests, and is let go from, as simulated."""
    spring: float = 0.56
    """Ventral pull from which the trunk is let spring open, over the one that shuts joint 1 [-]."""
    open_time: float = 0.06
    """Time in which it goes slack [s]: as fast as winders can."""
    settle_time: float = 0.8
    """Time in which it then comes to rest [s]."""
    back_off: float = 0.20
    """How far the arm backs off sideways while the tail opens, over the trunk's length [-]: it would push."""
    test: float = 0.02
    """How far the object is lifted to feel whether it is held [m]."""
    borne: float = 0.5
    """Part of the object's weight that tells whether it is carried or set down [-]."""
    sink: float = 0.012
    """How far below its start the arm seeks the ground when setting down [m]."""
    retries: int = 1
    """How often to try again [-]."""

    def __post_init__(self) -> None:
        signed = ("plane", "reach_plane", "differential")
        check_choices(self, positive=("curl_time", "open_time", "settle_time"), signed=signed)
        if self.turning[0] >= self.turning[1]:
            raise DesignError("StandingOptions.turning", got=self.turning, allowed="the smaller pull first")


def side_of(observation: Observation) -> np.ndarray:
    """Horizontal direction in which a trunk that still hangs shall curl: right of its ventral side, shape (3,) [-]."""
    return -_unit(observation.T_world_base[:3, 2])


@final
@dataclass(frozen=True, kw_only=True)
class _Step:
    """Arm and cables at one ventral pull, places level over the ground below the object."""

    pull: float
    """Ventral pull over the one that shuts joint 1 [-]."""
    tension: np.ndarray
    """Cable tensions as the trunk closes, shape (n_cable,) [N]."""
    slackening: np.ndarray
    """Cable tensions as it opens, its plane level, shape (n_cable,) [N]."""
    rotation: np.ndarray
    """Orientation of the base in the world, shape (3, 3) [-]."""
    closing: np.ndarray
    """Place of the base as the trunk closes, shape (3,) [m]."""
    opening: np.ndarray
    """Place of the base as it opens: what is wrapped lies deeper in the curl, shape (3,) [m]."""


def plan_moves(observation: Observation, options: StandingOptions) -> tuple[Move, ...]:
    """All moves from a hanging trunk over grasp and release to the trunk beside the object.

    Raises:
        ModelError: where the cables cannot pull as needed, or the object is too short.
    """
    steps, lever = _steps(observation, options)
    design, shut = observation.task.design, shut_pull(observation.task.design)
    load = observation.task.target.mass * GRAVITY * lever
    grip = options.grip + options.carry * load / float(design.joint_stiffness[0] * design.joint_limit)
    tight, level = (_tension(design, options, float(grip * shut[0]), part) for part in (1.0, 0.0))
    return _moves(observation, options, steps, tight, level)


def _steps(observation: Observation, options: StandingOptions) -> tuple[tuple[_Step, ...], float]:
    """The steps of the curl, and how far beside the base the object ends [m]."""
    design, width = observation.task.design, _round_width(observation.task.target)
    shut = float(shut_pull(design)[0])
    side = side_of(observation)
    frame = np.column_stack([side, _ahead(side), np.array([0.0, 0.0, 1.0])])
    tilts = _tilts(design, width, options)
    tensions = [_tension(design, options, pull * shut) for pull in STEPS]
    slackening = [_tension(design, options, pull * shut, 0.0) for pull in STEPS]
    at = zip(tilts, tensions, strict=True)
    first = np.array([object_center(design, width, tilt, tension) for tilt, tension in at])
    deep = np.array([object_center(design, width, tilts[0], tension, options.rest) for tension in slackening])
    middle = np.array([0.0, 0.0, _height(observation, options, tilts, first)])
    closing = (middle - first) @ frame.T
    opening = closing[-1] + (deep[-1] - deep) @ frame.T
    opening[:, 2] = closing[0, 2]  # The housing clears the ground on this way.
    off = -options.back_off * design.length * frame[:, 0]
    steps = tuple(
        _Step(
            pull=pull, tension=tensions[i], slackening=slackening[i], rotation=frame @ _base_axes(tilts[i]),
            closing=closing[i], opening=opening[i] + _opened(options, pull) * off,
        )
        for i, pull in enumerate(STEPS)
    )  # fmt: skip
    return steps, float(np.linalg.norm(first[-1, :2]))


def _moves(
    observation: Observation, options: StandingOptions, steps: tuple[_Step, ...], tight: np.ndarray, level: np.ndarray
) -> tuple[Move, ...]:
    design, goal = observation.task.design, observation.task.goal
    seen = observation.task.target.position if observation.look is None else observation.look.position
    side, up = side_of(observation), np.array([0.0, 0.0, 1.0])
    start, place = (np.array([*where[:2], _ground(observation)]) for where in (seen, goal.place))
    clear, beyond = -options.clearance * design.length * side, options.overshoot * design.length * side
    high, test, last = goal.lift * up, options.test * up, steps[-1]
    touch, wrapped, away = start + steps[0].closing, start + last.closing, place + steps[0].opening

    def move(action: str, duration: float, position: np.ndarray, tension: np.ndarray, step: _Step = last) -> Move:
        return Move(
            phase=_PHASE[action], action=action, milestone=_MILESTONES.get(action), duration=duration,
            position=position, tension=tension, rotation=step.rotation,
        )  # fmt: skip

    slack, eased = steps[0].tension, [step for step in steps if step.pull >= options.spring]
    return (
        move("turn", 3.0, touch + clear + high, slack, steps[0]),
        move("descend", 2.0, touch + clear, slack, steps[0]),
        move("touch", 4.0, touch + beyond, slack, steps[0]),
        *(move("curl", options.curl_time, start + step.closing, step.tension, step) for step in steps[1:]),
        move("tighten", 2.0, wrapped, tight),
        move("try", 1.0, wrapped + test, tight),
        move("level", 1.5, wrapped + test, level),
        move("steady", 1.5, wrapped + test, level),
        move("lift", 2.5, wrapped + test + high, level),
        move("carry", 2.5, wrapped + test + high + goal.aside, level),
        move("hold", goal.hold, wrapped + test + high + goal.aside, level),
        move("bring", 1.5, place + last.closing + test + high, level),
        move("lower", 4.5, place + last.closing - options.sink * up, level),
        *(
            move("uncurl", options.curl_time, place + step.opening, step.slackening, steps[0])
            for step in reversed(eased)
        ),
        move("open", options.open_time, place + eased[0].opening, slack, steps[0]),
        move("open", options.settle_time, place + eased[0].opening, slack, steps[0]),
        move("draw off", 2.0, away, slack, steps[0]),
        move("leave", 2.0, away + high, slack, steps[0]),
        move("rest", 1.0, away + high, slack, steps[0]),
    )


def _tilts(design: TrunkDesign, width: float, options: StandingOptions) -> np.ndarray:
    """Tilt of the base at each step: from the plane of the reach to that of the wrap, shape (n_step,) [rad]."""
    full = cable_pulls(design, float(STEPS[-1] * shut_pull(design)[0]), 0.0)
    ends = [curl_tilt(design, width, full, plane) for plane in (options.reach_plane, options.plane)]
    return np.interp(STEPS, options.turning, ends)


def _tension(design: TrunkDesign, options: StandingOptions, ventral: float, part: float = 1.0) -> np.ndarray:
    """Cable tensions for a ventral pull [N]: small ones lift the tail, larger ones curl in the wanted plane.

    ``part`` of the turn of that plane by unequal cables is made.
    """
    shut = shut_pull(design)
    tail = options.tail * shut[-1] * max(0.0, 1.0 - ventral / (options.tail_end * shut[0]))
    turn = float(np.interp(ventral / shut[0], options.turning, (0.0, options.differential)))
    tension = cable_pulls(design, ventral, float(tail) + part * turn * ventral)
    return tension * min(1.0, 0.95 * design.cable.tension_max / max(float(tension.max()), 1e-9))


def _round_width(target: Target) -> float:
    """Diameter of the cylinder that takes as much trunk to go round as the object [m]: for a square, pi d = 4 w."""
    return target.width * (4 / math.pi if target.kind == "box" else 1.0)


def _opened(options: StandingOptions, step: float) -> float:
    """How far the tail is open again, 0 to 1, at a step of the ventral pull [-]."""
    return max(0.0, 1.0 - step / options.tail_end)


def _height(observation: Observation, options: StandingOptions, tilts: np.ndarray, first: np.ndarray) -> float:
    """Height over the ground at which to wrap, so that the housing stays above it at every step [m].

    Also when the object is set down: what was wrapped in a falling plane is turned back until it is level, about the
    object, and the base, which is behind it, sinks.
    """
    length, design = observation.task.target.length, observation.task.design
    sink = np.array([housing_sink(design, float(tilt)) for tilt in tilts])
    behind, turn = float(first[-1, 1]), float(tilts[0] - tilts[-1])
    back = first[-1, 2] * math.cos(turn) + behind * math.sin(turn)
    is_slender = math.atan(observation.task.target.width / length) < SLENDER
    asked = max(options.height, options.slender_height) if is_slender else options.height
    height = max(asked * length, float((sink + first[:, 2]).max()) + options.ground_gap)
    height = max(height, float(sink[0] + back) + options.ground_gap + options.sag * design.length * turn)
    if height > options.highest * length:
        least = f"{1e3 * height / options.highest:.0f} mm"
        raise ModelError(f"the object is {1e3 * length:.0f} mm tall; allowed: {least} or more, to clear the ground")
    return height


def housing_sink(design: TrunkDesign, tilt: float) -> float:
    """How far the housing reaches below the trunk's base when that is tilted from hanging by ``tilt`` [rad] [m]."""
    housing = design.housing
    end = housing.neck_length + (housing.length if tilt > math.pi / 2 else 0.0)
    return housing.radius * math.sin(tilt) - end * math.cos(tilt)


def _base_axes(tilt: float) -> np.ndarray:
    """Axes of the trunk's base, in the level frame (aside, ahead, up), shape (3, 3) [-]."""
    along = np.array([0.0, math.sin(tilt), -math.cos(tilt)])
    dorsal = np.array([-1.0, 0.0, 0.0])
    return np.column_stack([along, dorsal, np.cross(along, dorsal)])


def _ground(observation: Observation) -> float:
    target: Target = observation.task.target
    ground = observation.task.goal.ground
    return float(target.position[2] - target.length / 2) if ground is None else ground


def _ahead(side: np.ndarray) -> np.ndarray:
    return np.cross(np.array([0.0, 0.0, 1.0]), side)


def _unit(vector: np.ndarray) -> np.ndarray:
    level = np.array([vector[0], vector[1], 0.0])
    return level / np.linalg.norm(level)
