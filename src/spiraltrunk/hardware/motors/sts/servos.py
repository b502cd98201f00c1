"""Feetech STS bus servos as motors of the winders, in their mode of duty cycles.

Nothing here was tried on a real servo. What the protocol implies:

- **Torque is an estimate.** The servo measures none. A commanded torque becomes a duty cycle by
  `models.compute_duty`, and the reported one is `models.estimate_torque` of the load that the servo states. The
  friction of gears of 1:345 hides much of a cable's tension: calibrate, and use a load cell (`load_cell`) where tension
  matters.
- **A servo holds the last duty cycle** when commands stop: no timeout of commands is known. Only a relay in its supply
  stops it when the computer dies.
- **The mode is written with the lock set,** so that it is forgotten at power-off (Feetech's memory table; unconfirmed).
  After a power cycle a servo is limp, since it is switched on once, at the start, and never again.

Period: at 1 Mbit/s a byte takes 10 us. With three servos a command takes 17 bytes, a request 11 and the answers 3 * 14
to 3 * 21 (see `request_times`), together up to 0.9 ms, and 1.5 ms more where each servo waits 0.5 ms before it answers
(setting as delivered; unconfirmed). USB adapters add 1 to 16 ms. Hence 10 ms (ours): `send` also requests the feedback,
which the next `read` collects.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self, final

from spiraltrunk.checks import check_count, check_text, check_type
from spiraltrunk.errors import DesignError, DriveError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.clock import Clock
from spiraltrunk.hardware.motors.gm6020_motors import check_torques
from spiraltrunk.hardware.motors.motor_port import MotorPort, MotorState
from spiraltrunk.hardware.motors.serial_port import SerialStream
from spiraltrunk.hardware.motors.sts import codec
from spiraltrunk.hardware.motors.sts.line import StsLine
from spiraltrunk.hardware.motors.sts.models import MODELS, VOLTAGE_LEAST, compute_duty, estimate_torque
from spiraltrunk.hardware.motors.sts.request_times import RequestTimes
from spiraltrunk.hardware.motors.turn_count import TurnCount


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class StsSettings:
    """Where the servos are. A motor has an index in the order of the cables; a servo has an id on the bus."""

    port: str
    """Serial port, such as /dev/ttyACM0, /dev/cu.usbmodem1 or COM3; there is no default."""
    servo_ids: tuple[int, ...]
    """Id on the bus of each motor's servo, in the order of the design's cables."""
    directions: tuple[int, ...]
    """1 where a rising position winds the cable in, -1 where it pays out, per motor."""
    model: str = "sts3215-12v"
    """Name in `MODELS`."""

    def __post_init__(self) -> None:
        check_text("port", self.port)
        check_type("servo_ids", self.servo_ids, tuple)
        check_type("directions", self.directions, tuple)
        for i, servo_id in enumerate(self.servo_ids):
            check_count(f"servo_ids[{i}]", servo_id, least=0, most=codec.ID_MAX)
        if not self.servo_ids or len(set(self.servo_ids)) < len(self.servo_ids):
            raise DesignError("servo_ids", got=self.servo_ids, allowed="one id per motor, no id twice")
        if len(self.directions) != len(self.servo_ids) or not set(self.directions) <= {-1, 1}:
            raise DesignError("directions", got=self.directions, allowed=f"{len(self.servo_ids)} numbers, each 1 or -1")
        if self.model not in MODELS:
            raise DesignError("model", got=self.model, allowed=" or ".join(MODELS))


@final
class StsServos(MotorPort):
    """STS servos on one serial line."""

    def __init__(self, settings: StsSettings, line: StsLine, clock: Clock) -> None:
        """Use servos that are ready; `from_settings` makes them so."""
        self.settings = settings
        self._model = MODELS[settings.model]
        self.data_sheet = self._model.data_sheet
        self.n_motor = len(settings.servo_ids)
        self._line = line
        self._clock = clock
        self._received = bytearray()
        self._states: list[MotorState | None] = [None] * self.n_motor
        self._counts = [TurnCount(codec.STEPS, self.data_sheet.silence_max) for _ in settings.servo_ids]
        self._requests = RequestTimes()
        self._is_closed = False
        self._command = self._build_command()

    @classmethod
    def from_settings(cls, settings: StsSettings, clock: Clock, *, stream: SerialStream | None = None) -> Self:
        """Open the port, check every servo, and switch them on with a duty cycle of zero; waits for their answers.

        Args:
            settings: the servos.
            clock: time of their feedback.
            stream: used instead of the port where it is given, as by a twin in memory.

        Raises:
            DriveError: where the port cannot be opened, or a servo is absent, of another model or at another voltage.
            MissingPackage: without pyserial or the SDK.
        """
        line = StsLine(settings.port, stream=stream)
        try:
            for motor in range(len(settings.servo_ids)):
                _check_servo(line, settings, motor)
            for servo_id in settings.servo_ids:
                _switch_on(line, servo_id)
            return cls(settings, line, clock)
        except BaseException:
            line.close()
            raise

    def read(self) -> tuple[MotorState | None, ...]:
        """See `MotorPort`. A feedback's time is that of its request, which is older than its measurement.

        Where nothing is sent for two periods, the feedback is requested here; a request at each call would collide
        on the one wire with the command that follows.
        """
        self._check_open()
        self._collect()
        if self._clock.now() - self._requests.latest >= 2.0 * self.data_sheet.period:
            self._ask()
        return tuple(self._states)

    def send(self, torques: Sequence[float]) -> None:
        """See `MotorPort`."""
        self._check_open()
        duties = self._encode(torques)
        self._collect()
        for servo_id, duty in zip(self.settings.servo_ids, duties, strict=True):
            self._command.changeParam(servo_id, duty)
        self._transmit(self._command)
        self._ask()

    def restart_count(self) -> None:
        """See `MotorPort`."""
        for motor, count in enumerate(self._counts):
            count.restart()
            if (state := self._states[motor]) is not None:
                self._states[motor] = replace(state, is_count_lost=False)

    def close(self) -> None:
        """See `MotorPort`: a duty cycle of zero to all, then each motor off, which it confirms.

        The first may be lost, where answers are still under way on the one wire. Waits 0.2 s for each servo that does
        not answer.
        """
        if self._is_closed:
            return
        self._is_closed = True
        for motor, servo_id in enumerate(self.settings.servo_ids):
            with contextlib.suppress(DriveError):  # It or the bus no longer works.
                if motor == 0:
                    self._write_all(codec.GOAL_DUTY, [0, 0])
                self._line.write_register(servo_id, codec.TORQUE_ENABLE, 0)
        self._line.close()

    def _encode(self, torques: Sequence[float]) -> list[list[int]]:
        limit = self.data_sheet.torque_max
        check_torques(torques, self.n_motor, limit)
        return [codec.encode_duty(self._compute_duty(motor, float(torque))) for motor, torque in enumerate(torques)]

    def _compute_duty(self, motor: int, torque: float) -> float:
        """Duty cycle in the servo's direction; without compensation for a torque of zero, which is to brake."""
        state, direction = self._states[motor], self.settings.directions[motor]
        fresh = self._clock.now() - 3.0 * self.data_sheet.period
        if torque == 0.0 or state is None or state.time < fresh or not state.voltage:
            return direction * torque / self.data_sheet.torque_max
        voltage = max(state.voltage, VOLTAGE_LEAST * self._model.voltage)
        return direction * compute_duty(self._model, torque, state.speed, voltage)

    def _collect(self) -> None:
        """Take in what has arrived."""
        while received := self._line.receive():
            self._received += received
        if math.isinf(self._requests.latest):  # Left from the start: nothing was asked yet.
            self._received.clear()
        for packet in codec.take_packets(self._received, longest=codec.FEEDBACK_SIZE_MOST):
            self._take_in(packet)

    def _take_in(self, packet: codec.Packet) -> None:
        """The feedback in a packet, where it answers a request that is open."""
        if packet.servo_id not in self.settings.servo_ids:
            return
        feedback = codec.decode_feedback(packet.data[: codec.FEEDBACK_SIZE])
        if feedback is None:
            return
        time = self._requests.take(packet.servo_id, len(packet.data), self._clock.now())
        if time is not None:
            motor = self.settings.servo_ids.index(packet.servo_id)
            problem = codec.describe_errors(packet.code)
            self._states[motor] = replace(self._build_state(motor, feedback, time), problem=problem)

    def _build_state(self, motor: int, feedback: codec.Feedback, time: float) -> MotorState:
        direction = self.settings.directions[motor]
        count = self._counts[motor]
        steps = count.update(feedback.position, time)
        speed = direction * feedback.speed * codec.STEP
        return MotorState(
            time=time,
            angle=direction * steps * codec.STEP,
            speed=speed,
            torque=estimate_torque(self._model, direction * feedback.load / codec.DUTY_MAX, speed, feedback.voltage),
            temperature=feedback.temperature,
            voltage=feedback.voltage,
            is_count_lost=count.is_lost,
        )

    def _ask(self) -> None:
        """Request the feedback of all servos, unless earlier answers are in doubt."""
        now = self._clock.now()
        size = self._requests.find_size(now)
        if size is None:
            return
        request = self._line.sdk.GroupSyncRead(self._line, self._line.handler, codec.FEEDBACK, size)
        for servo_id in self.settings.servo_ids:
            request.addParam(servo_id)
        self._transmit(request)
        self._requests.add(now)

    def _transmit(self, group: Any) -> None:
        self._line.is_using = False  # The SDK holds the line until it has read answers, and after an error for ever.
        result = group.txPacket()
        self._line.is_using = False
        if result != self._line.sdk.COMM_SUCCESS:
            raise DriveError(f"serial port {self.settings.port}: {self._line.handler.getTxRxResult(result)}")

    def _build_command(self) -> Any:
        command = self._line.sdk.GroupSyncWrite(self._line, self._line.handler, codec.GOAL_DUTY, 2)
        for servo_id in self.settings.servo_ids:
            command.addParam(servo_id, [0, 0])
        return command

    def _write_all(self, register: int, data: list[int]) -> None:
        group = self._line.sdk.GroupSyncWrite(self._line, self._line.handler, register, len(data))
        for servo_id in self.settings.servo_ids:
            group.addParam(servo_id, data)
        self._transmit(group)

    def _check_open(self) -> None:
        if self._is_closed:
            raise DriveError(f"the servos on {self.settings.port} are closed")


