"""Actions in [-1, 1] as commands, and commands as actions.

An action is the arm's part (translation then rotation vector of the base, 3 + 3 numbers, or one number a joint), the
cables' part (one number a cable for tensions, for pulls or for each) and the gripper's number, float32.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.control.encoding.control_mode import ControlMode
from spiraltrunk.control.encoding.rotation_vector import measure_turn, rotate_by
from spiraltrunk.control.messages import Command, Task
from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError, describe
from spiraltrunk.field_docs import explain_fields

TRANSLATION_SPEED = 0.6
"""Speed of the base along one axis that an action of 1 asks for in the relative modes [m/s] (ours): strategies stay
below."""

ROTATION_SPEED = 2.0
"""Angular speed of the base about one axis that an action of 1 asks for in the relative modes [rad/s] (ours)."""

POSE_RANGE = 1.2
"""Distance of the base from the announced object along one axis at an action of 1 in the absolute modes [m] (ours)."""

PULL_RANGE = 1.5
"""Pull at an action of 1 over the design's cable stroke [-] (ours); a cable cannot be pulled in further than its
stroke, so that 1 sets no limit."""

PULL_TENSION = 0.5
"""Tension of the modes that set pulls alone, over the design's largest [-] (ours)."""

LEAD_MOST = 0.15
"""Largest distance of the commanded from the measured base in the relative modes [m] (ours): an arm at its limits does
not wind up."""

HANGING = np.array([[0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]])
"""Orientation of a hanging trunk's base at which the rotation vector of the absolute modes is 0, shape (3, 3) [-]."""

HANGING.setflags(write=False)

Vectors = Sequence[Sequence[float]]
"""Vectors, each a row."""

_SAME = 1e-12
"""Largest difference of two orientations that are equal [-]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class ArmJoints:
    """Joints of an arm, for the mode that sets them."""

    low: np.ndarray
    """Least joint positions, shape (n_arm,) [rad]."""
    high: np.ndarray
    """Largest joint positions, shape (n_arm,) [rad]."""
    T_base: Callable[[np.ndarray], np.ndarray]
    """Forward kinematics: frame of the trunk's base at joint positions, shape (4, 4) [-, m]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class EncodedAction:
    """A command as an action, and what the action leaves out."""

    action: np.ndarray
    """The action, float32 in [-1, 1]."""
    clipped: float
    """Largest amount by which a number was beyond -1 or 1 before it was clipped [-]."""
    dropped: tuple[str, ...]
    """Parts of the command that the control mode cannot express: "cable_pull" where pulls were limited and the mode
    sets tensions alone, "cable_tension" the other way round, "T_world_base" where the mode sets joints."""


def action_names(mode: ControlMode, design: TrunkDesign, n_arm: int = 7) -> tuple[str, ...]:
    """Name of each number of an action, with the unit in which it is scaled."""
    kind = "delta" if mode.is_relative else "base"
    arm = tuple(f"arm_joint_{i + 1}" for i in range(n_arm))
    pose = tuple(f"{kind}_{what}" for what in ("x", "y", "z", "turn_x", "turn_y", "turn_z"))
    cables = range(1, design.n_cable + 1)
    tensions = tuple(f"tension_{c}" for c in cables) if mode.sets_tension else ()
    pulls = tuple(f"pull_{c}" for c in cables) if mode.sets_pull else ()
    return (*(arm if mode.sets_joints else pose), *tensions, *pulls, "gripper")


def action_size(mode: ControlMode, design: TrunkDesign, n_arm: int = 7) -> int:
    """Count of the numbers of an action."""
    per_cable = int(mode.sets_tension) + int(mode.sets_pull)
    return (n_arm if mode.sets_joints else 6) + per_cable * design.n_cable + 1


def decode_action(
    mode: ControlMode,
    action: np.ndarray,
    before: Command,
    task: Task,
    *,
    period: float = CONTROL_PERIOD,
    measured: np.ndarray | None = None,
    arm: ArmJoints | None = None,
) -> Command:
    """The command of an action; numbers beyond [-1, 1] are clipped.

    Args:
        mode: what the action sets.
        action: shape (`action_size`,) [-].
        before: the last command, from which the relative modes displace the base.
        task: the task; its design scales the cables, its announced object is the frame of the absolute modes.
        period: time until the next action, which scales the displacement of the relative modes [s].
        measured: measured frame of the base, shape (4, 4), from which the relative modes lead by at most `LEAD_MOST`;
            None for no bound.
        arm: the arm, for the mode that sets joints; its command has the frame that they lead to.

    Raises:
        ModelError: for an action of another size or that is not finite, and for joints without an arm.
    """
    joints = () if arm is None else arm.low
    given = read_action(action, action_size(mode, task.design, len(joints)))
    if mode.sets_joints:
        frame = _require_arm(arm).T_base(decode_joints(given, _require_arm(arm)))
    elif mode.is_relative:
        frame = move_frame(before.T_world_base, read_displacement(given, before.T_world_base, period, measured))
    else:
        frame = _place(given[:6], task)
    first = len(joints) if mode.sets_joints else 6
    tension, pull = decode_cables(mode, given[first:-1], task.design)
    return Command(T_world_base=frame, cable_tension=tension, cable_pull=pull, gripper=float(given[-1]))


