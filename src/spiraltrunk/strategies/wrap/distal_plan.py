"""Moves of a distal wrap of a standing object: on the ground, only the part of the trunk that wraps it closes.

A full wrap closes the base as well, and needs an object so tall that the housing clears the ground; `plan_wrap` chooses
between the two. In a distal wrap the base stays open, and high, until the object is borne; it closes in the rise that
tests the load. The base keeps one tilt, the flattest at which the housing clears the ground. The wrapping sections keep
their mean height while the trunk curls.

Width and height of the object decide: the wider it is, the nearer to the base the wrap begins, and the further the
trunk closes on the ground; the taller it is, the higher the wrap and the flatter its plane. An object is wrapped above
its centre, so that its weight keeps it upright, and below its rim. Strategies 4 to 6 differ in the share of the height
at which they wrap. Up to about 100 mm of height their plans are nearly the same, as the clearance of housing and trunk
decides. The height of a cylinder from which they wrap it in full, with the paper's trunk (what is wider than 96 mm may
be wrapped nearer to its rim, `standing_plan.HIGHEST`):

| width | 4, 5 (oblique) | 6 (horizontal) |
|---|---|---|
| 40 mm | 168 mm | 184 mm |
| 60 mm | 157 mm | 186 mm |
| 80 mm | 147 mm | 202 mm |
| 100 mm | 139 mm | 189 mm |

A plan exists from 40 to 65 mm of height on, by the width; what is lower than 69 mm topples (`assess.LOW`).
Lengths are over the trunk's own where their unit is [-] and nothing else is said.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.control.messages import Observation, Task
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.strategies.moves import Move, tilted_base
from spiraltrunk.strategies.object_measures import widths_between
from spiraltrunk.strategies.sensing import seen_position
from spiraltrunk.strategies.wrap.approach import approach_direction
from spiraltrunk.strategies.wrap.hung_plan import wrap_move
from spiraltrunk.strategies.wrap.standing_model import (
    band_heights,
    cable_pulls,
    girth_width,
    object_center,
    shut_pull,
    wrap_start,
)
from spiraltrunk.strategies.wrap.standing_plan import (
    BACK_OFF,
    CARRY,
    CLEARANCE,
    GRIP,
    NEAR,
    OPEN_TIME,
    OVERSHOOT,
    SLOWLY,
    TAIL_END,
    TEST,
    WrapPlane,
    housing_sink,
    move_time,
    plan_moves,
)

# All of these are ours, tuned in simulated trials.
PULLS = (0.0, 0.07, 0.15, 0.22, 0.30, 0.41, 0.56)
"""Ventral pulls at which the model places the arm, over the pull that shuts joint 1 [-]."""
CLOSE = 1.75
"""Ventral pull at which the trunk has closed on the ground, over the one that shuts the first joint of the wrap [-]; it
closes with at least the last of PULLS. As it opens, below this pull only the wrap itself holds the object."""
CLOSE_STEP = 0.19
"""Largest step from the last of PULLS to it, over the pull that shuts joint 1 [-]."""
TIGHTEN = 0.9
"""Ventral pull after which the object is lifted, over the one that shuts joint 1 [-]."""
TAIL = 1.6
"""Pull that lifts the tail, over the one that shuts the last joint [-]."""
ROOM = 1.12
"""Width that the curling trunk leaves to the object, over its largest [-]: a loose object yields to a light push."""
TILTS = np.radians(np.arange(84.0, 65.0, -2.0))
"""Tilts of the base tried, from hanging, the flattest first [rad]."""
BAND_GAP = 0.015
"""Gap between the closed trunk and the ground, where the object is tall enough [m]: loaded, the trunk sags."""
HIGHEST = 0.75
"""Largest height of the wrap's middle, over the object's length [-]."""
HEADROOM = 1.0
"""Distance of the wrap's middle below the object's top, where the ground leaves room for it, over the radius of its
first section [-]: nearer to the rim the round sections slip over it."""
TURN = 1.1
"""Duration of the turn over that of a full wrap [-]: the base ends lower, and joint 2 would come to its greatest speed,
from which it brakes too hard."""
LEAVE = 1.5
"""Duration of the retreat upwards over that of a full wrap [-]: the base of a distal wrap is nearer to the arm's foot,
where joint 2 moves further for the same way."""

_AHEAD, _UP = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])


@final
@dataclass(frozen=True, kw_only=True)
class _Step:
    """Arm and cables at one ventral pull."""

    tension: np.ndarray
    """Cable tensions, shape (n_cable,) [N]."""
    position: np.ndarray
    """Position of the base from the ground below the object, in the world's directions, shape (3,) [m]."""


