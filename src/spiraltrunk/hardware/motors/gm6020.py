"""RoboMaster GM6020 on CAN: its data sheet, identifiers, command and feedback frames. Never tried on a real motor.

Sources. "Manual" is DJI's RoboMaster GM6020 Brushless DC Motor User Guide, V1.0 (2018): bus of 1 Mbit/s, voltage
frames, feedback frame, encoder, torque constant and speed without load. Current mode (0x1FE, 0x2FE) and its scale of
16384 for 3 A are taken from public RoboMaster firmware: unconfirmed, and older motors may lack it. "(ours)" marks our
choice.

Identifiers 0x1FF and 0x205 to 0x208 also belong to the C620 controller of the M3508 motor with ids 5 to 8 (C620's
manual): the two families must not share a bus. Commands are big endian, four motors in a frame; the motors of the other
slots of a frame get zero.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from enum import Enum
from typing import NamedTuple, final

from spiraltrunk.errors import DriveError, describe
from spiraltrunk.hardware.motors.motor_port import MotorDataSheet

STEPS = 8192
"""Steps of the encoder in a turn (manual) [-]."""

TORQUE_CONSTANT = 0.741
"""Torque per current (manual) [N m/A]."""

CURRENT_MAX = 3.0
"""Largest current that can be commanded (public firmware; unconfirmed) [A]."""

CURRENT_RAW = 16384
"""Command and feedback of the largest current (public firmware; the feedback's scale is convention) [-]."""

VOLTAGE_RAW = 25000
"""Largest voltage command [-]: public code disagrees between 25000 and 30000; the smaller is used (ours)."""

SPEED_RPM = 320
"""Speed without load at 24 V (manual) [1/min]."""

TORQUE_PER_RAW = TORQUE_CONSTANT * CURRENT_MAX / CURRENT_RAW
"""Torque of one unit of command and feedback [N m]."""

ANGLE_PER_STEP = 2.0 * math.pi / STEPS
"""Angle of one step of the encoder [rad]."""

SPEED_PER_RPM = 2.0 * math.pi / 60.0
"""Speed of one unit of feedback [rad/s]."""

SPEED_PLAUSIBLE_RPM = 3 * SPEED_RPM
"""Reported speed above which a frame is not trusted (ours: no cable drives the motor at three times its own speed)."""

TEMPERATURE_PLAUSIBLE = 150
"""Reported temperature above which a frame is not trusted (ours: the winding would be gone) [degC]."""

GM6020 = MotorDataSheet(
    name="gm6020",
    torque_max=TORQUE_CONSTANT * CURRENT_MAX,
    speed_max=SPEED_RPM * SPEED_PER_RPM,
    torque_step=TORQUE_PER_RAW,
    angle_step=ANGLE_PER_STEP,
    period=0.001,
    feedback_period=0.001,
    silence_max=30.0 / SPEED_RPM,
    temperature_derate=70.0,
    temperature_stop=90.0,
    rotor_inertia=1.5e-4,
    rotor_friction=0.04,
)
"""Limits that no setting raises.

Torque is 2.223 N m = 0.741 N m/A * 3 A. The period is that of the feedback, 1 kHz (unconfirmed): with three motors a
command and three answers of at most 135 bits take 0.54 ms of it at 1 Mbit/s. Half a turn at full speed takes 94 ms.
Temperatures are ours: the winding's own limit is unconfirmed. Rotor inertia (a ring of 0.19 kg at 28 mm) and friction
are estimates (ours) that only the twin uses.
"""

_COMMAND = struct.Struct(">4h")
_FEEDBACK = struct.Struct(">HhhBB")


@final
class CommandMode(Enum):
    """Quantity that commands set; its value is the identifier of the frame for motors 1 to 4."""

    VOLTAGE = 0x1FF
    CURRENT = 0x1FE

    @property
    def limit(self) -> int:
        """Largest command, in either sense [-]."""
        return VOLTAGE_RAW if self is CommandMode.VOLTAGE else CURRENT_RAW


@final
class Feedback(NamedTuple):
    """Content of one feedback frame, in the motor's own units."""

    angle: int
    """Angle within a turn, 0 to 8191 [steps]."""
    speed_rpm: int
    """Speed [1/min]."""
    current: int
    """Torque current; 16384 is 3 A by convention [-]."""
    temperature: int
    """Temperature [degC]."""


def compute_command_id(motor_id: int, mode: CommandMode) -> int:
    """Identifier of the frame that carries a motor's command: one for motors 1 to 4, another for 5 to 7."""
    check_motor_id(motor_id)
    return mode.value + (0x100 if motor_id > 4 else 0)


def compute_slot(motor_id: int) -> int:
    """Place of a motor in its command frame: 0 for bytes 0 and 1, up to 3 for bytes 6 and 7."""
    check_motor_id(motor_id)
    return (motor_id - 1) % 4


def compute_feedback_id(motor_id: int) -> int:
    """Identifier of a motor's feedback: 0x204 more than its own id (manual)."""
    check_motor_id(motor_id)
    return 0x204 + motor_id


def check_motor_id(motor_id: int) -> None:
    """Refuse what the switches on the motor cannot be set to.

    Raises:
        DriveError: with the id and the range.
    """
    if not (type(motor_id) is int and 1 <= motor_id <= 7):
        raise DriveError(f"motor id is {describe(motor_id)}; allowed: a whole number from 1 to 7, as on its switches")


def check_motor_ids(motor_ids: Sequence[int]) -> None:
    """Refuse ids of the motors of one bus, one per cable, that are out of range or not unique.

    Raises:
        DriveError: with the ids and what is allowed.
    """
    for motor_id in motor_ids:
        check_motor_id(motor_id)
    if not motor_ids or len(set(motor_ids)) != len(motor_ids):
        raise DriveError(f"motor ids are {describe(list(motor_ids))}; allowed: one for each cable, no two alike")


def encode_command(values: Sequence[int], mode: CommandMode) -> bytes:
    """Content of a command frame: four values in the order of the motors' ids [-].

    Raises:
        DriveError: where they are not four whole numbers within the mode's limit; nothing is clamped.
    """
    limit = mode.limit
    if len(values) != 4 or not all(type(value) is int and -limit <= value <= limit for value in values):
        allowed = f"4 whole numbers from {-limit} to {limit}"
        raise DriveError(f"{mode.name.lower()} command is {describe(list(values))}; allowed: {allowed}")
    return _COMMAND.pack(*values)


def decode_command(data: bytes) -> tuple[int, int, int, int] | None:
    """The four values of a command frame; None of one that has not 8 bytes."""
    return _COMMAND.unpack(data) if len(data) == 8 else None


def encode_feedback(feedback: Feedback) -> bytes:
    """Content of a feedback frame, as a motor or its twin sends it.

    Raises:
        struct.error: where a value does not fit its field.
    """
    return _FEEDBACK.pack(*feedback, 0)


def decode_feedback(data: bytes) -> Feedback | None:
    """Content of a feedback frame of 8 bytes; None where it cannot come from a working motor.

    Such is an angle beyond the encoder's last step, a speed over `SPEED_PLAUSIBLE_RPM` or a temperature over
    `TEMPERATURE_PLAUSIBLE`.
    """
    angle, speed, current, temperature, _ = _FEEDBACK.unpack(data)
    if angle >= STEPS or abs(speed) > SPEED_PLAUSIBLE_RPM or temperature > TEMPERATURE_PLAUSIBLE:
        return None
    return Feedback(angle, speed, current, temperature)
