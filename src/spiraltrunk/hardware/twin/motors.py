"""GM6020 motors of a twin at their end of a bus."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from spiraltrunk.checks import check_number
from spiraltrunk.errors import DriveError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.bus.frame_bus import Frame, FrameBus
from spiraltrunk.hardware.motors.gm6020 import (
    CURRENT_MAX,
    CURRENT_RAW,
    SPEED_PER_RPM,
    CommandMode,
    Feedback,
    check_motor_ids,
    compute_command_id,
    compute_feedback_id,
    compute_slot,
    decode_command,
    encode_feedback,
)
from spiraltrunk.hardware.safety.watchdog import HEARTBEAT_ID
from spiraltrunk.hardware.twin.board import BoardTwin
from spiraltrunk.hardware.twin.cable_load import CableLoad
from spiraltrunk.hardware.twin.device import TwinDevice
from spiraltrunk.hardware.twin.load_cells import LoadCellTwin
from spiraltrunk.hardware.twin.motor import MotorTwin

_AMPERE = CURRENT_MAX / CURRENT_RAW
_ROUNDING = 1e-9


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class FeedbackNoise:
    """Normal noise of the last digit of the feedback, as standard deviations (ours: measured on no motor)."""

    encoder: float = 0.3
    """Of the angle in counts, before it is rounded [-]."""
    current: float = 1.0
    """Of the current in units of the feedback, 3 A / 16384, before it is rounded [-]."""

    def __post_init__(self) -> None:
        for name in ("encoder", "current"):
            check_number(f"noise.{name}", getattr(self, name), least=0.0, most=100.0)


NO_NOISE = FeedbackNoise(encoder=0.0, current=0.0)
"""Feedback that is rounded and exact."""


@final
class MotorTwins(TwinDevice):
    """Motors in current mode with their drums, and what their cables pull on.

    Each motor sends its feedback at a fixed rate and goes on with its last command when no further one comes: what a
    GM6020 does then is not established, so the worse is assumed. Commands that are not eight bytes, and frames that are
    no commands, are ignored; a current beyond the motor's is limited to it.
    """

    def __init__(
        self,
        bus: FrameBus,
        load: CableLoad,
        motors: Sequence[MotorTwin],
        *,
        motor_ids: Sequence[int] | None = None,
        feedback_period: float = 1e-3,
        board: BoardTwin | None = None,
        substeps: int = 1,
        noise: FeedbackNoise = NO_NOISE,
        seed: int = 0,
    ) -> None:
        """Motors at rest.

        Args:
            bus: the motors' end of the bus; a bus that is off neither brings nor takes frames.
            load: the other end of the cables.
            motors: one per cable.
            motor_ids: id of each, 1 upwards by default.
            feedback_period: time between two answers of a motor [s]; a GM6020's is 1 ms (unconfirmed).
            board: watchdog between bus and motors; None where none is fitted.
            substeps: parts of a step in which motors and load are integrated.
            noise: noise of the feedback.
            seed: its seed.
        """
        self.motors = tuple(motors)
        """One per cable."""
        self._ids = list(range(1, len(motors) + 1)) if motor_ids is None else list(motor_ids)
        check_motor_ids(self._ids)
        if len(self._ids) != len(self.motors):
            raise DriveError(f"{len(self._ids)} motor ids for {len(self.motors)} motors; allowed: one for each")
        check_number("feedback_period", feedback_period, least=1e-4, most=1.0)
        self._bus, self._load, self._board = bus, load, board
        self._period, self._substeps = feedback_period, substeps
        self._noise, self._random = noise, random.Random(seed)
        self._time, self._wait = 0.0, feedback_period
        self._commands = [0.0] * len(self.motors)
        self.tensions: Sequence[float] = [0.0] * len(self.motors)
        """Tension of each cable at its drum [N]."""
        self.cells: LoadCellTwin | None = None
        """Load cells at the cables, to which faults of cells happen; None without any."""
        self.n_answered = 0
        """Number of times that all motors sent their feedback."""
        self._address()

    @property
    def time(self) -> float:
        """Time since the twin was switched on [s]."""
        return self._time

    def swap_ids(self, first: int, second: int) -> None:
        """Exchange the ids of two motors, as a wrong switch does: both commands and feedback."""
        ids = self._ids
        ids[first], ids[second] = ids[second], ids[first]
        self._address()

    def forget(self, cable: int) -> None:
        """Forget the command of a motor, as it does when its supply is cut."""
        self._commands[cable] = 0.0

    def advance(self, dt: float) -> None:
        """Advance by ``dt`` [s]: commands, watchdog, dynamics, feedback."""
        self._time += dt
        self._receive()
        self._apply()
        motors, part = self.motors, dt / self._substeps
        for _ in range(self._substeps):
            tensions = self.tensions
            for motor, tension in zip(motors, tensions, strict=True):
                motor.advance(tension, part)
            wound, stiffness = [motor.wound for motor in motors], [motor.stiffness for motor in motors]
            self.tensions = self._load.advance(wound, stiffness, part)
        self._wait -= dt
        if self._wait <= _ROUNDING:
            self._wait += self._period
            self._answer()

    def _address(self) -> None:
        """Which part of which frame belongs to which motor."""
        self._slots: dict[int, list[tuple[int, int]]] = {}
        for cable, motor_id in enumerate(self._ids):
            identifier = compute_command_id(motor_id, CommandMode.CURRENT)
            self._slots.setdefault(identifier, []).append((cable, compute_slot(motor_id)))
        self._answers = [compute_feedback_id(motor_id) for motor_id in self._ids]

    def _receive(self) -> None:
        """Take over what arrived."""
        try:
            frames = self._bus.receive()
        except DriveError:
            return
        for frame in frames:
            slots = self._slots.get(frame.id)
            if slots is not None:
                values = decode_command(frame.data)
                if values is not None and (self._board is None or self._board.is_open):
                    for cable, slot in slots:
                        self._commands[cable] = self.motors[cable].direction * values[slot] * _AMPERE
            elif frame.id == HEARTBEAT_ID and self._board is not None:
                self._send([self._board.hear(frame.data, self._time)])

    def _apply(self) -> None:
        """Give each motor its command, as far as the watchdog lets it through."""
        share = 1.0 if self._board is None else self._board.compute_share(self._time)
        for motor, command in zip(self.motors, self._commands, strict=True):
            motor.command = share * command if motor.is_on else 0.0

    def _answer(self) -> None:
        """Send the feedback of every motor that is on."""
        self.n_answered += 1
        pairs = zip(self._answers, self.motors, strict=True)
        self._send([Frame(identifier, self._encode(motor)) for identifier, motor in pairs if motor.is_on])

    def _encode(self, motor: MotorTwin) -> bytes:
        """Content of a motor's feedback, with what its fields cannot hold limited to what they can."""
        sign, noise, gauss = motor.direction, self._noise, self._random.gauss
        speed = round(sign * motor.speed / SPEED_PER_RPM)
        current = round(sign * motor.current / _AMPERE + gauss(0.0, noise.current))
        return encode_feedback(
            Feedback(
                motor.read_count(gauss(0.0, noise.encoder)),
                min(max(speed, -32768), 32767),
                min(max(current, -32768), 32767),
                min(max(math.floor(motor.temperature + 0.5), 0), 255),
            )
        )

    def _send(self, frames: Sequence[Frame]) -> None:
        try:
            for frame in frames:
                self._bus.send(frame)
            self._bus.flush()
        except DriveError:
            return
