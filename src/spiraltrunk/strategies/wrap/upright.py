"""Turning what a trunk holds upright: the head turns about the object by as much as a camera sees it lean."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from spiraltrunk.control.messages import Observation
from spiraltrunk.strategies.moves import Progress, command_at
from spiraltrunk.strategies.wrap.standing_plan import StandingOptions, housing_sink


def carried_upright(progress: Progress, observation: Observation, options: StandingOptions) -> Progress:
    """The same sequence, the object carried upright, as the camera sees it lean, from where it is."""
    if observation.look is None:
        return progress
    rotation, to_base = _uprighted(observation, options, command_at(progress, observation.time).T_world_base)
    aside = observation.look.position + to_base - progress.move.position
    moves = tuple(
        replace(move, position=move.position + aside, rotation=rotation)
        if i > progress.index and move.phase == "transport" else move
        for i, move in enumerate(progress.moves)
    )  # fmt: skip
    return replace(progress, moves=moves)


def set_down_upright(progress: Progress, observation: Observation, options: StandingOptions) -> Progress:
    """The same sequence, the object set down upright over its place, as the camera sees it tilt, and let go there."""
    if observation.look is None:
        return progress
    rotation, to_base = _uprighted(observation, options, command_at(progress, observation.time).T_world_base)
    place, height = observation.task.goal.place, float(observation.look.position[2])
    above = np.array([*place[:2], height]) + to_base
    low = place - np.array([0.0, 0.0, options.sink]) + to_base
    planned = next(move.position for move in progress.moves if move.action == "lower")
    aside = np.array([*(low - planned)[:2], 0.0])
    where = {"bring": above, "lower": low}
    moves = list(progress.moves)
    for i, move in enumerate(moves):
        if move.phase != "release":
            continue
        position = where.get(move.action, move.position + aside)
        if move.action in ("uncurl", "open"):
            position = np.array([*position[:2], low[2]])
        is_held = move.action in (*where, "uncurl", "open")
        moves[i] = replace(move, position=position, rotation=rotation if is_held else move.rotation)
    return replace(progress, moves=tuple(moves))


def _uprighted(
    observation: Observation, options: StandingOptions, T_world_base: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Orientation of the base that makes the object stand up, and the way from its centre to the base.

    Or as near to that as leaves the housing above the ground.
    """
    look, task = observation.look, observation.task
    if look is None:
        return T_world_base[:3, :3], np.zeros(3)
    across = np.cross(look.axis * math.copysign(1.0, look.axis[2]), np.array([0.0, 0.0, 1.0]))
    sine = float(np.linalg.norm(across))
    turn = across / max(sine, 1e-9) * math.asin(min(1.0, sine))
    stand, gap = task.target.length / 2 - options.sink, options.ground_gap / 2
    for part in np.linspace(1.0, 0.0, 11):
        matrix = Rotation.from_rotvec(part * turn).as_matrix()
        rotation, to_base = matrix @ T_world_base[:3, :3], matrix @ (T_world_base[:3, 3] - look.position)
        sink = housing_sink(task.design, math.acos(max(-1.0, min(1.0, -float(rotation[2, 0])))))
        if stand + float(to_base[2]) >= sink + gap:
            break
    return rotation, to_base