def _check_servo(line: StsLine, settings: StsSettings, motor: int) -> None:
    """Refuse a servo that is absent, of another model, or whose supply does not fit the variant."""
    model, servo_id = MODELS[settings.model], settings.servo_ids[motor]
    number = line.ping(servo_id)
    which = f"motor {motor} (servo id {servo_id})"
    if number is None:
        raise DriveError(f"{which} on {settings.port} does not answer; check its power, wiring and id")
    if number != model.number:
        raise DriveError(f"{which} is model number {number}; allowed: {model.number} ({settings.model})")
    feedback = codec.decode_feedback(line.read_register(servo_id, codec.FEEDBACK, codec.FEEDBACK_SIZE))
    least, most = model.voltage_range
    if feedback is None or not least <= feedback.voltage <= most:
        seen = "no plausible feedback" if feedback is None else f"{feedback.voltage:.1f} V"
        raise DriveError(f"{which} has {seen}; allowed: {least:.1f} to {most:.1f} V")


def _switch_on(line: StsLine, servo_id: int) -> None:
    """Set the mode of duty cycles, with zero, and switch the motor on; each step is confirmed before the next."""
    line.write_register(servo_id, codec.TORQUE_ENABLE, 0)
    line.write_register(servo_id, codec.LOCK, 1)
    line.write_register(servo_id, codec.MODE, codec.MODE_PWM)
    for register in (codec.GOAL_DUTY, codec.GOAL_DUTY + 1):
        line.write_register(servo_id, register, 0)
    line.write_register(servo_id, codec.TORQUE_ENABLE, 1)