def plan_wrap(observation: Observation, plane: WrapPlane) -> tuple[tuple[Move, ...], bool]:
    """Moves of a full wrap, or of a distal one where the object is too short for it, and whether they are the latter.

    A full wrap near the rim is the last choice.

    Raises:
        ModelError: where none is possible; it is the distal wrap's.
    """
    try:
        return plan_moves(observation, plane), False
    except ModelError:
        pass
    try:
        return plan_distal_moves(observation, plane), True
    except ModelError as error:
        try:
            return plan_moves(observation, plane, may_be_near_rim=True), False
        except ModelError:
            raise error from None


def plan_distal_moves(observation: Observation, plane: WrapPlane) -> tuple[Move, ...]:
    """All moves from a hanging trunk over grasp and release to the trunk beside the object.

    Raises:
        ModelError: where the cables cannot pull as needed, or the object is too short.
    """
    design, target = observation.task.design, observation.task.target
    width, loose, pulls = _choose_pulls(observation.task, plane)
    tilt, height = _choose_tilt(observation.task, plane, width, pulls[-1])
    side = approach_direction(observation, is_distal=True)
    frame = np.column_stack([side, np.cross(_UP, side), _UP])
    low = height - band_heights(design, width, tilt, _tension(design, pulls[-1]))[0]
    room = ROOM * max(width, widths_between(target, height, height)[1])

    def step(pull: float) -> _Step:
        tension = _tension(design, pull)
        aside, ahead, _ = object_center(design, room, tilt, tension)
        up = low if pull > pulls[-1] else height - band_heights(design, width, tilt, tension)[0]
        return _Step(tension=tension, position=frame @ np.array([-aside, -ahead, up]))

    steps = tuple(step(pull) for pull in pulls)
    load = target.mass * GRAVITY * float(np.linalg.norm(steps[-1].position[:2]))
    grip = GRIP + CARRY * load / float(design.joint_stiffness[0] * design.joint_limit)
    tight, held = step(max(TIGHTEN, pulls[-1] + 1e-9)), step(grip)
    return _moves(observation, (*steps, tight, held, step(loose)), frame @ tilted_base(_AHEAD, tilt))


def find_height(task: Task, plane: WrapPlane) -> float:
    """Height of a distal wrap's middle above the object's foot [m].

    Raises:
        ModelError: where the cables cannot pull as needed, or the object is too short.
    """
    width, _, pulls = _choose_pulls(task, plane)
    return _choose_tilt(task, plane, width, pulls[-1])[1]


def find_rim(task: Task, plane: WrapPlane) -> tuple[float, float]:
    """Distance of a distal wrap's middle below the object's top, and the radius of its first section [m].

    Raises:
        ModelError: as `find_height`.
    """
    width, _, _ = _choose_pulls(task, plane)
    radius = float(task.design.section_radius[wrap_start(task.design, width)])
    return task.target.length - find_height(task, plane), radius


def _choose_pulls(task: Task, plane: WrapPlane) -> tuple[float, float, tuple[float, ...]]:
    """Width of the object where it is wrapped [m], the pull at which it is loose, and those of the curl, as PULLS."""
    design, target, shut = task.design, task.target, shut_pull(task.design)
    width = girth_width(target, plane.distal_height * target.length)
    loose = CLOSE * float(shut[min(wrap_start(design, width), design.n_joint - 1)] / shut[0])
    return width, loose, _closing_pulls(loose)


def _closing_pulls(close: float) -> tuple[float, ...]:
    """Ventral pulls of the curl on the ground up to ``close``, over the one that shuts joint 1 [-]."""
    more = close - PULLS[-1]
    count = max(0, math.ceil(more / CLOSE_STEP))
    return (*PULLS, *(PULLS[-1] + more * (i + 1) / count for i in range(count)))


