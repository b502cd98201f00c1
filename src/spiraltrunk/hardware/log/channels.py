"""Channels of a log: one frozen dataclass each, which is the definition of its messages, schema and arrays.

Times are on the driver's clock (`hardware.clock.Clock`), the one clock of motors, arm and motion capture. A number that
is not finite is null in the file and NaN in an array.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Annotated, NamedTuple, final, get_type_hints

import numpy as np

from spiraltrunk.field_docs import explain_fields


@final
class Column(NamedTuple):
    """Type of a field in JSON."""

    kind: str
    """"number", "integer", "boolean" or "string"."""
    depth: int = 0
    """Number of axes of each message's value, 0 for a single one and 1 for a list."""
    is_later: bool = False
    """Whether logs of earlier versions lack it, which reads as null."""


Number = Annotated[np.ndarray, Column("number")]
Vector = Annotated[np.ndarray, Column("number", 1)]
Later = Annotated[np.ndarray, Column("number", 1, is_later=True)]
Matrix = Annotated[np.ndarray, Column("number", 2)]
Count = Annotated[np.ndarray, Column("integer")]
Flag = Annotated[np.ndarray, Column("boolean")]
Text = Annotated[tuple[str | None, ...], Column("string")]
Texts = Annotated[tuple[tuple[str, ...] | None, ...], Column("string", 1)]


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, eq=False)
class MotorLog:
    """Winders' motors, n messages."""

    time: Number
    """Driver's clock, shape (n,) [s]."""
    feedback_time: Vector
    """Arrival of each motor's latest feedback on the driver's clock, shape (n, n_cable) [s]; NaN before the first."""
    angle: Vector
    """Angle turned since the driver's start, shape (n, n_cable) [rad]."""
    speed: Vector
    """Speed, positive when the cable is wound in, shape (n, n_cable) [rad/s]."""
    torque: Vector
    """Torque by the motor's own estimate, positive when it winds in, shape (n, n_cable) [N m]."""
    torque_sent: Later
    """Torque that was sent last, positive when it winds in, shape (n, n_cable) [N m]; in a log that lacks it, shape
    (n, 0), and `torque` holds what was sent."""
    temperature: Vector
    """Temperature, shape (n, n_cable) [degC]."""
    voltage: Vector
    """Supply voltage, shape (n, n_cable) [V]; NaN where the motor does not measure it."""
    pull: Vector
    """Cable pulled in since the straight trunk, shape (n, n_cable) [m]."""
    tension: Vector
    """Tension by load cells, or as it is estimated, shape (n, n_cable) [N]."""
    felt: Later
    """Tension by load cells, shape (n, n_cable) [N]; NaN without a cell or a reading that may be used. In a log that
    lacks it, shape (n, 0)."""
    target: Vector
    """Set tension of the winder, shape (n, n_cable) [N]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ArmLog:
    """Measured states of the arm, n messages."""

    time: Number
    """Time of the measurement on the driver's clock, shape (n,) [s]."""
    position: Vector
    """Joint positions, shape (n, n_arm) [rad]."""
    velocity: Vector
    """Joint velocities, shape (n, n_arm) [rad/s]."""
    acceleration: Vector
    """Joint accelerations, shape (n, n_arm) [rad/s^2]."""
    torque: Vector
    """Joint torques, shape (n, n_arm) [N m]."""
    error: Text
    """What the arm's controller reports; None where it runs."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ObservationLog:
    """Observations that a strategy got, n messages."""

    time: Number
    """Driver's clock, shape (n,) [s]."""
    step: Count
    """Number of the observation, 0 from reset, shape (n,) [-]."""
    run_time: Number
    """Time since reset, shape (n,) [s]."""
    T_world_base: Matrix
    """Pose of the trunk's base, shape (n, 4, 4) [-, m]."""
    arm_position: Vector
    """Joint positions of the arm, shape (n, n_arm) [rad]."""
    arm_velocity: Vector
    """Joint velocities of the arm, shape (n, n_arm) [rad/s]."""
    cable_pull: Vector
    """Cable pulled in since the straight trunk, shape (n, n_cable) [m]."""
    cable_tension: Vector
    """Tension estimates, shape (n, n_cable) [N]."""
    base_force: Vector
    """Force of all that hangs on the trunk's base, shape (n, 3) [N]."""
    base_torque: Vector
    """Torque of the same about the trunk's base, shape (n, 3) [N m]."""
    camera_time: Number
    """Time since reset of the latest camera observation, shape (n,) [s]; NaN where there is none."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, eq=False)
class CommandLog:
    """Commands of a strategy, n messages."""

    time: Number
    """Driver's clock, shape (n,) [s]."""
    step: Count
    """Number of the observation that it answers, shape (n,) [-]."""
    T_world_base: Matrix
    """Desired pose of the trunk's base, shape (n, 4, 4) [-, m]."""
    cable_tension: Vector
    """Upper limit of each cable's tension, shape (n, n_cable) [N]."""
    cable_pull: Vector
    """Upper limit of the cable pulled in, shape (n, n_cable) [m]; NaN where there is no limit."""
    gripper: Number
    """Tip gripper from -1 (open) to 1 (closed), shape (n,) [-]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, eq=False)
class StatusLog:
    """Status of a strategy at each command, n messages."""

    time: Number
    """Driver's clock, shape (n,) [s]."""
    step: Count
    """Number of the command, shape (n,) [-]."""
    phase: Text
    """Phase."""
    action: Text
    """Action within the phase."""
    milestone: Text
    """What the step works towards; None between milestones."""
    is_done: Flag
    """Whether the strategy has ended, shape (n,)."""
    gave_up: Text
    """Why it ended before its goal, if it did."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, eq=False)
class EndLog:
    """End of a run, one message where it was reached."""

    time: Number
    """Driver's clock, shape (n,) [s]."""
    step: Count
    """Number of the last command, -1 where there was none, shape (n,) [-]."""
    phase: Text
    """Last phase."""
    action: Text
    """Last action within the phase."""
    milestone: Text
    """What the last step worked towards; None between milestones."""
    is_done: Flag
    """Whether the strategy has ended, shape (n,)."""
    gave_up: Text
    """Why the strategy ended before its goal, if it did."""
    planning: Number
    """Wall time of the strategy's `init`, shape (n,) [s]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, eq=False)
class StateLog:
    """Changes of the driver's state, n messages."""

    time: Number
    """Driver's clock, shape (n,) [s]."""
    mode: Text
    """Name of the state entered."""
    cause: Text
    """Why; None where it was asked for."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, eq=False)
class FaultLog:
    """Faults, n messages."""

    time: Number
    """When it was noticed on the driver's clock, shape (n,) [s]."""
    kind: Text
    """Value of `FaultKind`."""
    cable: Number
    """Cable that it concerns, counted from 0, shape (n,) [-]; NaN where it concerns all."""
    text: Text
    """What was measured and what is allowed."""
    reaction: Text
    """What was done; None where it is not known yet."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, eq=False)
class WarningLog:
    """Warnings, n messages."""

    time: Number
    """Driver's clock, shape (n,) [s]."""
    text: Text
    """One line."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, eq=False)
class CameraLog:
    """Camera observations of the object, n messages."""

    time: Number
    """Driver's clock at the observation that brought it, shape (n,) [s]."""
    run_time: Number
    """Time of the measurement since reset, shape (n,) [s]."""
    position: Vector
    """Centre of the object in the world, shape (n, 3) [m]."""
    axis: Vector
    """Unit vector along the object in the world, shape (n, 3) [-]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, eq=False)
class CaptureLog:
    """Frames of motion capture, n messages, all with the same bodies in the same order."""

    time: Number
    """Arrival of the frame on the driver's clock, shape (n,) [s]."""
    source_time: Number
    """Time of the frame on the capture system's own clock, shape (n,) [s]."""
    frame: Count
    """Number of the frame, shape (n,) [-]."""
    names: Texts
    """Names of the bodies."""
    position: Matrix
    """Positions in the capture system's frame, shape (n, n_body, 3) [m]; NaN where a body is not tracked."""
    rotation_wxyz: Matrix
    """Rotations as unit quaternions (w, x, y, z), shape (n, n_body, 4) [-]; NaN where a body is not tracked."""


