"""Approach pose of the rolled trunk behind an object, and the moves that bring the trunk there.

The trunk is rolled up in the air, then tilted and lowered to just above the ground, so that it meets objects low: an
object pushed above about three times its half-width may topple, and a ball pushed above its middle jams between ground
and trunk where friction is high.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.control.messages import Observation, Target, Task
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.strategies.moves import Move, tilted_base
from spiraltrunk.strategies.object_measures import is_upright
from spiraltrunk.strategies.push.rolled_model import RolledTrunk, predict_rolled_trunk
from spiraltrunk.strategies.sensing import find_ventral
from spiraltrunk.strategies.timing import stretch, travel_time

TILT = math.radians(60.0)
"""Tilt of the base from hanging towards the push [rad] (ours): a low front, and the housing clears the ground."""

TENSION = 0.9
"""Tension of the ventral cables over the largest one [-] (ours): the more, the stiffer the rolled trunk."""

CLEARANCE = 0.005
"""Least gap between rolled trunk and ground [m] (ours)."""

SAG = 0.28
"""The same over the trunk's length times its weight over the cables' tension [-] (ours): a large rolled trunk sags, and
what drags on the ground is taken for a jammed object."""

ABOVE = 0.35
"""Height of the base while the trunk is tilted, over the trunk's length [-] (ours): the curl clears the ground."""

_DOWN_FROM = 0.10
"""Height above the approach pose from which the trunk is lowered [m] (ours)."""

ROLL_UP_TIME = 1.8
"""Duration of the rolling up [s] (ours)."""

TURN_TIME = 1.8
"""Duration of the turn into the pose, longer for long trunks (`stretch`) [s] (ours): the wrist turns and bears the
rolled trunk, which is then held out."""

BESIDE_TIME = 0.4
"""Least duration of a level move of the rolled trunk [s] (ours), which is stiff and does not sway."""


@final
@dataclass(frozen=True, kw_only=True)
class ApproachPose:
    """Pose of the rolled trunk for a push in one direction."""

    way: np.ndarray
    """Unit vector of the push, level, shape (3,) [-]."""
    rotation: np.ndarray
    """Orientation of the base, shape (3, 3) [-]."""
    tension: np.ndarray
    """Tensions that keep the trunk rolled up, shape (n_cable,) [N]."""
    trunk: RolledTrunk
    """Shape of the rolled trunk."""
    height: float
    """Height of the base at which the front meets the object as wanted, in the world [m]."""

    @property
    def right(self) -> np.ndarray:
        """Unit vector to the right of the push, the side of the front from the base, shape (3,) [-]."""
        return np.array([self.way[1], -self.way[0], 0.0])

    def base_behind(self, place: np.ndarray, gap: float) -> np.ndarray:
        """Position of the base with the front ``gap`` [m] behind a place, shape (3,) [m]."""
        beside = place - (self.trunk.forward + gap) * self.way - self.trunk.lateral * self.right
        return np.array([beside[0], beside[1], self.height])

    def front_of(self, base: np.ndarray) -> np.ndarray:
        """Foremost point of the rolled trunk for a position of its base, shape (3,) [m]."""
        ahead = base + self.trunk.forward * self.way + self.trunk.lateral * self.right
        return np.array([ahead[0], ahead[1], base[2] - self.trunk.below])

    def move(self, action: str, duration: float, position: np.ndarray) -> Move:
        """A move of the reach to a position of the base in this pose, shape (3,) [m]."""
        return Move(
            phase="reach", action=action, duration=duration, position=position, tension=self.tension,
            rotation=self.rotation,
        )  # fmt: skip


def plan_pose(task: Task, contact: float) -> ApproachPose:
    """Pose for the way from the object to its goal, with the contact at ``contact`` of the object's height [-].

    The rolled trunk meets no object lower than its own radius, and balls as low as it can.

    Raises:
        ModelError: where no cable pulls ventral, the task has no ground, or the object is at its goal already.
    """
    design, target, goal = task.design, task.target, task.goal
    ventral = find_ventral(design)
    if goal.ground is None:
        raise ModelError("the object hangs; allowed: an object on the ground, which can be pushed")
    way = (goal.place - target.position) * [1.0, 1.0, 0.0]
    distance = float(np.linalg.norm(way))
    if distance < 1e-6:
        raise ModelError("the object is where it shall be pushed; allowed: a goal beside it")
    trunk = predict_rolled_trunk(design, TILT)
    lowest = goal.ground + trunk.bottom + _find_clearance(design)
    middle = contact * 2 * (float(target.position[2]) - goal.ground)
    wanted = goal.ground + (0.0 if target.kind == "sphere" else middle) + trunk.below
    return ApproachPose(
        way=way / distance, rotation=tilted_base(way / distance, TILT), trunk=trunk, height=max(lowest, wanted),
        tension=TENSION * design.cable.tension_max * ventral,
    )  # fmt: skip


def _find_clearance(design: TrunkDesign) -> float:
    """Gap between rolled trunk and ground, by how far its weight opens the joints against the cables [m]."""
    weight, pull = design.total_mass * GRAVITY, TENSION * design.cable.tension_max
    return max(CLEARANCE, SAG * design.length * weight / pull)


def reach_of(target: Target) -> float:
    """Half of the object's largest extent seen from above [m]: a box may stand with an edge towards the trunk."""
    across = target.width * (math.sqrt(2.0) if target.kind == "box" else 1.0)
    lying = not is_upright(target) and target.kind != "sphere"
    return max(across, target.length if lying else 0.0) / 2


def roll_up(observation: Observation, pose: ApproachPose, base: np.ndarray) -> tuple[Move, ...]:
    """Moves that roll the trunk up in the air above ``base``, shape (3,) [m], and turn it into its pose."""
    ground, length = pose.height - pose.trunk.bottom, observation.task.design.length
    air = np.array([base[0], base[1], max(base[2], ground + (ABOVE + 1.0) * length)])
    over = np.array([base[0], base[1], max(base[2], ground + ABOVE * length)])
    turn_time = TURN_TIME * stretch(observation.task.design)
    return replace(pose.move("roll up", ROLL_UP_TIME, air), rotation=None), pose.move("turn", turn_time, over)


def go_down(pose: ApproachPose, base: np.ndarray, here: np.ndarray) -> tuple[Move, ...]:
    """Moves that bring the rolled trunk from ``here`` to above ``base``, each shape (3,) [m], then down."""
    over = base + np.array([0.0, 0.0, _DOWN_FROM])
    beside = pose.move("come beside", max(BESIDE_TIME, travel_time(over - here)), over)
    return beside, pose.move("come down", travel_time(base - over), base)
