"""Position, orientation and commands of the tip gripper: geometry of the strategies that grip with the fingers.

The trunk hangs straight, so that its end is where the arm puts it, to a fraction of a millimetre.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from spiraltrunk.control.messages import Target, Task
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.errors import ModelError
from spiraltrunk.strategies.fingertip.finger_model import closing_tension, opening_tension
from spiraltrunk.strategies.fingertip.gripped_object import (
    as_gripped,
    find_widths,
    gripper_of,
    ground_height,
    is_slab,
    is_wide,
    is_wide_cylinder,
    object_height,
    passed_width,
    upper_width,
)
from spiraltrunk.strategies.object_measures import cone_slope

# All of these are ours, tuned in simulated trials; lengths are over a finger's own.
CLEARANCE = 0.05
"""Gap between the trunk's end and the object [-]."""
GROUND_GAP = 0.02
"""Gap between straight fingers and the ground [-]: thin objects lie near the fingers' ends, and creep off them."""
REACH = 0.75
"""Least depth of the object's middle below the trunk's end [-]."""
ROOM = 0.08
"""Gap between open fingertips and a centred object of the largest size [-]: the error of a camera's observation."""
SIZE_ERROR = 0.10
"""Largest excess of the object's size over the announced one [-]."""
FALLEN = math.radians(30.0)
"""Angle between announced and seen axis from which the object has fallen over [rad]."""
SEEN_ERROR = 0.004
"""Largest error of the observed height of the object's middle [m]."""
SAFETY = 3.0
"""Announced friction over the friction that the grip counts on [-]."""
PRESS_LEAST = 0.5
"""Least force of a fingertip over its largest [-]."""

ROUND_REACH = 0.85
"""Largest depth of a wide lying cylinder's middle below the trunk's end [-]: nearer to their ends the fingers press on
its upper half, off which they slip. In simulated trials 8 of 10 succeeded between 0.77 and 0.85, and 5 of 10 beyond."""
WIDE_REACH = 0.90
"""Least depth of a wide lying box's middle below the trunk's end [-]: nearly straight fingertips press beside it, and
not its upper edges."""

_N_HEIGHT = 39
"""Heights tried: a millimetre apart for the paper's fingers."""


def find_seen_task(task: Task, position: np.ndarray, axis: np.ndarray) -> Task:
    """The task with the object as a camera sees it, where it lies or stands otherwise than announced.

    Within the errors of sizes and cameras the announced task is kept, which knows the object better. One whose
    height the camera knows better has the height that is seen, and the announced proportions.

    Args:
        task: the task as announced.
        position: centre of the object as seen, shape (3,) [m].
        axis: its axis as seen, shape (3,) [-].
    """
    target, half = task.target, object_height(task) / 2
    way = axis / float(np.linalg.norm(axis))
    has_turned = target.kind != "sphere" and abs(float(way @ target.axis)) < math.cos(FALLEN)
    is_level = abs(float(target.axis[2])) < 0.5
    has_turned = has_turned and not (is_level and abs(float(way[2])) < math.sin(FALLEN))  # It has only turned about z.
    rise = float(position[2] - target.position[2])
    if not has_turned and abs(rise) <= SIZE_ERROR * half + SEEN_ERROR:
        return task if height_margin(2 * half) == SIZE_ERROR else _stretched(task, rise)
    handle = None if has_turned else target.handle
    axis = way if has_turned else target.axis
    return replace(task, target=replace(target, position=position, axis=axis, profile=None, handle=handle))


def height_margin(height: float, is_flat: bool = False) -> float:
    """Largest excess of an object's ``height`` [m] over what is known of it when it is gripped [-].

    Seen is the middle, and so twice its error the top: a tall object's height is seen better than it is announced.
    Of one that is gripped across its shorter side, ``is_flat``, the fingers reach little more than the top, and each
    millimetre counts: of 36 trials with light ones 32 held with the error counted once, 18 with it counted twice.
    """
    return min(SIZE_ERROR, (1 if is_flat else 2) * SEEN_ERROR / height)


def _stretched(task: Task, rise: float) -> Task:
    """The task with the middle of the object higher by ``rise`` [m], and its heights in proportion."""
    target, half = task.target, object_height(task) / 2
    share, profile = 1 + rise / half, target.profile
    if profile is not None:
        profile = replace(profile, height=share * profile.height, center_height=share * profile.center_height)
    length = target.length * (share if abs(float(target.axis[2])) > 0.5 else 1.0)
    position = target.position + np.array([0.0, 0.0, rise])
    return replace(task, target=replace(target, position=position, length=length, profile=profile))


