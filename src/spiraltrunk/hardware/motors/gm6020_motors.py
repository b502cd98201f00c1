"""GM6020 motors of one robot in current mode, over any bus that carries CAN frames. Never tried on a real motor."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from spiraltrunk.errors import DriveError, describe
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.bus.frame_bus import Frame, FrameBus
from spiraltrunk.hardware.motors.gm6020 import (
    ANGLE_PER_STEP,
    GM6020,
    SPEED_PER_RPM,
    STEPS,
    TORQUE_PER_RAW,
    CommandMode,
    Feedback,
    check_motor_ids,
    compute_command_id,
    compute_feedback_id,
    compute_slot,
    decode_feedback,
    encode_command,
)
from spiraltrunk.hardware.motors.motor_port import MotorPort, MotorState
from spiraltrunk.hardware.motors.turn_count import TurnCount


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class FrameCounts:
    """Frames since the start that were received, by what became of them."""

    accepted: int
    """Feedback of one of the motors [-]."""
    unknown: int
    """Identifier of no motor's feedback; ignored [-]."""
    malformed: int
    """Feedback whose length is not 8 bytes; ignored [-]."""
    implausible: int
    """Feedback that no working motor sends, see `gm6020.decode_feedback`; ignored [-]."""


@final
class _Motor:
    """Latest feedback of one motor, and its count of turns."""

    __slots__ = ("feedback", "n_frame", "sign", "state", "time", "turns")

    def __init__(self, sign: int) -> None:
        self.sign = sign
        self.turns = TurnCount(STEPS, GM6020.silence_max)
        self.time = 0.0
        self.n_frame = 0
        self.feedback: Feedback | None = None
        self.state: MotorState | None = None

    def build_state(self) -> MotorState | None:
        """State from the latest feedback, in the sense in which the cable is wound in."""
        feedback, sign = self.feedback, self.sign
        if self.state is None and feedback is not None:
            self.state = MotorState(
                time=self.time,
                angle=sign * self.turns.steps * ANGLE_PER_STEP,
                speed=sign * feedback.speed_rpm * SPEED_PER_RPM,
                torque=sign * feedback.current * TORQUE_PER_RAW,
                temperature=float(feedback.temperature),
                is_count_lost=self.turns.is_lost,
                n_frame=self.n_frame,
            )
        return self.state


@final
class GM6020Motors(MotorPort):
    """One GM6020 per cable. Opening it sends nothing; only `send` and `close` do.

    What a GM6020 does when commands stop is not established: assume that it holds the last one, so that only a watchdog
    (`bus.board`, or a relay in the motors' supply) makes a host that dies harmless.
    """

    def __init__(self, bus: FrameBus, *, motor_ids: Sequence[int], directions: Sequence[int] | None = None) -> None:
        """Motors on a bus that is open already.

        Args:
            bus: the bus; `close` closes it.
            motor_ids: id on each motor's switches, in the order of the cables.
            directions: 1 where the motor's positive sense winds the cable in, -1 where it pays it out; 1 for all by
                default.

        Raises:
            DriveError: where the ids are out of range or not unique, or the directions do not fit them.
        """
        check_motor_ids(motor_ids)
        signs = [1] * len(motor_ids) if directions is None else list(directions)
        if len(signs) != len(motor_ids) or not all(sign in (1, -1) for sign in signs):
            raise DriveError(f"directions are {describe(signs)}; allowed: 1 or -1 for each of {len(motor_ids)} motors")
        self.data_sheet = GM6020
        self.n_motor = len(motor_ids)
        self._bus = bus
        self._motors = [_Motor(sign) for sign in signs]
        self._by_feedback = dict(zip(map(compute_feedback_id, motor_ids), self._motors, strict=True))
        self._places = [(compute_command_id(i, CommandMode.CURRENT), compute_slot(i)) for i in motor_ids]
        self._accepted = self._unknown = self._malformed = self._implausible = 0
        self._is_closed = False

    @property
    def counts(self) -> FrameCounts:
        """Frames received so far, accepted and ignored."""
        return FrameCounts(
            accepted=self._accepted,
            unknown=self._unknown,
            malformed=self._malformed,
            implausible=self._implausible,
        )

    def read(self) -> tuple[MotorState | None, ...]:
        """See `MotorPort.read`. Frames that are not a motor's sound feedback change nothing but `counts`."""
        for frame in self._bus.receive():
            self._accept(frame)
        return tuple([motor.state or motor.build_state() for motor in self._motors])

    def _accept(self, frame: Frame) -> None:
        motor = self._by_feedback.get(frame.id)
        if motor is None:
            self._unknown += 1
        elif len(frame.data) != 8:
            self._malformed += 1
        elif (feedback := decode_feedback(frame.data)) is None:
            self._implausible += 1
        else:
            self._accepted += 1
            motor.n_frame += 1
            motor.turns.update(feedback.angle, frame.time)
            motor.feedback, motor.time, motor.state = feedback, frame.time, None

    def send(self, torques: Sequence[float]) -> None:
        """See `MotorPort.send`. Each torque is rounded to the motor's resolution, 0.14 mN m."""
        if self._is_closed:
            raise DriveError("the motors are closed; open them anew")
        check_torques(torques, self.n_motor, GM6020.torque_max)
        frames: dict[int, list[int]] = {}
        for (identifier, slot), motor, torque in zip(self._places, self._motors, torques, strict=True):
            frames.setdefault(identifier, [0, 0, 0, 0])[slot] = motor.sign * round(float(torque) / TORQUE_PER_RAW)
        for identifier, values in frames.items():
            self._bus.send(Frame(identifier, encode_command(values, CommandMode.CURRENT)))
        self._bus.flush()

    def restart_count(self) -> None:
        """See `MotorPort.restart_count`. Angles go on from their present values, without a jump."""
        for motor in self._motors:
            motor.turns.restart()
            motor.state = None

    def close(self) -> None:
        """See `MotorPort.close`."""
        if self._is_closed:
            return
        with contextlib.suppress(DriveError):  # A bus that is gone sends no zeros, either.
            self.send([0.0] * self.n_motor)
        self._is_closed = True
        self._bus.close()


def check_torques(torques: Sequence[float], count: int, torque_max: float) -> None:
    """Refuse torques before any of them is sent, and before any is clamped.

    Raises:
        DriveError: where their number is not ``count``, or one is not a finite number of at most ``torque_max`` [N m]
            in either sense.
    """
    if len(torques) != count:
        raise DriveError(f"{len(torques)} torques are given; allowed: {count}, one for each motor")
    for i, torque in enumerate(torques):
        try:
            is_allowed = math.isfinite(torque) and -torque_max <= torque <= torque_max
        except (TypeError, ValueError, OverflowError):
            is_allowed = False
        if not is_allowed:
            allowed = f"a finite number from {-torque_max:g} to {torque_max:g} N m"
            raise DriveError(f"torque of cable {i} is {describe(torque)}; allowed: {allowed}")