CHANNELS: dict[str, type] = {
    "/motors": MotorLog,
    "/arm": ArmLog,
    "/observation": ObservationLog,
    "/command": CommandLog,
    "/status": StatusLog,
    "/end": EndLog,
    "/state": StateLog,
    "/fault": FaultLog,
    "/warning": WarningLog,
    "/camera": CameraLog,
    "/capture": CaptureLog,
}
"""Type of each channel, by its topic."""


def list_columns(topic: str) -> dict[str, Column]:
    """Columns of a channel by the names of its fields."""
    hints = get_type_hints(CHANNELS[topic], include_extras=True)
    return {name: hint.__metadata__[0] for name, hint in hints.items()}


def format_schema(topic: str) -> bytes:
    """JSON schema of a channel's messages.

    A number may be null, which the schema leaves out: whether Foxglove takes a list of types is unconfirmed.
    """
    properties: dict[str, object] = {}
    for name, column in list_columns(topic).items():
        entry: dict[str, object] = {"type": column.kind}
        for _ in range(column.depth):
            entry = {"type": "array", "items": entry}
        properties[name] = entry
    owner = CHANNELS[topic]
    document = {"title": owner.__name__, "description": owner.__doc__, "type": "object", "properties": properties}
    return json.dumps(document).encode()
