"""Twin of one STS servo: registers, motor, and what it answers."""

from __future__ import annotations

import math
from typing import final

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.motors.sts import codec
from spiraltrunk.hardware.motors.sts.models import KGF_CM
from spiraltrunk.hardware.twin.motor import MotorParameters, MotorTwin

STALL_CURRENT = 2.7
"""Current at stall with 12 V [A] (manufacturer; unconfirmed)."""
STS3215 = MotorParameters(
    rotor_inertia=2.4e-3,
    friction=0.15,
    torque_constant=30.0 * KGF_CM / STALL_CURRENT,
    current_max=1.2 * STALL_CURRENT,
    supply=12.0,
    speed_free=2.0 * 45.0 * math.tau / 60.0,
    resistance=12.0 / STALL_CURRENT,
    encoder_counts=codec.STEPS,
    drum_radius=0.0125,
)
"""An STS3215 for 12 V: stall torque 30 kgf cm and 45 rpm (manufacturer; `speed_free` is that at 24 V, twice as high).
Inertia, friction of the gears and drum are ours; the cable is that of every winder."""

_MODEL = 3
_ID = 5
_TEMPERATURE_MAX = 13
_GOAL_POSITION = 42
_N_REGISTER = 87
_N_PERMANENT = 40
_GAIN = 10.0
"""Duty cycle per position error in the mode of positions [0.1 % per step] (ours)."""

_PING, _READ, _WRITE = 1, 2, 3


@final
class ServoTwin:
    """One servo. As delivered it is in the mode of positions, and switched off after each start."""

    def __init__(self, servo_id: int, parameters: MotorParameters = STS3215) -> None:
        """A servo at rest.

        Args:
            servo_id: id on the bus.
            parameters: numbers of its motor; reversed where a rising position pays the cable out.
        """
        self.motor = MotorTwin(parameters)
        self.is_frozen = False
        """Whether the feedback repeats what it was when this was set."""
        self._permanent = bytearray(_N_PERMANENT)
        self._permanent[_MODEL : _MODEL + 2] = (777).to_bytes(2, "little")
        self._permanent[_ID] = servo_id
        self._permanent[_TEMPERATURE_MAX] = 70
        self._registers = bytearray()
        self._start()
        self._last = self._measure()

    @property
    def id(self) -> int:
        """Id on the bus."""
        return self._registers[_ID]

    @id.setter
    def id(self, servo_id: int) -> None:
        self._permanent[_ID] = self._registers[_ID] = servo_id

    @property
    def mode(self) -> int:
        """Operating mode."""
        return self._registers[codec.MODE]

    @property
    def is_on(self) -> bool:
        """Whether the motor has its supply, is switched on and not overheated."""
        return self.motor.is_on and self._registers[codec.TORQUE_ENABLE] == 1 and not self.errors & 4

    @property
    def duty(self) -> int:
        """Duty cycle at which the motor is driven, in the servo's direction [0.1 %]."""
        if not self.is_on:
            return 0
        if self.mode == codec.MODE_PWM:
            goal = codec.decode_signed(self._read_word(codec.GOAL_DUTY), codec.LOAD_SIGN)
        elif self.mode == 0:
            goal = round(_GAIN * (self._read_word(_GOAL_POSITION) - self.motor.count))
        else:
            goal = 0
        return max(-codec.DUTY_MAX, min(codec.DUTY_MAX, goal))

    @property
    def errors(self) -> int:
        """Fault bits of its answers."""
        return 4 if self.motor.temperature > self._registers[_TEMPERATURE_MAX] else 0

    def freeze(self, is_frozen: bool) -> None:
        """Repeat the present feedback from now on, or no longer."""
        self._last = self._measure()
        self.is_frozen = is_frozen

    def advance(self, tension: float, dt: float) -> None:
        """Advance the motor by ``dt`` [s] under a cable's tension [N]; the duty cycle sets the winding's voltage."""
        p, motor = self.motor.parameters, self.motor
        if not motor.is_on:  # Without a supply only what is permanent is kept.
            self._start()
        if self.is_on:
            voltage = self._direction * self.duty / codec.DUTY_MAX * p.supply
            motor.command = (voltage - p.back_emf * motor.speed) / p.resistance
        else:
            motor.command = motor.current = 0.0
        motor.advance(tension, dt)

    def answer(self, packet: codec.Packet) -> bytes:
        """Answer to a request that is addressed to this servo; empty where it gives none."""
        data = b""
        if packet.code == _READ and len(packet.data) == 2:
            data = self.read(packet.data[0], packet.data[1])
        elif packet.code == _WRITE and packet.data:
            self.write(packet.data[0], packet.data[1:])
        elif packet.code != _PING:
            return b""
        return codec.encode_packet(codec.Packet(self.id, self.errors, data))

    def read(self, register: int, size: int) -> bytes:
        """Content of registers."""
        feedback = self._last if self.is_frozen else self._measure()
        self._registers[codec.FEEDBACK : codec.FEEDBACK + codec.FEEDBACK_SIZE] = codec.encode_feedback(feedback)
        return bytes(self._registers[register : register + size])

    def write(self, register: int, data: bytes) -> None:
        """Write registers; what is beyond them or only to be read is ignored."""
        for i, value in enumerate(data, register):
            if _ID <= i < codec.FEEDBACK:
                self._registers[i] = value
                if i < _N_PERMANENT and self._registers[codec.LOCK] == 0:
                    self._permanent[i] = value

    @property
    def _direction(self) -> int:
        return -1 if self.motor.parameters.is_reversed else 1

    def _start(self) -> None:
        self._registers = self._permanent + bytearray(_N_REGISTER - _N_PERMANENT)
        self._registers[codec.LOCK] = 1

    def _read_word(self, register: int) -> int:
        return int.from_bytes(self._registers[register : register + 2], "little")

    def _measure(self) -> codec.Feedback:
        speed = round(self._direction * self.motor.speed / codec.STEP)
        if abs(speed) >= 1 << codec.SPEED_SIGN:
            raise DriveError(f"twin of servo id {self.id} turns at {speed} steps/s: its simulation has diverged")
        voltage = self.motor.parameters.supply
        return codec.Feedback(self.motor.count, speed, self.duty, voltage, min(255.0, max(0.0, self.motor.temperature)))
