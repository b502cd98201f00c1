"""Strategy 8, the trunk kick: a stroke of the arm with the rolled trunk sends an object towards its goal.

Source: "Grasping by Spiraling", Results, "Preparatory Action": objects beyond reach, or oriented so that they cannot be
grasped at once, are rolled or pushed by a kick or a sweep (strategies 8 and 9) to a more accessible place.

Phases: reach (roll up, tilt, observe, come down behind the object), transport (the stroke, which meets the object at
its greatest speed), release (rise, wait, observe; strike once more if the object did not go far enough). A ball rolls
on, so that it is struck more slowly than an object that slides.

Limits: one direction of the stroke, along which the arm reaches; a camera that sees the object before the stroke; the
object is sent beyond a line, not to a place.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import final

from spiraltrunk.control.messages import Observation
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.strategies.moves import Move, base_position
from spiraltrunk.strategies.push.approach_pose import go_down, plan_pose
from spiraltrunk.strategies.push.push_strategy import PushState, is_still
from spiraltrunk.strategies.push.strike_strategy import RUN_UP, StrikeStrategy, rise_and_watch, rise_point
from spiraltrunk.strategies.timing import PEAK_SPEED, travel_time

# All of these are ours, tuned in simulated trials.
FOLLOW = 0.20
"""Travel after it has met the object [m]."""
SPEED = 0.70
"""Greatest speed of the stroke [m/s]: the arm's limits allow about 0.8."""
ROLL = 0.20
"""Distance that a ball rolls on [m]; with the resistance below it sets the speed of its stroke."""
RESISTANCE = 1e-3
"""Expected coefficient of rolling resistance of a ball [m]."""
CONTACT = 0.22
"""Height of the contact over that of the object [-]: low, so that a standing object slides and does not fall over."""
RISE_TIME = 1.0
"""Least duration of the rise after the stroke [s]."""


@final
class Kick(StrikeStrategy):
    """A stroke with the rolled trunk."""

    name = "kick"
    number = 8
    holds = "nothing"
    job = "kick"
    objects = ("box-80", "box-100", "cylinder-90", "cylinder-120", "ball-80", "ball-100", "ball-120")
    position = (0.50, 0.10)
    push = (0.0, 0.15)

    def init(self, observation: Observation) -> PushState:
        """Plan the approach pose from design, object and goal."""
        pose = plan_pose(observation.task, CONTACT)
        return PushState(sequence=self.roll_up(pose, observation), pose=pose)

    def has_ended(self, state: PushState, observation: Observation) -> bool:
        """Whether the present move has ended: the wait where the object is seen at rest."""
        is_over = state.sequence.move.action == "watch" and is_still(state)
        return is_over or super().has_ended(state, observation)

    def strike(self, state: PushState, observation: Observation) -> tuple[Move, ...]:
        """Moves down behind the object as observed, a stroke at the speed that suits it, the rise and the wait."""
        pose, here = state.pose, base_position(state.sequence, observation.time)
        start, stroke = self.base_behind(pose, observation), RUN_UP + FOLLOW
        end = start + stroke * pose.way
        kick = replace(
            pose.move("kick", PEAK_SPEED * stroke / _stroke_speed(observation), end),
            phase="transport", milestone=Milestone.PUSHED,
        )  # fmt: skip
        up = rise_point(end, pose.way)
        return (*go_down(pose, start, here), kick, *rise_and_watch(kick, up, max(RISE_TIME, travel_time(up - end))))


def _stroke_speed(observation: Observation) -> float:
    """Speed at which a ball rolls on as far as it shall, or at which a standing object does not fall over [m/s].

    A rolling ball loses 5/7 g c / r of speed a second, with rolling resistance c and radius r. A standing object that
    is stopped at its foot falls over where its energy lifts its centre over the edge: v^2 / 2 = g (d - h), with h the
    height of its centre and d the distance of the centre from the edge.
    """
    target, radius = observation.task.target, observation.task.target.width / 2
    if target.kind == "sphere":
        free = math.sqrt(2 * 5 / 7 * GRAVITY * RESISTANCE / radius * ROLL)
    else:
        height = float(target.position[2]) - (observation.task.goal.ground or 0.0)
        free = math.sqrt(2 * GRAVITY * (math.hypot(height, radius) - height))
    return min(SPEED, free)
