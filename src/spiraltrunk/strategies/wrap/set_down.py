"""Setting a wrapped object down: over its place, on its low edge where it leans.

The base of a low wrap has no room to turn away the whole lean, as its housing would meet the ground.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from spiraltrunk.control.messages import CameraObservation, Observation
from spiraltrunk.strategies.moves import Move, MoveSequence, base_position, edit_moves, insert_next, shift_later
from spiraltrunk.strategies.wrap.arm_lag import LAG
from spiraltrunk.strategies.wrap.standing_plan import clear_height
from spiraltrunk.strategies.wrap.upright import set_down_upright

DRAG, DISTAL_DRAG = (-0.020, 0.005), (-0.010, -0.025)
"""Displacements aside and ahead by which the opening trunk drags an object on average, of a full and of a distal wrap,
over the trunk's length [-] (ours, tuned in simulated trials): it is set down as far on the other side."""
UNKNOWN = 0.1
"""Error of the object's announced size, over the size [-] (ours)."""
LOOK_ERROR = 0.005
"""Error of the camera [m] (ours)."""
OFF, CENTRING_TIME = 0.008, 0.4
"""Distance from where an object is to be over its place from which it is first moved there [m], and the least time for
it [s] (ours): the lowering ends where the ground is met, before the whole of its way aside."""


def set_down_clear(sequence: MoveSequence, observation: Observation, ground_gap: float) -> MoveSequence:
    """The sequence with the object set down over its place, as upright as the housing and the arm's wrist allow.

    The housing keeps half of ``ground_gap`` [m] from the ground, and the wrist clears it, even where the object then
    does not reach it and is released a few millimetres above. Unchanged without a camera.
    """
    if observation.camera is None:
        return sequence
    design, ground = observation.task.design, find_ground(observation)

    def lift_housing(move: Move) -> Move:
        if move.phase != "release" or move.rotation is None:
            return move
        least = ground + clear_height(design, move.rotation, ground_gap / 2)
        return replace(move, position=np.array([*move.position[:2], max(least, float(move.position[2]))]))

    return edit_moves(set_down_upright(sequence, observation, ground_gap), 0, lift_housing)


def center_place(
    sequence: MoveSequence, observation: Observation, side: np.ndarray, drag: tuple[float, float]
) -> MoveSequence:
    """The sequence with the object, seen above its place, set down where its righting and its drag end at the place.

    An object that is farther than OFF from there is moved there first, and then lowered straight down.

    Args:
        sequence: moves, the present one at its end.
        observation: what is seen; without a camera the sequence is unchanged.
        side: horizontal direction in which the trunk curls, shape (3,) [-].
        drag: `DRAG` or `DISTAL_DRAG`.
    """
    camera, now = observation.camera, sequence.move
    if camera is None:
        return sequence
    aside, ahead = drag
    dragged = observation.task.design.length * (aside * side + ahead * np.cross([0.0, 0.0, 1.0], side))
    place = observation.task.goal.place - dragged
    # The camera looks twice a second. The base turns so little in that time that only its way counts.
    since_look = now.position - base_position(sequence, camera.time - LAG)
    way = (place - righting(observation, camera) - camera.position - since_look) * [1.0, 1.0, 0.0]
    sequence = shift_later(sequence, way)
    if float(np.linalg.norm(way)) <= OFF:
        return sequence
    return insert_next(sequence, (replace(now, action="center", duration=CENTRING_TIME, position=now.position + way),))


def is_on_ground(observation: Observation) -> bool:
    """Whether the object is as low as it stands, or stands on its low edge, by the camera; true without one.

    The trunk may touch the ground before the object does.
    """
    camera, target = observation.camera, observation.task.target
    if camera is None:
        return True
    sine, half = _sine_of_lean(camera), target.length / 2
    low = half * math.sqrt(1 - sine**2) + target.width / 2 * sine
    return float(camera.position[2] - observation.task.goal.place[2]) + half <= low + UNKNOWN * half + LOOK_ERROR


def righting(observation: Observation, camera: CameraObservation) -> np.ndarray:
    """Horizontal displacement of the centre of an object that is righted about its low edge, shape (3,) [m].

    A cylinder of half length l and radius r that leans by t stands on its low edge, its centre l sin t - r cos t
    beyond it in the direction of the lean. Upright, its centre is r short of it: it goes back by the difference,
    l sin t + r (1 - cos t).
    """
    target = observation.task.target
    lean, sine = (camera.axis * math.copysign(1.0, camera.axis[2]))[:2], _sine_of_lean(camera)
    way = target.length / 2 * sine + target.width / 2 * (1 - math.sqrt(max(0.0, 1 - sine**2)))
    return np.array([*(-way * lean / max(sine, 1e-9)), 0.0])


def find_ground(observation: Observation) -> float:
    """Height of the ground on which the object is set down [m]."""
    goal = observation.task.goal
    return float(goal.place[2] - observation.task.target.length / 2) if goal.ground is None else goal.ground


def _sine_of_lean(camera: CameraObservation) -> float:
    return min(1.0, float(np.linalg.norm(camera.axis[:2])))
