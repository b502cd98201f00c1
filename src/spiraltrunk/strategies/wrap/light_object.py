"""Whether the trunk bears an object that the arm may not feel: by the height at which a camera sees it."""

from __future__ import annotations

import math

from spiraltrunk.control.messages import Observation
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.strategies.move_strategy import BORNE

FELT = 0.25
"""Least change of the measured weight that tells a load [N] (ours). In simulated trials, with a noise of 0.02 N m of
each of the arm's torques, the smoothed weight of an empty trunk varies by 0.15 N between the moves of one reach."""
OFF_GROUND = 0.004
"""Rise from which an object is off the ground [m] (ours): twice the most by which two looks of a camera with an error
of 3 mm differ, where 0.3 of the error varies between looks; a fifth of the rise that tests the load."""

HIGH = 0.05
"""Seen rise from which an object counts as borne even if the arm feels no load [m] (ours): of the weight of 57
to 75 g it may measure less than half."""


def is_too_light(observation: Observation) -> bool:
    """Whether a camera looks, and the load by which an object counts as borne is less than `FELT`: below 51 g."""
    return observation.camera is not None and BORNE * observation.task.target.mass * GRAVITY < FELT


def is_off_ground(observation: Observation, stood: float, rise: float = OFF_GROUND) -> bool:
    """Whether the camera sees the object more than ``rise`` [m] above where it would touch the ground.

    A cylinder of half length l and radius r that leans by t on its low edge has its centre l cos t + r sin t above the
    ground; l where it stands.

    Args:
        observation: what is seen; without a camera, false.
        stood: height of the object's centre as the camera saw it stand [m].
        rise: least rise [m].
    """
    camera, target = observation.camera, observation.task.target
    if camera is None:
        return False
    half, cosine = target.length / 2, min(1.0, abs(float(camera.axis[2])))
    low = half * cosine + target.width / 2 * math.sqrt(1.0 - cosine**2)
    return float(camera.position[2]) - stood > low - half + rise


def describe_no_load(observation: Observation) -> str:
    """Why a grasp ended with nothing lifted."""
    sight = "the camera sees the object on the ground" if is_too_light(observation) else "the arm feels no load"
    return f"nothing was lifted: {sight}"
