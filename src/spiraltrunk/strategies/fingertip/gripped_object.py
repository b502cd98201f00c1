"""The object as the fingers meet it: without its handle, or across its shorter side; and its widths there."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from spiraltrunk.control.messages import Target, Task
from spiraltrunk.design.gripper import GripperDesign
from spiraltrunk.errors import ModelError

WIDE = 0.5
"""Width over the largest that the fingers enclose from which a lying object is pinched as a wide one [-]: beside it,
fingers that are not normal to its axis must open further than a body of revolution needs."""
SOLIDS = ("sphere", "cylinder", "cone", "ring")
"""Kinds of object whose widths follow from their measures, whatever their profile."""


def gripper_of(task: Task) -> GripperDesign:
    """The trunk's gripper.

    Raises:
        ModelError: where it has none.
    """
    gripper = task.design.gripper
    if gripper is None:
        raise ModelError("this trunk has no gripper; allowed: a design with a gripper")
    return gripper


def ground_height(task: Task) -> float:
    """Height of what the object rests on [m]; half its width below it where the task has no ground."""
    target, goal = task.target, task.goal
    return float(target.position[2]) - target.width / 2 if goal.ground is None else goal.ground


def object_height(task: Task) -> float:
    """Height of the object's top above what it rests on [m]."""
    return 2 * (float(task.target.position[2]) - ground_height(task))


def as_gripped(task: Task) -> Task:
    """The task with the object as the fingers meet it; the same where that is already so.

    One with a handle is the upright cylinder round its body: fingers pass on both sides. One that stands, and is too
    wide for fingers in any direction but across its shorter side, is a bar that lies along its longer side. The object
    keeps its centre and its height; `set_aside` tells where the body is.
    """
    target = task.target
    if target.handle is not None:
        return replace(task, target=replace(target, kind="cylinder", width=target.handle.body_width, profile=None))
    return replace(task, target=_as_bar(target)) if is_slab(task) else task


def opposed_axis(task: Task, seen: np.ndarray) -> np.ndarray:
    """Axis across which the fingers oppose each other, shape (3,) [-].

    Args:
        task: the task as announced.
        seen: axis of the object as the camera sees it, shape (3,) [-]; the answer for all but `is_slab`.
    """
    return as_gripped(task).target.axis if is_slab(task) else seen


def is_slab(task: Task) -> bool:
    """Whether the fingers pass an object that stands only across its shorter side, whose direction is announced."""
    target, gripper = task.target, task.design.gripper
    if gripper is None or target.side_yaw is None or target.profile is None or abs(float(target.axis[2])) < 0.5:
        return False
    return passed_width(task) > gripper.grasp_width >= passed_width(replace(task, target=_as_bar(target)))


def _as_bar(target: Target) -> Target:
    """The object as one that lies along its longer side, and is as high as it stands."""
    assert target.side_yaw is not None
    assert target.profile is not None
    along = np.array([math.cos(target.side_yaw), math.sin(target.side_yaw), 0.0])
    least = float(target.profile.width_least.max())
    return replace(target, kind="box", axis=along, width=least, length=target.longer_side, side_yaw=None)


def is_wide(task: Task) -> bool:
    """Whether the object lies and is so wide that the fingers' directions count."""
    target = task.target
    is_lying = math.hypot(target.axis[0], target.axis[1]) >= 0.5
    is_prism = target.kind != "sphere"
    return is_lying and is_prism and upper_width(task) > WIDE * gripper_of(task).grasp_width


def is_wide_cylinder(task: Task) -> bool:
    """Whether the object is a wide cylinder that lies: fingers pass its round top nearer than that of a box."""
    return task.target.kind == "cylinder" and is_wide(task)


def upper_width(task: Task) -> float:
    """Width of the object where the fingers pass it [m]: of what has a profile of its own, that of its upper part."""
    target, gripper = task.target, gripper_of(task)
    stands = target.kind == "box" and abs(float(target.axis[2])) > 0.5
    is_known = stands or target.kind in SOLIDS or target.width <= WIDE * gripper.grasp_width
    if target.profile is None or is_known:
        return target.width
    height, widths = find_widths(target)
    return float(widths[height >= height[-1] - gripper.finger_length].max())


def passed_width(task: Task) -> float:
    """Largest width that the fingers pass on their way down [m]: a standing cone's foot may lie below their ends."""
    target, width = task.target, upper_width(task)
    if target.kind != "cone" or abs(float(target.axis[2])) < 0.5:
        return width
    return width * min(1.0, gripper_of(task).finger_length / object_height(task))


def find_widths(target: Target) -> tuple[np.ndarray, np.ndarray]:
    """Heights of a profile and the widths that fingers pass: the least ones across an axis that is seen, else the most.

    A camera does not measure the yaw of what stands.
    """
    assert target.profile is not None
    is_lying = math.hypot(target.axis[0], target.axis[1]) >= 0.5
    return target.profile.height, target.profile.width_least if is_lying else target.profile.width_most