def tip_height(task: Task) -> float:
    """Height of the trunk's end during the grip [m].

    The least height at which the straight fingers clear the ground, the trunk's end clears the object, the open fingers
    find room round it, and the object's middle is at least REACH below the end.

    Raises:
        ModelError: where the trunk has no gripper, or the fingers open too little for the object.
    """
    taller, task = _find_taller(task), as_gripped(task)
    gripper, target, width = gripper_of(task), task.target, passed_width(task)
    if width <= gripper.grasp_width:
        height, gap = object_height(task), CLEARANCE * gripper.finger_length
        low = max((1 + GROUND_GAP) * gripper.finger_length, taller * height + gap)
        reach = WIDE_REACH if is_wide(task) and target.kind == "box" else REACH
        low = max(low, height / 2 + reach * gripper.finger_length)
        for above in np.linspace(low, low + gripper.finger_length, _N_HEIGHT):
            if is_wide_cylinder(task) and above > height / 2 + ROUND_REACH * gripper.finger_length:
                raise ModelError(f"too wide to lie between the fingers: they do not reach round {1e3 * width:.0f} mm")
            if _opening_tension(task, float(above), taller) is not None:
                return ground_height(task) + float(above)
    raise ModelError(
        f"the fingers do not open round {1e3 * width:.0f} mm; "
        f"allowed: up to {1e3 * gripper.grasp_width:.0f} mm, and low objects"
    )


def opening(task: Task) -> float:
    """Gripper command that opens the fingers round the object, -1 to 0 [-]; raises as `tip_height`."""
    gripper, above, taller = gripper_of(task), tip_height(task) - ground_height(task), _find_taller(task)
    tension = _opening_tension(as_gripped(task), above, taller)
    return -(gripper.tension_max if tension is None else tension) / gripper.tension_max


def side_share(n_finger: int) -> float:
    """Distance of the least normal finger's tip from the middle of a lying object, over that from the trunk's axis [-].

    Finger 1 is normal to the object's axis, the others at multiples of 2 pi / n; the trunk's axis is shifted to where
    the tips on both sides have the same distance from the object's middle plane.
    """
    across = np.cos(2 * math.pi * np.arange(n_finger) / n_finger)
    return float((across[across > 0].min() - across[across < 0].max()) / 2)


def side_shift(task: Task) -> float:
    """Distance by which the trunk's axis is moved off a wide object's middle, away from the finger normal to it [m]."""
    gripper = gripper_of(task)
    if not is_wide(task):
        return 0.0
    across = np.cos(2 * math.pi * np.arange(gripper.n_finger) / gripper.n_finger)
    off = float(across[across > 0].min() + across[across < 0].max()) / 2
    skin = float(gripper.phalanx_width[-1]) / 2
    return off * (upper_width(task) / 2 + skin) / side_share(gripper.n_finger)


def _find_taller(task: Task) -> float:
    """Largest height of the object when it is gripped, over what is known of it [-]."""
    return 1 + height_margin(object_height(task), is_slab(task))


def _opening_tension(task: Task, above: float, taller: float) -> float | None:
    """Tension that opens the fingers round the object, the trunk's end ``above`` what it rests on [m].

    The object may be ``taller`` than it is known by this factor.
    """
    gripper, target, height = gripper_of(task), task.target, object_height(task)
    larger = 1 + SIZE_ERROR
    radius, room = larger * _reach_out(target), ROOM * gripper.finger_length
    top = above - taller * height
    share = side_share(gripper.n_finger) if is_wide(task) else 1.0

    def section(depth: np.ndarray, skin: np.ndarray) -> np.ndarray:
        """Half the largest width of a profile between ``skin`` above and below a depth, 0 over its top [m]."""
        height, widths = find_widths(target)
        lowest, middle, highest = ((above - depth + step * skin) / taller for step in (-1.0, 0.0, 1.0))
        most = np.max([np.interp(z, height, widths) for z in (lowest, middle, highest)], axis=0)
        return np.where(lowest < height[-1], larger * most / 2, 0.0)

    def outline(depth: np.ndarray, skin: np.ndarray) -> np.ndarray:
        if upper_width(task) != target.width:
            half = section(depth, skin)
            return np.where(half > 0, (half + room + skin) / share, 0.0)
        if target.kind == "sphere" or is_wide_cylinder(task):
            return np.sqrt(np.maximum((radius + room + skin) ** 2 - (depth - top - radius) ** 2, 0.0)) / share
        below = np.clip((depth + skin - top) / (taller * height), 0.0, 1.0)
        part = below if target.kind == "cone" else below > 0
        return np.where(below > 0, (part * radius + room + skin) / share, 0.0)

    return opening_tension(gripper, outline)


