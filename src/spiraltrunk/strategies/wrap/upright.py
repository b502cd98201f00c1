"""Turning a held object upright: the head turns about the object by the lean that the camera sees."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from spiraltrunk.control.messages import CameraObservation, Observation
from spiraltrunk.strategies.moves import Move, MoveSequence, command_at, edit_moves
from spiraltrunk.strategies.wrap.standing_plan import SINK, clear_height

ABOVE = 0.03
"""Height above the ground to which the object is brought down before it is lowered slowly [m] (ours)."""
BOWS = np.radians(np.arange(1.0, 13.0))
"""Angles, the least that suffices first, by which the head bows where a held object would not come down to the ground
[rad] (ours): it then leans as much, and rights itself as the trunk opens."""


def carry_upright(sequence: MoveSequence, observation: Observation, ground_gap: float) -> MoveSequence:
    """The sequence with the object upright in the remaining moves of the transport; unchanged without a camera.

    The housing keeps half of ``ground_gap`` [m] from the ground.
    """
    camera = observation.camera
    if camera is None:
        return sequence
    rotation, to_base = _turn_upright(sequence, observation, camera, ground_gap)
    aside = camera.position + to_base - sequence.move.position

    def carry(move: Move) -> Move:
        is_carried = move.phase == "transport"
        return replace(move, position=move.position + aside, rotation=rotation) if is_carried else move

    return edit_moves(sequence, sequence.index + 1, carry)


def set_down_upright(sequence: MoveSequence, observation: Observation, ground_gap: float) -> MoveSequence:
    """The sequence with the object set down upright over its place, and released there; unchanged without a camera.

    The housing keeps half of ``ground_gap`` [m] from the ground.
    """
    camera = observation.camera
    if camera is None:
        return sequence
    rotation, to_base = _turn_upright(sequence, observation, camera, ground_gap)
    rotation, to_base = _bow(observation, rotation, to_base, ground_gap)
    place = observation.task.goal.place
    low = place - np.array([0.0, 0.0, SINK]) + to_base
    above = low + np.array([0.0, 0.0, SINK + ABOVE])
    planned = next(move.position for move in sequence.moves if move.action == "lower")
    aside = np.array([*(low - planned)[:2], 0.0])

    def set_down(move: Move) -> Move:
        if move.phase != "release":
            return move
        position = {"bring": above, "lower": low}.get(move.action, move.position + aside)
        if move.action in ("uncurl", "open"):
            position = np.array([*position[:2], low[2]])
        is_held = move.action in ("bring", "lower", "uncurl", "open")
        return replace(move, position=position, rotation=rotation if is_held else move.rotation)

    return edit_moves(sequence, 0, set_down)


def _bow(
    observation: Observation, rotation: np.ndarray, to_base: np.ndarray, ground_gap: float
) -> tuple[np.ndarray, np.ndarray]:
    """Orientation of the base, and the way to it from the object's centre, as of `_turn_upright`, the head bowed.

    It bows by the least of `BOWS` at which housing and wrist clear the ground while the object stands on it; by the
    largest where none suffices, and not where it need not bow.
    """
    task, ahead = observation.task, rotation[:, 0]
    axis = np.cross(ahead, [0.0, 0.0, -1.0])
    axis /= max(float(np.linalg.norm(axis)), 1e-9)
    for angle in (0.0, *BOWS):
        matrix = Rotation.from_rotvec(angle * axis).as_matrix()
        bowed, way = matrix @ rotation, matrix @ to_base
        if task.target.length / 2 + float(way[2]) >= clear_height(task.design, bowed, ground_gap / 2):
            break
    return bowed, way


def _turn_upright(
    sequence: MoveSequence, observation: Observation, camera: CameraObservation, ground_gap: float
) -> tuple[np.ndarray, np.ndarray]:
    """Orientation of the base at which the object stands, shape (3, 3) [-], and the way from its centre to the base
    [m].

    The turn ends early where housing or wrist would meet the ground.
    """
    task, T_world_base = observation.task, command_at(sequence, observation.time).T_world_base
    across = np.cross(camera.axis * math.copysign(1.0, camera.axis[2]), np.array([0.0, 0.0, 1.0]))
    sine = float(np.linalg.norm(across))
    turn = across / max(sine, 1e-9) * math.asin(min(1.0, sine))
    height, gap = task.target.length / 2 - SINK, ground_gap / 2
    for part in np.linspace(1.0, 0.0, 11):
        matrix = Rotation.from_rotvec(part * turn).as_matrix()
        rotation, to_base = matrix @ T_world_base[:3, :3], matrix @ (T_world_base[:3, 3] - camera.position)
        if height + float(to_base[2]) >= clear_height(task.design, rotation, gap):
            break
    return rotation, to_base
