"""A policy of the control mode "stroke": a network chooses how the rolled trunk strikes an object that it sees.

Learned: gap and lateral offset behind the object, height, direction, length and speed of the stroke, from the object as
announced and as seen. Given, as in the kick (strategy 8): the trunk is rolled up, tilted and brought down along the way
to the goal, the stroke is a minimum-jerk path, and the arm rises and watches afterwards. An object that is then seen
short of its goal is struck once more.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from spiraltrunk.control.messages import Observation, Task
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.strategies.moves import Move, base_position
from spiraltrunk.strategies.object_measures import UPRIGHT, is_upright
from spiraltrunk.strategies.policy.description import PolicyDescription
from spiraltrunk.strategies.policy.network import Network, forward
from spiraltrunk.strategies.policy.policy_strategy import describe_difference, take_over
from spiraltrunk.strategies.push.approach_pose import ApproachPose, go_down, plan_pose, reach_of
from spiraltrunk.strategies.push.push_strategy import PushState
from spiraltrunk.strategies.push.strike_strategy import StrikeStrategy, rise_and_watch, rise_point
from spiraltrunk.strategies.sensing import seen_position
from spiraltrunk.strategies.timing import PEAK_SPEED

INPUTS = (
    "is_sphere", "is_box", "is_upright", "width", "length", "mass", "height", "goal_distance", "seen_along",
    "seen_across", "seen_turn_cosine", "seen_turn_sine",
)  # fmt: skip
"""Inputs of the network: the announced object [m, kg], how far it is seen off its place along and across the way [m],
and twice the angle of its axis seen from above to the way, as cosine and sine [-]."""

OUTPUTS = ("gap", "across", "height", "angle", "follow", "speed")
"""Outputs of the network, each from -1 to 1 over its range in RANGES."""

RANGES = {
    "gap": (0.01, 0.12), "across": (-0.06, 0.06), "height": (0.0, 0.06), "angle": (-0.4, 0.4), "follow": (0.0, 0.25),
    "speed": (0.08, 0.75),
}  # fmt: skip
"""Gap behind the object, offset to the right, height above the lowest [m], angle of the stroke to the left of the way
[rad], travel beyond the gap [m], greatest speed [m/s] (ours)."""

RISE_TIME = 1.5
"""Duration of the rise after the stroke [s] (ours)."""


@final
@dataclass(frozen=True, kw_only=True)
class Stroke:
    """A stroke of the rolled trunk."""

    start: np.ndarray
    """Position of the base at the start, shape (3,) [m]."""
    end: np.ndarray
    """Position of the base at the end, shape (3,) [m]."""
    duration: float
    """Duration [s]."""


@final
class StrokeStrategy(StrikeStrategy):
    """A learned policy of the control mode "stroke".

    Args:
        name: its name in tables.
        description: what its network takes and gives.
        networks: "action", the stroke.
    """

    number = 0

    def __init__(self, name: str, description: PolicyDescription, networks: dict[str, Network]) -> None:
        take_over(self, name, description)
        self._description, self._network = description, networks["action"]

    def widths(self, design: TrunkDesign) -> tuple[float, float]:
        """Least and greatest width of the objects that it was trained for [m]."""
        return self._description.widths

    def init(self, observation: Observation) -> PushState:
        """Plan the pose of the rolled trunk from design, object and goal.

        Raises:
            ModelError: where the policy was trained with other observations, or the robot cannot do what is asked.
        """
        for kind, given, known in (
            ("inputs", self._description.inputs, INPUTS), ("outputs", self._description.outputs, OUTPUTS)
        ):  # fmt: skip
            if given != known:
                raise ModelError(f"{self.name} has other {kind}: {describe_difference(given, known)}")
        pose = plan_pose(observation.task, 0.0)
        return PushState(sequence=self.roll_up(pose, observation), pose=pose)

    def strike(self, state: PushState, observation: Observation) -> tuple[Move, ...]:
        """The stroke that the network chooses by the last camera observation."""
        chosen = forward(self._network, describe_scene(state.pose, observation))
        stroke, here = plan_stroke(chosen, state.pose, observation), base_position(state.sequence, observation.time)
        return plan_moves(state.pose, stroke, here)


def describe_scene(pose: ApproachPose, observation: Observation) -> np.ndarray:
    """Inputs of the network, in SI units, shape (12,): INPUTS."""
    task: Task = observation.task
    target, seen = task.target, seen_position(observation) - task.target.position
    axis = target.axis if observation.camera is None else observation.camera.axis
    turn = 2 * math.atan2(float(axis @ -pose.right), float(axis @ pose.way))
    is_level = abs(float(axis[2])) < UPRIGHT
    height = 2 * (float(target.position[2]) - (task.goal.ground or 0.0))
    distance = float(np.linalg.norm((task.goal.place - target.position)[:2]))
    return np.array([
        target.kind == "sphere", target.kind == "box", is_upright(target), target.width, target.length,
        target.mass, height, distance, float(seen @ pose.way), float(seen @ pose.right),
        is_level * math.cos(turn), is_level * math.sin(turn),
    ], dtype=float)  # fmt: skip


def plan_stroke(chosen: np.ndarray, pose: ApproachPose, observation: Observation) -> Stroke:
    """The stroke at an object as seen, from outputs of the network, shape (6,), each from -1 to 1."""
    share = (np.clip(chosen, -1.0, 1.0) + 1) / 2
    value = {name: low + part * (high - low) for (name, (low, high)), part in zip(RANGES.items(), share, strict=True)}
    behind = pose.base_behind(seen_position(observation), reach_of(observation.task.target) + value["gap"])
    start = behind + value["across"] * pose.right + np.array([0.0, 0.0, value["height"]])
    travel = value["gap"] + value["follow"]
    way = math.cos(value["angle"]) * pose.way - math.sin(value["angle"]) * pose.right
    return Stroke(start=start, end=start + travel * way, duration=PEAK_SPEED * travel / value["speed"])


def plan_moves(pose: ApproachPose, stroke: Stroke, here: np.ndarray) -> tuple[Move, ...]:
    """Moves from ``here``, shape (3,) [m], down behind the object, the stroke, and the rise and the wait after it."""
    kick: Any = replace(pose.move("strike", stroke.duration, stroke.end), phase="transport", milestone=Milestone.PUSHED)
    up = rise_point(stroke.end, pose.way)
    return (*go_down(pose, stroke.start, here), kick, *rise_and_watch(kick, up, RISE_TIME))
