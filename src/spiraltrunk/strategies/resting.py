"""Rest after the release, until the camera sees that the object stands still."""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.control.messages import CameraObservation, Observation
from spiraltrunk.strategies.moves import MoveSequence, insert_next
from spiraltrunk.strategies.object_measures import TOPPLED

STILL = 0.002
"""Way of the released object's top from one look of the camera to the next from which it still moves [m]: a camera's
errors vary by less. A tall box that is let go rocks on its edges."""
SEEN_STILL, MOST_RESTS = 2, 10
"""Times that such an object must be seen still before the end, and largest number of rests until then [-]."""


def has_toppled(observation: Observation) -> bool:
    """Whether the camera sees that the object, which stood, has toppled; false without one."""
    return observation.camera is not None and abs(float(observation.camera.axis[2])) < math.cos(TOPPLED)


def rest_until_still(
    sequence: MoveSequence, observation: Observation, before: CameraObservation | None
) -> MoveSequence:
    """The sequence with further rests after the present one, where the released object is not seen still.

    It is still where a later look than ``before`` shows its top in the same place. Then no rest is added, nor for what
    has toppled, nor without a camera; else as many as SEEN_STILL, and no more than MOST_RESTS in all.
    """
    camera, half = observation.camera, observation.task.target.length / 2
    if camera is None or before is None or has_toppled(observation):
        return sequence
    moved = camera.position + half * camera.axis - (before.position + half * before.axis)
    if camera.time > before.time and float(np.linalg.norm(moved)) <= STILL:
        return sequence
    count = [move.action for move in sequence.moves].count("rest")
    left = len(sequence.moves) - 1 - sequence.index
    return insert_next(sequence, (sequence.move,) * min(SEEN_STILL - left, MOST_RESTS - count))
