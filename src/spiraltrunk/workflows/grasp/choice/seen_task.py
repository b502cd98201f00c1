"""Task for a further try: the object as the camera sees it, its place moved against the error of the try before."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from spiraltrunk.control.messages import Observation, Target, Task
from spiraltrunk.strategies.object_measures import UPRIGHT, is_upright


def task_as_seen(observation: Observation) -> Task:
    """The task with the object at the position and with the axis that the camera sees; its place is kept.

    The axis has no sign. An object that no longer stands or lies as announced has length and width, but no profile: the
    profile is that of the announced pose. Where the object has moved along the carry already, the carry goes the other
    way, so that it stays within the arm's reach.
    """
    task, camera = observation.task, observation.camera
    if camera is None:
        return task
    target, goal = _target_as_seen(task, camera.axis, camera.position), task.goal
    rise = float(target.position[2] - task.target.position[2]) if goal.ground is not None else 0.0
    place = goal.place + np.array([0.0, 0.0, rise])
    off = (target.position - (goal.place - goal.aside / 2)) * [1.0, 1.0, 0.0]
    aside = min(goal.aside, -goal.aside, key=lambda way: float(np.linalg.norm(off + way)))
    return replace(task, target=target, goal=replace(goal, aside=aside, place=place))


def correct_place(seen: Observation, told: Task) -> Task | None:
    """The task with its place moved against the error with which a try set the object down; None where it has toppled.

    The opening trunk drags an object, and the next one drags it as far again: it is set down as far on the other side.

    Args:
        seen: with the task of the next try.
        told: the task of the try, as its strategy was told it.
    """
    camera, goal = seen.camera, seen.task.goal
    if camera is None or abs(float(camera.axis @ told.target.axis)) < UPRIGHT:
        return None
    error = (camera.position - told.goal.place) * [1.0, 1.0, 0.0]
    return replace(seen.task, goal=replace(goal, place=goal.place - error))


def _target_as_seen(task: Task, axis: np.ndarray, position: np.ndarray) -> Target:
    target, ground = task.target, task.goal.ground
    along = float(np.dot(axis, target.axis))
    stood = is_upright(target)
    if ground is None or target.kind == "sphere":
        return replace(target, position=position)
    if stood and abs(along) > UPRIGHT:
        return replace(target, position=np.array([*position[:2], target.position[2]]))
    if stood:
        flat = axis * [1.0, 1.0, 0.0]
        axis, height = flat / np.linalg.norm(flat), target.width / 2
    else:
        is_up = abs(float(axis[2])) > UPRIGHT
        axis, height = (np.array([0.0, 0.0, 1.0]), target.length / 2) if is_up else (axis, target.width / 2)
    return replace(
        target,
        position=np.array([*position[:2], ground + height]),
        axis=axis,
        profile=None,
        longer_side=0.0,
        side_yaw=None,
        handle=None,
    )