def decode_joints(action: np.ndarray, arm: ArmJoints) -> np.ndarray:
    """Joint positions of an action of the mode that sets them, shape (n_arm,) [rad]."""
    share = np.clip(np.asarray(action[: arm.low.size], dtype=float), -1.0, 1.0)
    return np.asarray(arm.low + (share + 1) / 2 * (arm.high - arm.low))


def encode_command(
    mode: ControlMode,
    command: Command,
    before: Command,
    task: Task,
    *,
    period: float = CONTROL_PERIOD,
    arm: ArmJoints | None = None,
    arm_position: np.ndarray | None = None,
) -> EncodedAction:
    """The action of a command, the inverse of `decode_action`.

    Args:
        mode: what the action sets.
        command: the command.
        before: the command before it, as decoded from its action where the actions are to be decoded in turn.
        task: as in `decode_action`.
        period: likewise [s].
        arm: likewise.
        arm_position: joint positions that the command leads to, for the mode that sets them, shape (n_arm,) [rad].

    Raises:
        ModelError: for the mode that sets joints without arm and joint positions.
    """
    if mode.sets_joints:
        if arm_position is None:
            raise ModelError("arm_position is None; allowed: the joint positions that the command leads to")
        low, high = _require_arm(arm).low, _require_arm(arm).high
        base = 2 * (arm_position - low) / (high - low) - 1
    elif mode.is_relative:
        way, turn = measure_displacement(command.T_world_base, before.T_world_base)
        base = np.array([*way, *turn]) / period / np.repeat([TRANSLATION_SPEED, ROTATION_SPEED], 3)
    else:
        base = _measure_place(command.T_world_base, task)
    exact = np.concatenate([base, _encode_cables(mode, command, task.design), [command.gripper]])
    action = np.clip(exact, -1.0, 1.0)
    excess = float(np.abs(exact - action).max())
    return EncodedAction(action=action.astype(np.float32), clipped=excess, dropped=_find_dropped(mode, command))


def interpolate_command(before: Command, after: Command, share: float) -> Command:
    """Command at ``share`` of the way from one to the next, 0 to 1: for actions that last several control periods.

    Position, tension, finite pulls and gripper are linear, the orientation turns at a constant rate.
    """
    if share >= 1.0:
        return after
    T, start, end = before.T_world_base.copy(), before.T_world_base, after.T_world_base
    T[:3, 3] += share * (end[:3, 3] - start[:3, 3])
    if not np.array_equal(start[:3, :3], end[:3, :3]):
        turn = measure_turn(end[:3, :3] @ start[:3, :3].T)
        T[:3, :3] = rotate_by([share * part for part in turn]) @ start[:3, :3]
    pull = after.cable_pull
    if pull is not None and before.cable_pull is not None:
        with np.errstate(invalid="ignore"):
            between = before.cable_pull + share * (pull - before.cable_pull)
        pull = np.where(np.isfinite(pull) & np.isfinite(before.cable_pull), between, pull)
    return replace(
        after, T_world_base=T, cable_pull=pull,
        cable_tension=before.cable_tension + share * (after.cable_tension - before.cable_tension),
        gripper=before.gripper + share * (after.gripper - before.gripper),
    )  # fmt: skip


def read_action(action: np.ndarray, size: int) -> np.ndarray:
    """The action in float64, cut to [-1, 1].

    Raises:
        ModelError: for an action of another size or that is not finite.
    """
    try:
        given = np.asarray(action, dtype=float)
        numbers = given.tolist()
        is_right = given.shape == (size,) and all(map(math.isfinite, numbers))
    except (ValueError, TypeError):
        is_right = False
    if not is_right:
        told = describe(action.tolist() if isinstance(action, np.ndarray) else action)
        raise ModelError(f"action is {told}; allowed: {size} finite numbers from -1 to 1")
    return np.array([min(max(each, -1.0), 1.0) for each in numbers])


def _require_arm(arm: ArmJoints | None) -> ArmJoints:
    if arm is None:
        raise ModelError("arm is None; allowed: the joints of the arm, for the control mode joint-tension")
    return arm