def _reach_out(target: Target) -> float:
    """Largest horizontal distance of a standing object's outline from its middle, else across its axis [m].

    A camera does not measure the yaw of a standing box: its corners may be where the fingers are.
    """
    has_any_yaw = target.kind == "box" and abs(float(target.axis[2])) > 0.5
    return target.width / 2 * (math.sqrt(2.0) if has_any_yaw else 1.0)


def closing(task: Task) -> float:
    """Gripper command that holds the object by friction, and no harder than that takes, 0 to 1 [-].

    A finger that presses with N on a side that narrows upwards by an angle a lifts by N (mu cos a - sin a), with mu the
    announced friction over SAFETY. Where that is nothing, it presses as hard as it can. On a wide object that lies, the
    finger normal to its axis opposes all others: they press together as it does alone, which counts as two.
    """
    task = as_gripped(task)
    gripper, target = gripper_of(task), task.target
    slope = cone_slope(target)
    lifting = target.friction / SAFETY * math.cos(slope) - math.sin(slope)
    most = gripper.tension_max / closing_tension(gripper, gripper.mount_radius, 1.0)  # Of a straight finger's tip.
    weight = target.mass * GRAVITY
    pressing = 2 if is_wide(task) else gripper.n_finger
    needed = min(most, weight / (pressing * lifting)) if lifting > 0 else most
    return closing_tension(gripper, upper_width(task) / 2, max(needed, PRESS_LEAST * most)) / gripper.tension_max


def gripping_base(task: Task, place: np.ndarray) -> np.ndarray:
    """Position of the base, the trunk hanging below it, that grips an object at ``place``, shapes (3,) [m]."""
    return np.array([place[0], place[1], tip_height(task) + task.design.length])


def set_aside(task: Task, rotation: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Displacement of the base from the object's centre, shape (3,) [m].

    Of a wide object that lies it leads away from the finger normal to its axis, of one with a handle to its body.
    ``rotation`` is the orientation of the base, shape (3, 3) [-], and ``axis`` the object's axis, shape (3,) [-].
    """
    if task.target.handle is not None:
        return task.target.handle.body_offset
    task = as_gripped(task)
    if not is_wide(task):
        return np.zeros(3)
    angle = 2 * math.pi * np.arange(gripper_of(task).n_finger) / gripper_of(task).n_finger
    fingers = np.cos(angle)[:, None] * rotation[:, 1] + np.sin(angle)[:, None] * rotation[:, 2]
    across = np.array([-axis[1], axis[0], 0.0]) / math.hypot(axis[0], axis[1])
    share = fingers @ across
    return -side_shift(task) * math.copysign(1.0, share[np.abs(share).argmax()]) * across


def turned_across(start: np.ndarray, axis: np.ndarray, task: Task) -> np.ndarray:
    """Orientation of the base that sets one finger against the others across a horizontal axis, shape (3, 3) [-].

    The direction of one finger is normal to the axis; of the 2 n equivalent orientations the nearest to ``start`` is
    taken. With an upright axis the handle comes between two fingers, or without one the orientation stays as it is.
    """
    n_finger, handle = gripper_of(task).n_finger, task.target.handle
    finger = math.atan2(start[1, 1], start[0, 1])
    if math.hypot(axis[0], axis[1]) < 0.5:
        if handle is None:
            return start
        between, apart = (
            math.atan2(handle.direction[1], handle.direction[0]) + math.pi / n_finger,
            2 * math.pi / n_finger,
        )
        turn = (between - finger + apart / 2) % apart - apart / 2
        return np.asarray(Rotation.from_rotvec([0.0, 0.0, turn]).as_matrix() @ start)
    across = math.atan2(axis[1], axis[0]) + math.pi / 2
    step = math.pi / n_finger if n_finger % 2 else math.pi / math.lcm(n_finger, 2)
    turn = (across - finger + step / 2) % step - step / 2
    return np.asarray(Rotation.from_rotvec([0.0, 0.0, turn]).as_matrix() @ start)
