"""Where arm and cables go to wrap an object that stands: from its place and size, the design, and the model."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.model.wrap_beside import cable_pulls, curl_tilt, object_center, shut_pull
from spiraltrunk.plant import Observation, Target
from spiraltrunk.strategies.phases import Move

_STEPS = (0.0, 0.07, 0.15, 0.22, 0.30, 0.41, 0.56, 0.75, 1.1)
"""Ventral pulls at which the model places the arm, over the pull that shuts joint 1 [-]; closer where the tip curls."""


@final
@dataclass(frozen=True, kw_only=True)
class StandingOptions:
    """What the strategy chooses."""

    plane: float
    """How far the plane of the curled trunk, not yet loaded, falls ahead of the base [rad]; 0 is level."""
    differential: float
    """Pull along the trunk's z over the ventral one [-]: unequal ventral cables, which turn the plane of bending."""
    height: float
    """Where to wrap, over the object's length [-]; higher where the housing would touch the ground."""
    highest: float = 0.85
    """Where to wrap at most, over the object's length [-]."""
    ground_gap: float = 0.03
    """Gap between housing and ground [m]."""
    tail: float = 0.8
    """Pull that lifts the tail, over the one that shuts the last joint [-]."""
    tail_end: float = 0.30
    """Ventral pull at which the tail is no longer lifted, over the one that shuts joint 1 [-]."""
    clearance: float = 0.24
    """Gap to the object before the touch, over the trunk's length [-]."""
    overshoot: float = 0.08
    """How far the arm goes beyond the expected touch, over the trunk's length [-]."""
    touch: float = 0.012
    """Cable by which the trunk bends back, over the stroke, that counts as a touch [-]."""
    curl_time: float = 0.9
    """Time from one step of the ventral pull to the next [s]."""
    grip: float = 0.8
    """Ventral pull of the tightened wrap, over the one that shuts joint 1 [-]."""
    carry: float = 1.0
    """What is added to it for the load, over the pull that balances the object's weight beside the base [-]."""
    depth: int = 4
    """How many sections nearer to the base than at the first touch the wrapped object lies: where it is let go [-]."""
    back_off: float = 0.20
    """How far the arm backs off sideways while the tail opens, over the trunk's length [-]: it would push."""
    drag: tuple[float, float] = (0.065, 0.03)
    """How far the opening trunk drags the object back (aside, ahead), over the trunk's length [-], as simulated."""
    test: float = 0.02
    """How far the object is lifted to feel whether it is held [m]."""
    borne: float = 0.5
    """Part of the object's weight that tells whether it is carried or set down [-]."""
    slip: float = 0.04
    """Cable that pays out while lifting, over the stroke, that counts as unrolling [-]."""
    sink: float = 0.012
    """How far below its start the arm seeks the ground when setting down [m]."""
    retries: int = 1
    """How often to try again [-]."""


def side_of(observation: Observation) -> np.ndarray:
    """Horizontal direction in which the trunk curls, shape (3,) [-]: to the right of where its ventral side looks."""
    return -_unit(observation.T_world_base[:3, 2])


def plan_moves(observation: Observation, options: StandingOptions) -> tuple[Move, ...]:
    """All moves from a hanging trunk over grasp and release to the trunk beside the object.

    Raises:
        ModelError: where the cables cannot pull as needed, or the object is too short.
    """
    design, target = observation.task.design, observation.task.target
    shut = shut_pull(design)
    full = _tension(design, options, float(_STEPS[-1] * shut[0]))
    tilt = curl_tilt(design, target.width, full, options.plane)
    frame = np.column_stack([side_of(observation), _ahead(observation), np.array([0.0, 0.0, 1.0])])
    tensions = [_tension(design, options, float(step * shut[0])) for step in _STEPS]
    centers = np.array([object_center(design, target.width, tilt, tension) for tension in tensions])
    height = _height(observation, options, tilt, float(centers[:, 2].max()))
    places = np.array([0.0, 0.0, height]) - centers @ frame.T
    rotation = frame @ _base_axes(tilt)
    load = target.mass * GRAVITY * float(np.linalg.norm(centers[-1, :2]))
    grip = options.grip + options.carry * load / float(design.joint_stiffness[0] * design.joint_limit)
    tight = _tension(design, options, float(grip * shut[0]))
    deep = np.array([object_center(design, target.width, tilt, tension, options.depth) for tension in tensions])
    opening = places[-1] + (deep[-1] - deep) @ frame.T
    return _moves(observation, options, rotation, list(zip(places, opening, tensions, strict=True)), tight)