def read_displacement(given: np.ndarray, start: np.ndarray, period: float, measured: np.ndarray | None) -> Vectors:
    """Displacement and rotation vector of the base that an action of a relative mode asks for [m, rad].

    The arguments are those of `decode_action`; ``start`` is the frame of the last command.
    """
    x, y, z, *turn = given[:6].tolist()
    way = [TRANSLATION_SPEED * period * part for part in (x, y, z)]
    if measured is not None:
        behind = (start[:3, 3] - measured[:3, 3]).tolist()
        lead = [a + b for a, b in zip(behind, way, strict=True)]
        if math.hypot(*lead) > LEAD_MOST:
            share = LEAD_MOST / math.hypot(*lead)
            way = [share * a - b for a, b in zip(lead, behind, strict=True)]
    return [way, [ROTATION_SPEED * period * part for part in turn]]


def move_frame(start: np.ndarray, moved: Vectors) -> np.ndarray:
    """The frame after a displacement and a rotation vector in the world [m, rad], shape (4, 4)."""
    T, (way, turn) = start.copy(), moved
    T[:3, 3] += way
    if any(turn):
        T[:3, :3] = rotate_by(turn) @ start[:3, :3]
    return T


def measure_displacement(end: np.ndarray, start: np.ndarray) -> Vectors:
    """Displacement and rotation vector in the world from one frame to another [m, rad]: the inverse of `move_frame`.

    Orientations that differ by rounding errors alone are taken as equal.
    """
    way = (end[:3, 3] - start[:3, 3]).tolist()
    if np.abs(end[:3, :3] - start[:3, :3]).max() < _SAME:
        return [way, [0.0, 0.0, 0.0]]
    return [way, measure_turn(end[:3, :3] @ start[:3, :3].T)]


def _task_frame(task: Task) -> np.ndarray:
    """Rotation of the announced object's frame into the world, shape (3, 3): z up, x along a level axis."""
    x, y, _ = task.target.axis.tolist()
    length = float(np.hypot(x, y))
    x, y = (x / length, y / length) if length > 0.5 else (1.0, 0.0)
    return np.array([[x, -y, 0.0], [y, x, 0.0], [0.0, 0.0, 1.0]])


def _place(action: np.ndarray, task: Task) -> np.ndarray:
    """Frame of the base from its pose in the frame of the announced object, shape (4, 4)."""
    frame, T = _task_frame(task), np.eye(4)
    T[:3, 3] = task.target.position + POSE_RANGE * frame @ action[:3]
    T[:3, :3] = frame @ rotate_by((np.pi * action[3:]).tolist()) @ HANGING
    return T


def _measure_place(T: np.ndarray, task: Task) -> np.ndarray:
    frame = _task_frame(task)
    turn = measure_turn(frame.T @ T[:3, :3] @ HANGING.T)
    return np.concatenate([frame.T @ (T[:3, 3] - task.target.position) / POSE_RANGE, np.array(turn) / np.pi])


def decode_cables(mode: ControlMode, given: np.ndarray, design: TrunkDesign) -> tuple[np.ndarray, np.ndarray | None]:
    """Largest tensions and pulls of an action's numbers for the cables, each of shape (n_cable,) [N, m]."""
    n, most, numbers = design.n_cable, design.cable.tension_max, given.tolist()
    shares = [(each + 1) / 2 for each in numbers[:n]] if mode.sets_tension else [PULL_TENSION] * n
    tension = np.array([share * most for share in shares])
    if not mode.sets_pull:
        return tension, None
    stroke = design.cable_stroke
    return tension, np.array([math.inf if each >= 1.0 else each * PULL_RANGE * stroke for each in numbers[-n:]])


def _encode_cables(mode: ControlMode, command: Command, design: TrunkDesign) -> np.ndarray:
    parts = [2 * command.cable_tension / design.cable.tension_max - 1] if mode.sets_tension else []
    if mode.sets_pull:
        pull = np.full(design.n_cable, np.inf) if command.cable_pull is None else command.cable_pull
        parts.append(np.where(np.isinf(pull), 1.0, pull / (PULL_RANGE * design.cable_stroke)))
    return np.concatenate(parts)


def _find_dropped(mode: ControlMode, command: Command) -> tuple[str, ...]:
    is_limited = command.cable_pull is not None and bool(np.isfinite(command.cable_pull).any())
    parts = {
        "T_world_base": mode.sets_joints,
        "cable_tension": not mode.sets_tension,
        "cable_pull": is_limited and not mode.sets_pull,
    }
    return tuple(name for name, is_dropped in parts.items() if is_dropped)
