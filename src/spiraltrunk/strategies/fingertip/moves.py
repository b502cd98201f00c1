"""Moves of the strategies that grip with the fingers at the trunk's tip, part by part of their cycle."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.control.messages import Observation, Task
from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.strategies.fingertip.gripped_object import gripper_of, object_height
from spiraltrunk.strategies.fingertip.plan import gripping_base, opening
from spiraltrunk.strategies.moves import Move
from spiraltrunk.strategies.timing import PEAK_SPEED, still_time, travel_time

# All of these are ours, tuned in simulated trials; lengths are over a finger's own where their unit is [-].
LOOK = 0.4
"""Time above the object before the grip [s]: the camera has observed it since the start; the trunk comes to rest."""
GRIP_ACCELERATION = 0.6
"""Greatest acceleration of descent and lift [m/s^2]: at 1.2 cones, which friction barely holds, slip out."""
CHECK = 0.6
"""Time to observe and to weigh the lifted object [s]: one camera observation at least, and torques are noisy."""
LOOK_AGAIN = 1.2
"""Time to observe an object that was let go [s]: two camera observations at least, and it may roll."""
TALL = 0.05
"""Height from which an object counts as tall [m]: over it the base is near the end of the arm's reach, where an elbow
that is nearly straight turns faster than the base moves, and it leaves as slowly as it lifts."""
HOVER = 2.0
"""Height above the grip at which the robot observes and weighs [-]."""
ASIDE = 0.05
"""Displacement level that a descent may still correct, less than the fingers' room [-]."""
TURNED = math.radians(3.0)
"""Turn that a descent may still correct [rad]: the error of a camera."""
TURN_SPEED = 1.0
"""Greatest speed of a turn about the trunk's axis [rad/s]."""
SETTLE_TIME = 0.3
"""Time between descent and grip [s]: the fingers come to rest."""
CLOSE_TIME = 0.8
"""Time in which the fingers close from open [s]: twice that of the gripper's servo from slack to full tension."""
TIGHTEN_TIME = 0.3
"""Time at the full grip before the lift [s]."""
FLIP_TIME = 2.5
"""Duration of the flip, and of the way back [s]."""
TAUT_TIME = 0.3
"""Time in which cables are drawn taut before the flip [s]."""
NEAR = 0.4
"""Height above the expected touch-down from which the object is lowered slowly [-]."""
TOUCH_SPEED = 0.02
"""Mean speed there [m/s]: the loss of weight shows the touch-down after 0.2 s, 4 mm."""
EASE, EASE_TIME = 0.003, 0.3
"""Rise of the base between touch-down of a tall object and the opening [m], and its time [s]: lowered until the ground
bears it, trunk and object are pressed together and bend sideways, most as the fingers let go of it."""
OPEN_TIME = 0.8
"""Time in which the fingers open [s]."""
REST_TIME = 0.3
"""Time at rest at the end [s]."""


@final
@dataclass(frozen=True, kw_only=True)
class Curl:
    """Command of the cables while the object is carried."""

    tension: np.ndarray
    """Tension ceilings, shape (n_cable,) [N]."""
    pull: np.ndarray
    """Upper bounds of the cable pulls, shape (n_cable,) [m]."""


def hover(observation: Observation, base: np.ndarray) -> np.ndarray:
    """Position of the base above the one that grips, shapes (3,) [m]."""
    return base + np.array([0.0, 0.0, HOVER * gripper_of(observation.task).finger_length])


def reach(observation: Observation, place: np.ndarray, rotation: np.ndarray) -> tuple[Move, ...]:
    """Go above the object at ``place``, shape (3,) [m], turned to ``rotation``, shape (3, 3) [-], and observe."""
    over = hover(observation, gripping_base(observation.task, place))
    approach = Move(
        phase="reach", action="approach", gripper=opening(observation.task), position=over, rotation=rotation,
        duration=still_time(observation.task.design, over - observation.T_world_base[:3, 3]),
        tension=np.zeros(observation.cable_tension.shape),
    )  # fmt: skip
    return approach, replace(approach, action="look", duration=LOOK)


def grip(
    above: Move, observation: Observation, base: np.ndarray, rotation: np.ndarray, hold: float
) -> tuple[Move, ...]:
    """Go down from ``above`` round the object to ``base``, shape (3,) [m], close, lift, and check.

    ``rotation`` is the orientation there, shape (3, 3) [-], ``hold`` the gripper command that holds [-].
    """
    task, over = observation.task, np.array([base[0], base[1], above.position[2]])
    lift = np.array([0.0, 0.0, task.goal.lift])
    rise = travel_time(lift, acceleration=GRIP_ACCELERATION)
    turn = _turn(above, observation, over, rotation)
    down = travel_time(base - over, acceleration=GRIP_ACCELERATION)
    descend = replace(above, phase="reach", action="descend", duration=down, position=base, rotation=rotation)
    settle = replace(descend, action="settle", duration=SETTLE_TIME)
    closed = replace(settle, phase="prehension", action="tighten", duration=TIGHTEN_TIME, gripper=hold)
    close = replace(closed, action="close", milestone=Milestone.TOUCHED, duration=CLOSE_TIME)
    lifted = replace(closed, phase="transport", position=base + lift)
    return (
        *turn, descend, settle, close, closed,
        replace(lifted, action="lift", milestone=Milestone.LIFTED, duration=rise),
        replace(lifted, action="check", duration=CHECK),
    )  # fmt: skip


