"""Position, orientation and commands of the tip gripper: geometry of the strategies that grip with the fingers.

The trunk hangs straight, so that its end is where the arm puts it, to a fraction of a millimetre.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial.transform import Rotation

from spiraltrunk.control.messages import Target, Task
from spiraltrunk.design.gripper import GripperDesign
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.errors import ModelError
from spiraltrunk.strategies.fingertip.finger_model import closing_tension, opening_tension

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
SAFETY = 3.0
"""Announced friction over the friction that the grip counts on [-]."""
PRESS_LEAST = 0.5
"""Least force of a fingertip over its largest [-]."""

_N_HEIGHT = 39
"""Heights tried: a millimetre apart for the paper's fingers."""


def gripper_of(task: Task) -> GripperDesign:
    """The trunk's gripper.

    Raises:
        ModelError: where it has none.
    """
    gripper = task.design.gripper
    if gripper is None:
        raise ModelError("this trunk has no gripper; allowed: a design with [gripper]")
    return gripper


def ground_height(task: Task) -> float:
    """Height of what the object rests on [m]; half its width below it where the task has no ground."""
    target, goal = task.target, task.goal
    return float(target.position[2]) - target.width / 2 if goal.ground is None else goal.ground


def object_height(task: Task) -> float:
    """Height of the object's top above what it rests on [m]."""
    return 2 * (float(task.target.position[2]) - ground_height(task))


def tip_height(task: Task) -> float:
    """Height of the trunk's end during the grip [m].

    The least height at which the straight fingers clear the ground, the trunk's end clears the object, the open fingers
    find room round it, and the object's middle is at least REACH below the end.

    Raises:
        ModelError: where the trunk has no gripper, or the fingers open too little for the object.
    """
    gripper, target = gripper_of(task), task.target
    if target.width <= gripper.grasp_width:
        height, gap = object_height(task), CLEARANCE * gripper.finger_length
        low = max((1 + GROUND_GAP) * gripper.finger_length, (1 + SIZE_ERROR) * height + gap)
        low = max(low, height / 2 + REACH * gripper.finger_length)
        for above in np.linspace(low, low + gripper.finger_length, _N_HEIGHT):
            if _opening_tension(gripper, target, height, float(above)) is not None:
                return ground_height(task) + float(above)
    raise ModelError(
        f"the fingers do not open round {1e3 * target.width:.0f} mm; "
        f"allowed: up to {1e3 * gripper.grasp_width:.0f} mm, and low objects"
    )


def opening(task: Task) -> float:
    """Gripper command that opens the fingers round the object, -1 to 0 [-]; raises as `tip_height`."""
    gripper, above = gripper_of(task), tip_height(task) - ground_height(task)
    tension = _opening_tension(gripper, task.target, object_height(task), above)
    return -(gripper.tension_max if tension is None else tension) / gripper.tension_max


def _opening_tension(gripper: GripperDesign, target: Target, height: float, above: float) -> float | None:
    """Tension that opens the fingers round the object, the trunk's end ``above`` what it rests on [m]."""
    larger = 1 + SIZE_ERROR
    radius, room = larger * _reach_out(target), ROOM * gripper.finger_length
    top = above - larger * height

    def outline(depth: np.ndarray, skin: np.ndarray) -> np.ndarray:
        if target.kind == "sphere":
            return np.sqrt(np.maximum((radius + room + skin) ** 2 - (depth - top - radius) ** 2, 0.0))
        below = np.clip((depth + skin - top) / (larger * height), 0.0, 1.0)
        share = below if target.kind == "cone" else below > 0
        return np.where(below > 0, share * radius + room + skin, 0.0)

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
    announced friction over SAFETY. Where that is nothing, it presses as hard as it can.
    """
    gripper, target = gripper_of(task), task.target
    slope = math.atan2(target.width / 2, target.length) if target.kind == "cone" else 0.0
    lifting = target.friction / SAFETY * math.cos(slope) - math.sin(slope)
    most = gripper.tension_max / closing_tension(gripper, gripper.mount_radius, 1.0)  # Of a straight finger's tip.
    weight = target.mass * GRAVITY
    needed = min(most, weight / (gripper.n_finger * lifting)) if lifting > 0 else most
    return closing_tension(gripper, target.width / 2, max(needed, PRESS_LEAST * most)) / gripper.tension_max


def gripping_base(task: Task, place: np.ndarray) -> np.ndarray:
    """Position of the base, the trunk hanging below it, that grips an object at ``place``, shapes (3,) [m]."""
    return np.array([place[0], place[1], tip_height(task) + task.design.length])


def turned_across(start: np.ndarray, axis: np.ndarray, n_finger: int) -> np.ndarray:
    """Orientation of the base that sets one finger against the others across a horizontal axis, shape (3, 3) [-].

    The direction of one finger is normal to the axis; of the 2 n equivalent orientations the nearest to ``start`` is
    taken. An upright axis leaves the orientation as it is.
    """
    if math.hypot(axis[0], axis[1]) < 0.5:
        return start
    finger = math.atan2(start[1, 1], start[0, 1])
    across = math.atan2(axis[1], axis[0]) + math.pi / 2
    step = math.pi / n_finger if n_finger % 2 else math.pi / math.lcm(n_finger, 2)
    turn = (across - finger + step / 2) % step - step / 2
    return np.asarray(Rotation.from_rotvec([0.0, 0.0, turn]).as_matrix() @ start)