def _tension(design: TrunkDesign, pull: float) -> np.ndarray:
    """Cable tensions for a ventral pull over the one that shuts joint 1 [N]; small ones lift the tail."""
    shut = shut_pull(design)
    tail = TAIL * float(shut[-1]) * max(0.0, 1.0 - pull / TAIL_END)
    tension = cable_pulls(design, pull * float(shut[0]), tail)
    return tension * min(1.0, 0.95 * design.cable.tension_max / max(float(tension.max()), 1e-9))


def _choose_tilt(task: Task, plane: WrapPlane, width: float, pull: float) -> tuple[float, float]:
    """Flattest tilt of the base [rad] at which the housing clears the ground, and height of the wrap's middle [m].

    The wrap's sections clear the ground too. Where no tilt is steep enough, the steepest one is taken and the object
    is wrapped higher.

    Raises:
        ModelError: where the object is too short.
    """
    design, length = task.design, task.target.length
    tension, below_rim = _tension(design, pull), HEADROOM * float(design.section_radius[wrap_start(design, width)])
    wanted = min(plane.distal_height * length, length - below_rim)
    height = housing = tilt = math.inf
    for tilt in TILTS.tolist():
        middle, lowest = band_heights(design, width, tilt, tension)
        housing = housing_sink(design, tilt) + middle + plane.ground_gap / 2
        clear = middle - lowest
        height = max(wanted, clear, min(clear + BAND_GAP, HIGHEST * length))
        if housing <= height:
            break
    height = max(height, housing)
    if height > HIGHEST * length:
        least = f"{math.ceil(1e3 * height / HIGHEST - 1e-6)} mm"
        raise ModelError(f"the object is {1e3 * length:.0f} mm tall; allowed: {least} or more, to clear the ground")
    return tilt, height


def _moves(observation: Observation, steps: tuple[_Step, ...], rotation: np.ndarray) -> tuple[Move, ...]:
    """Moves through the steps of the curl; the last three are tight, bearing the load, and loose for the release."""
    design, goal, target = observation.task.design, observation.task.goal, observation.task.target
    ground = float(target.position[2] - target.length / 2) if goal.ground is None else goal.ground
    start, place = (np.array([*where[:2], ground]) for where in (seen_position(observation), goal.place))
    open_, tight, held, loose = steps[0], *steps[-3:]
    side = approach_direction(observation, is_distal=True)
    clear, near, beyond = (way * design.length * side for way in (-CLEARANCE, -NEAR, OVERSHOOT))
    high, test, slack = goal.lift * _UP, TEST * _UP, open_.tension
    touch, tried, lowered = start + open_.position, start + held.position + test, place + held.position
    opened = place + loose.position
    away = opened - BACK_OFF * design.length * side

    def move(action: str, position: np.ndarray, tension: np.ndarray = held.tension) -> Move:
        return wrap_move(action, move_time(design, action), position, tension, rotation)

    return (
        wrap_move("turn", TURN * move_time(design, "turn"), touch + clear + high, slack, rotation),
        move("descend", touch + clear, slack),
        move("near", touch + near, slack),
        move("touch", touch + beyond, slack),
        *(move("curl", start + step.position, step.tension) for step in steps[1:-3]),
        move("tighten", start + tight.position, tight.tension),
        move("try", tried),
        move("level", tried),
        move("steady", tried),
        move("lift", tried + high),
        move("carry", tried + high + goal.aside),
        wrap_move("hold", goal.hold, tried + high + goal.aside, held.tension, rotation),
        move("bring", lowered + test + high),
        wrap_move("lower", SLOWLY * move_time(design, "lower"), lowered, held.tension, rotation),
        move("uncurl", opened, loose.tension),
        wrap_move("open", OPEN_TIME, opened, slack, rotation),
        wrap_move("open", move_time(design, "settle"), opened, slack, rotation),
        move("draw off", away, slack),
        wrap_move("leave", LEAVE * move_time(design, "leave"), away + high, slack, rotation),
        move("rest", away + high, slack),
    )