def _moves(
    observation: Observation,
    options: StandingOptions,
    rotation: np.ndarray,
    steps: list[tuple[np.ndarray, np.ndarray, np.ndarray]],
    tight: np.ndarray,
) -> tuple[Move, ...]:
    design, goal = observation.task.design, observation.task.goal
    seen = observation.task.target.position if observation.look is None else observation.look.position
    start, place = (np.array([*where[:2], _ground(observation)]) for where in (seen, goal.place))
    side, up = side_of(observation), np.array([0.0, 0.0, 1.0])
    (touch, open_, slack), (wrapped, _, _) = steps[0], steps[-1]
    place = place + design.length * (options.drag[0] * side + options.drag[1] * _ahead(observation))
    clear, beyond = -options.clearance * design.length * side, options.overshoot * design.length * side
    high, back = goal.lift * up, options.back_off * design.length * side

    def move(phase: str, action: str, duration: float, position: np.ndarray, tension: np.ndarray) -> Move:
        return Move(
            phase=phase, action=action, duration=duration, position=position, tension=tension, rotation=rotation
        )

    return (
        move("reach", "turn", 3.0, start + touch + clear + high, slack),
        move("reach", "descend", 2.0, start + touch + clear, slack),
        move("reach", "touch", 4.0, start + touch + beyond, slack),
        *(move("prehension", "curl", options.curl_time, start + there, tension) for there, _, tension in steps[1:]),
        move("prehension", "tighten", 2.0, start + wrapped, tight),
        move("prehension", "try", 1.0, start + wrapped + options.test * up, tight),
        move("transport", "lift", 2.5, start + wrapped + options.test * up + high, tight),
        move("transport", "carry", 2.5, start + wrapped + options.test * up + high + goal.aside, tight),
        move("transport", "hold", goal.hold, start + wrapped + options.test * up + high + goal.aside, tight),
        move("release", "bring", 1.5, place + wrapped + options.test * up + high, tight),
        move("release", "lower", 4.5, place + wrapped - options.sink * up, tight),
        *(
            move("release", "uncurl", options.curl_time, place + there - _opened(options, step) * back, tension)
            for step, (_, there, tension) in reversed(list(zip(_STEPS, steps, strict=True)))
        ),
        move("release", "leave", 2.0, place + open_ + clear, slack),
        move("release", "rest", 1.5, place + open_ + clear + high, 0.0 * slack),
    )


def _tension(design: TrunkDesign, options: StandingOptions, ventral: float) -> np.ndarray:
    """Cable tensions for a ventral pull [N]: small ones lift the tail, larger ones curl in the wanted plane."""
    shut = shut_pull(design)
    tail = options.tail * shut[-1] * max(0.0, 1.0 - ventral / (options.tail_end * shut[0]))
    tension = cable_pulls(design, ventral, float(tail) + options.differential * ventral)
    return tension * min(1.0, 0.95 * design.cable.tension_max / max(float(tension.max()), 1e-9))


def _opened(options: StandingOptions, step: float) -> float:
    """How far the tail is open again, 0 to 1, at a step of the ventral pull [-]."""
    return max(0.0, 1.0 - step / options.tail_end)


def _height(observation: Observation, options: StandingOptions, tilt: float, rise: float) -> float:
    """Height over the ground at which to wrap, so that the housing stays above it [m]."""
    housing, length = observation.task.design.housing, observation.task.target.length
    end = housing.neck_length + housing.length
    sink = max(-end * math.cos(tilt), -housing.neck_length * math.cos(tilt)) + housing.radius * math.sin(tilt)
    height = max(options.height * length, sink + options.ground_gap + rise)
    if height > options.highest * length:
        least = f"{1e3 * height / options.highest:.0f} mm"
        raise ModelError(f"the object is {1e3 * length:.0f} mm tall; allowed: {least} or more, to clear the ground")
    return height


def _base_axes(tilt: float) -> np.ndarray:
    """Axes of the trunk's base, in the level frame (aside, ahead, up), shape (3, 3) [-]."""
    along = np.array([0.0, math.sin(tilt), -math.cos(tilt)])
    dorsal = np.array([-1.0, 0.0, 0.0])
    return np.column_stack([along, dorsal, np.cross(along, dorsal)])


def _ground(observation: Observation) -> float:
    target: Target = observation.task.target
    ground = observation.task.goal.ground
    return float(target.position[2] - target.length / 2) if ground is None else ground


def _ahead(observation: Observation) -> np.ndarray:
    return np.cross(np.array([0.0, 0.0, 1.0]), side_of(observation))


def _unit(vector: np.ndarray) -> np.ndarray:
    level = np.array([vector[0], vector[1], 0.0])
    return level / np.linalg.norm(level)