def _turn(above: Move, observation: Observation, over: np.ndarray, rotation: np.ndarray) -> tuple[Move, ...]:
    """The move over the grip; none where the descent can correct what is left."""
    way, T_world_base = over - above.position, observation.T_world_base
    angle = math.acos(float(np.clip((np.trace(T_world_base[:3, :3].T @ rotation) - 1) / 2, -1.0, 1.0)))
    duration = PEAK_SPEED * angle / TURN_SPEED if angle > TURNED else 0.0
    if float(np.linalg.norm(way)) > ASIDE * gripper_of(observation.task).finger_length:
        duration = max(duration, still_time(observation.task.design, way))
    turn = replace(above, phase="reach", action="turn", duration=duration, position=over, rotation=rotation)
    return (turn,) if duration > 0 else ()


def carry(checked: Move, observation: Observation, curl: Curl | None, place: np.ndarray) -> tuple[Move, ...]:
    """Curl where there is a curl, carry aside and hold; uncurl over ``place``, shape (3,) [m], and observe there."""
    goal, design, aside = observation.task.goal, observation.task.design, observation.task.goal.aside
    across = still_time(design, aside, observation.task.target.mass)
    over = replace(
        checked, action="carry", milestone=Milestone.CARRIED, duration=across, position=checked.position + aside
    )
    hold = replace(over, action="hold", milestone=Milestone.HELD, duration=goal.hold)
    if curl is None:
        return over, hold
    straight = np.where(curl.tension > 0, 0.0, curl.pull)
    taut = replace(checked, action="draw taut", duration=TAUT_TIME, tension=curl.tension, pull=straight)
    flip = replace(taut, action="flip", duration=FLIP_TIME, pull=curl.pull)
    over, hold = (replace(move, tension=curl.tension, pull=curl.pull) for move in (over, hold))
    back = replace(flip, phase="release", action="flip back", position=place, pull=straight)
    return taut, flip, over, hold, back, replace(back, action="look over", duration=CHECK)


def is_tall(task: Task) -> bool:
    """Whether the object is taller than `TALL`."""
    return object_height(task) > TALL


def put(held: Move, observation: Observation, base: np.ndarray, gripper: float) -> tuple[Move, ...]:
    """Lower the base to ``base``, shape (3,) [m], at which the object stands; rise by `EASE` where it is tall; open
    with ``gripper`` [-]; leave.
    """
    task = observation.task
    slowly = np.array([0.0, 0.0, min(NEAR * gripper_of(task).finger_length, held.position[2] - base[2])])
    near, above = base + slowly, np.array([base[0], base[1], held.position[2]])
    still = still_time(task.design, above - held.position, task.target.mass)
    bring = replace(
        held, phase="release", action="bring", milestone=None, position=near, tension=0.0 * held.tension,
        duration=max(travel_time(near - held.position), still),
    )  # fmt: skip
    down = max(CONTROL_PERIOD, float(slowly[2]) / TOUCH_SPEED)
    lower = replace(bring, action="lower", milestone=Milestone.SET_DOWN, duration=down, position=base)
    up = base + np.array([0.0, 0.0, EASE])
    eased = (lower, replace(lower, action="ease", duration=EASE_TIME, position=up)) if is_tall(task) else (lower,)
    let_go = replace(eased[-1], action="open", milestone=Milestone.RELEASED, duration=OPEN_TIME, gripper=gripper)
    rise = travel_time(above - base, acceleration=GRIP_ACCELERATION) if is_tall(task) else travel_time(above - base)
    leave = replace(let_go, action="leave", duration=rise, position=above)
    return bring, *eased, let_go, leave, replace(leave, action="rest", duration=REST_TIME)


def again(checked: Move, base: np.ndarray, above: np.ndarray, gripper: float) -> tuple[Move, ...]:
    """Go down to ``base``, let go with ``gripper`` [-], rise to ``above``, and observe again; positions (3,) [m]."""
    way = travel_time(base - checked.position)
    down = replace(checked, phase="prehension", action="return", duration=way, position=base)
    let_go = replace(down, action="let go", duration=OPEN_TIME, gripper=gripper)
    rise = replace(let_go, phase="reach", action="rise", duration=travel_time(above - base), position=above)
    return down, let_go, rise, replace(rise, action="look", duration=LOOK_AGAIN)
