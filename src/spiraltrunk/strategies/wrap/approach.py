"""Direction from which a trunk comes to an object that stands, as suits how a wide object with corners is turned.

A corner that faces the housing meets it as the loop tightens, and an oblong thing is tipped where its longer side lies
in the way in which the trunk curls. In 48 simulated trials of the wraps with boxes of 80 mm, 23 of 24 succeeded with a
side 10 to 50 deg from that way, and 10 of 24 at other angles; turned by 30 deg, 10 of 11 that had failed succeeded.
Of oblong things `benchmarks/turned_objects.py` tells the same. Where the announced yaw is another one, the whole plan
is turned about the object, as far as arm and ground leave room. Narrow objects and round ones are taken from ahead.
"""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.control.messages import Observation, Task
from spiraltrunk.design.rules import graspable_range
from spiraltrunk.strategies.object_measures import widths_between
from spiraltrunk.strategies.wrap.standing_model import loop_band

OBLONG = 1.2
"""Least ratio of the sides of an oblong object [-] (ours)."""
CORNERED = 1.2
"""Least ratio of the widths of an object with corners that matter [-] (ours): 1 of a round one, 1.41 of a square."""
ACROSS = math.radians(60.0), math.radians(120.0)
"""Good angles of the longer side of an oblong object from the way in which the trunk curls [rad] (ours)."""
DIAGONAL = math.radians(20.0), math.radians(40.0)
"""Good angles of the sides of another object with corners from that way [rad] (ours)."""
WIDE = 0.35
"""Least width of an object whose corners come near the housing, over the largest that the trunk encloses [-] (ours):
boxes of 60 mm were wrapped at any yaw."""
RIGHT, DISTAL_RIGHT, LEFT = math.radians(-40.0), math.radians(-25.0), math.radians(12.0)
"""Largest turns of the approach to the right, of a full and of a distal wrap, and to the left [rad] (ours): to the
right the arm has room for the base if the object stands further away; to the left, the tail would hang beside the near
edge of the ground."""


def approach_direction(observation: Observation, is_distal: bool = False) -> np.ndarray:
    """Horizontal unit vector in which the trunk curls, shape (3,) [-].

    That of the lateral curl of the hanging trunk, to the right of ventral, turned by `find_turn`.
    """
    left = np.array([*observation.T_world_base[:2, 2], 0.0])
    x, y, _ = (-left / np.linalg.norm(left)).tolist()
    turn = find_turn(observation.task, math.atan2(y, x), is_distal)
    c, s = math.cos(turn), math.sin(turn)
    return np.array([c * x - s * y, s * x + c * y, 0.0])


def find_turn(task: Task, way: float, is_distal: bool = False) -> float:
    """Turn of the approach for an object that stands [rad].

    Args:
        task: trunk and object as announced.
        way: angle of the way in which the trunk curls, not turned, from the world's x [rad].
        is_distal: whether the wrap is a distal one.
    """
    target = task.target
    if target.side_yaw is None:
        return 0.0
    least, most = widths_between(target, *loop_band(target))
    if most < WIDE * graspable_range(task.design)[1]:
        return 0.0
    if target.longer_side >= OBLONG * least:
        (low, high), period = ACROSS, math.pi
    elif most >= CORNERED * least:
        (low, high), period = DIAGONAL, math.pi / 2
    else:
        return 0.0
    angle = target.side_yaw - way
    turns = [_turn_into(angle + count * period, low, high) for count in range(-4, 5)]  # It is up to 2 pi.
    least_turn, most_turn = DISTAL_RIGHT if is_distal else RIGHT, LEFT
    reached = [turn for turn in turns if least_turn <= turn <= most_turn]
    if reached:
        return min(reached, key=abs)
    nearest = min(turns, key=lambda turn: max(least_turn - turn, turn - most_turn))
    return min(max(nearest, least_turn), most_turn)


def _turn_into(angle: float, low: float, high: float) -> float:
    """Least turn after which an angle, less the turn, is between two others [rad]."""
    return angle - min(max(angle, low), high)


def is_turned(task: Task) -> bool:
    """Whether the approach to an object is turned where the trunk curls along the world's x."""
    return find_turn(task, 0.0) != 0.0
