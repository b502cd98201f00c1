"""Frames of an episode: what a policy sees and does, as vectors at a constant rate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import final

import numpy as np

from spiraltrunk.control.encoding import (
    ArmJoints,
    ControlMode,
    decode_action,
    encode_agent,
    encode_command,
    encode_environment,
)
from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.sim.robot.arm_ik import ArmReach
from spiraltrunk.sim.robot.arm_joints import build_arm_joints


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Frames:
    """Frames of an episode, m of them: what is seen at each and at the end, and the action until the next."""

    agent: np.ndarray
    """What the robot measures of itself, shape (m + 1, n_agent), float32."""
    environment: np.ndarray
    """What it knows of object and goal, shape (m + 1, n_environment), float32."""
    action: np.ndarray
    """Actions in [-1, 1], shape (m, n_action), float32."""
    clipped: np.ndarray
    """Largest amount by which a number of any action was beyond -1 or 1, shape () [-]."""

    def __len__(self) -> int:
        return len(self.action)


ARRAYS = ("agent", "environment", "action", "clipped")
"""Names of the arrays of frames."""


def choose_steps(count: int, stride: int) -> np.ndarray:
    """Observations that are frames: every ``stride``-th, and the last, which ends the episode; shape (m + 1,).

    Args:
        count: number of commands.
        stride: commands from one frame to the next.
    """
    return np.append(np.arange(0, count, stride), count)


def encode_frames(
    seen: Sequence[Observation],
    commands: Sequence[Command],
    arm_position: Sequence[np.ndarray],
    *,
    mode: ControlMode,
    stride: int = 1,
) -> Frames:
    """Frames of observations and commands.

    The action of a frame is the last command before the next frame, encoded relative to the one before as it is decoded
    from its action, so that actions decoded one after another do not drift.

    Args:
        seen: observations, n + 1 of them.
        commands: commands, n of them.
        arm_position: joint positions that the commands lead to, shape (n_arm,) each [rad].
        mode: what an action sets.
        stride: commands from one frame to the next.

    Raises:
        DesignError: for the mode that sets joints, where the arm's limits are not known.
    """
    steps, task = choose_steps(len(commands), stride), seen[0].task
    arm = read_arm_joints(task.design) if mode.sets_joints else None
    before = Command(T_world_base=seen[0].T_world_base, cable_tension=np.zeros(task.design.n_cable))
    actions, clipped = [], 0.0
    agent, environment = [encode_agent(seen[0])], [encode_environment(seen[0])]
    for step in steps[1:]:
        encoded = encode_command(
            mode, commands[step - 1], before, task, period=stride * CONTROL_PERIOD, arm=arm,
            arm_position=arm_position[step - 1],
        )  # fmt: skip
        before = decode_action(mode, encoded.action, before, task, period=stride * CONTROL_PERIOD, arm=arm)
        actions.append(encoded.action)
        clipped = max(clipped, encoded.clipped)
        agent.append(encode_agent(seen[step], before))
        environment.append(encode_environment(seen[step]))
    return Frames(
        agent=np.stack(agent), environment=np.stack(environment), action=np.stack(actions), clipped=np.array(clipped)
    )


@cache
def read_arm_joints(design: TrunkDesign) -> ArmJoints:
    """The joints of a design's arm as environments have them, for the mode that sets them.

    Raises:
        DesignError: where their limits are not known.
    """
    reach = ArmReach(design)
    limits = reach.limits.position
    if limits is None or not np.isfinite(limits).all():
        allowed = (
            "delta-pose-tension-pull or another mode of the base's pose, as this arm states no limits of all joints"
        )
        raise DesignError("demos.mode", got="joint-tension", allowed=allowed)
    return build_arm_joints(reach)
