"""The development board: motors and servo over one line, its watchdog, and lines that fail."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest
import serial

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.bus.board import BAUD_RATE, BoardBus, BoardCounts, open_board
from spiraltrunk.hardware.bus.board_frame import BoardMessage, MessageParser, encode_message
from spiraltrunk.hardware.bus.board_messages import BoardCommand, decode_frames, decode_pulse, encode_frames
from spiraltrunk.hardware.bus.frame_bus import Frame
from spiraltrunk.hardware.clock import Clock
from spiraltrunk.hardware.motors.gm6020 import Feedback, decode_command, encode_feedback
from spiraltrunk.hardware.motors.gm6020_motors import GM6020Motors
from spiraltrunk.hardware.motors.pwm_servo import PwmServo, ServoCalibration
from spiraltrunk.hardware.twin.servo import RecordingServo

CALIBRATION = ServoCalibration(least_us=900, most_us=2100, open_us=1900, slack_us=1500, closed_us=1000)


class StepClock(Clock):
    """Time that the test sets."""

    time = 10.0

    def now(self) -> float:
        return self.time

    def sleep_until(self, moment: float) -> None:
        self.time = moment


class Line:
    """A port of pyserial in memory; ``failure`` is what its next use raises."""

    def __init__(self) -> None:
        self.written, self.incoming = b"", b""
        self.failure: Exception | None = None
        self.takes = 1 << 20
        self.discarded = self.writes = 0

    @property
    def in_waiting(self) -> int:
        self._fail()
        return len(self.incoming)

    def read(self, size: int) -> bytes:
        self._fail()
        data, self.incoming = self.incoming[:size], self.incoming[size:]
        return data

    def write(self, data: bytes) -> int:
        self._fail()
        self.writes += 1
        self.written += data[: self.takes]
        return min(len(data), self.takes)

    def reset_output_buffer(self) -> None:
        self.discarded += 1

    def close(self) -> None:
        pass

    def _fail(self) -> None:
        if self.failure is not None:
            raise self.failure


class Bench:
    """A board's line, seen from the board."""

    def __init__(self) -> None:
        self.clock, self.line = StepClock(), Line()
        self.board = BoardBus(self.line, self.clock)
        self.parser, self.number = MessageParser(), 0

    def heard(self) -> list[BoardMessage]:
        """Messages that the board has got since the last call."""
        data, self.line.written = self.line.written, b""
        return self.parser.feed(data)

    def contents(self, command: BoardCommand) -> list[bytes]:
        return [message.data for message in self.heard() if message.command == command]

    def tell(self, command: int, data: bytes, skip: int = 1) -> None:
        self.number += skip
        self.line.incoming += encode_message(BoardMessage(command, data, self.number % 256))


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_motors_over_the_board(bench):
    motors = GM6020Motors(bench.board, motor_ids=(1, 2, 3))
    motors.send([2.223, 0.0, -2.223])
    [data] = bench.contents(BoardCommand.SEND_FRAMES)
    [frame] = decode_frames(data, 0.0)
    assert (frame.id, decode_command(frame.data)) == (0x1FE, (16384, 0, -16384, 0))
    answers = [Frame(0x205 + i, encode_feedback(Feedback(100 * i, 0, 0, 30 + i))) for i in range(3)]
    bench.tell(BoardCommand.RECEIVED_FRAMES, encode_frames(answers))
    assert [(state.time, state.temperature) for state in motors.read()] == [(10.0, 30.0), (10.0, 31.0), (10.0, 32.0)]


def test_a_flush_is_one_write_with_commands_heartbeat_and_pulse(bench):
    PwmServo(bench.board, CALIBRATION).set_pulse(1500)
    for identifier in (0x1FE, 0x7A0):
        bench.board.send(Frame(identifier, b"x"))
    bench.board.flush()
    assert bench.line.writes == 1
    frames, pulse = bench.heard()
    assert [frame.id for frame in decode_frames(frames.data, 0.0)] == [0x1FE, 0x7A0]
    assert decode_pulse(pulse.data) == 1500
    assert [frames.sequence, pulse.sequence] == [1, 2]


def test_a_flush_of_nothing_writes_nothing(bench):
    bench.board.flush()
    assert bench.line.writes == 0


def test_garbage_and_foreign_messages_are_counted_and_change_nothing(bench):
    bench.tell(BoardCommand.RECEIVED_FRAMES, encode_frames([Frame(0x205, b"ok")]))
    bench.line.incoming += b"\xa5\x00garbage"
    bench.tell(0x1234, b"what")
    bench.tell(BoardCommand.SEND_FRAMES, encode_frames([Frame(0x206, b"echo")]))
    bench.tell(BoardCommand.RECEIVED_FRAMES, b"short")
    bench.tell(BoardCommand.RECEIVED_FRAMES, encode_frames([Frame(0x207, b"ok")]), skip=4)
    assert [frame.id for frame in bench.board.receive()] == [0x205, 0x207]
    assert bench.board.counts == BoardCounts(skipped_bytes=9, broken=1, unknown=2, malformed=1, missing=3)
    bench.board.flush()
    assert bench.heard() == []


@pytest.mark.parametrize("failure", [serial.SerialException("unplugged"), OSError(5, "I/O error")])
def test_a_line_that_is_gone_is_an_error_and_nothing_is_sent_when_it_returns(bench, failure):
    PwmServo(bench.board, CALIBRATION).set_pulse(1500)
    bench.board.send(Frame(0x1FE, b"stale"))
    bench.line.failure = failure
    with pytest.raises(DriveError, match=r"does not answer: .*; check cable and power"):
        bench.board.flush()
    with pytest.raises(DriveError, match="does not answer"):
        bench.board.receive()
    assert bench.line.discarded == 1
    bench.line.failure = None
    bench.board.flush()
    assert bench.heard() == []


def test_a_line_that_is_full_is_an_error_and_what_it_held_is_discarded(bench):
    bench.line.takes = 3
    bench.board.send(Frame(0x1FE, bytes(8)))
    with pytest.raises(DriveError, match="takes no more"):
        bench.board.flush()
    assert bench.line.discarded == 1


def test_the_servo_follows_and_is_repeated_at_its_own_rate(bench):
    servo, pulses = PwmServo(bench.board, CALIBRATION), []
    for i in range(64):
        bench.clock.time = i / 1024
        if i in (0, 5):
            servo.set_pulse(1500.4 if i == 0 else 1800)
        if i == 50:
            servo.release()
        bench.board.flush()
        pulses += [(i, decode_pulse(data)) for data in bench.contents(BoardCommand.SERVO_PULSE)]
    assert pulses == [(0, 1500), (5, 1800), (26, 1800), (47, 1800), (50, 0)]


@pytest.mark.parametrize("servo", ["board", "recording"])
@pytest.mark.parametrize("pulse", [899.9, 2100.1, float("nan"), float("inf"), -1, 0, "1500", None])
def test_a_pulse_outside_its_limits_is_refused_and_not_sent(bench, servo, pulse):
    servos = {"board": PwmServo(bench.board, CALIBRATION), "recording": RecordingServo(bench.clock, CALIBRATION)}
    with pytest.raises(DriveError, match="allowed: a finite number from 900 to 2100 us"):
        servos[servo].set_pulse(pulse)
    bench.board.flush()
    assert bench.contents(BoardCommand.SERVO_PULSE) == []
    assert servos["recording"].changes == []


@pytest.mark.parametrize("pulse", [-1, 65536, 1500.0, True])
def test_the_board_takes_whole_pulses_only(bench, pulse):
    with pytest.raises(DriveError, match="whole number"):
        bench.board.set_servo_pulse(pulse)


def test_a_slow_line_carries_three_motors_at_200_hz_and_not_at_500():
    """Each tick carries a heartbeat and its answer, too. The line is full with feedback sooner than with commands."""
    command, feedback = (
        len(encode_message(BoardMessage(BoardCommand.SEND_FRAMES, encode_frames([Frame(1, bytes(8))] * count))))
        for count in (2, 4)
    )
    line = BAUD_RATE / 10
    assert 200 * command < 200 * feedback < line < 500 * command < 500 * feedback


@pytest.fixture
def loop() -> Iterator[BoardBus]:
    board = open_board("loop://", StepClock())
    yield board
    board.close()


def test_a_line_that_returns_what_was_sent_gives_no_feedback(loop):
    loop.send(Frame(0x205, bytes(8)))
    loop.flush()
    assert loop.receive() == []
    assert loop.counts.unknown == 1


def test_a_pseudo_terminal_that_hangs_up_is_an_error():
    pty = pytest.importorskip("pty", reason="a pseudo-terminal needs POSIX")
    device, host = pty.openpty()
    board = open_board(os.ttyname(host), StepClock())
    os.close(host)
    os.close(device)
    with pytest.raises(DriveError, match="does not answer"):
        board.receive()
    board.send(Frame(0x1FE, bytes(8)))
    with pytest.raises(DriveError, match="does not answer"):
        board.flush()
    board.close()


@pytest.mark.parametrize("port", ["", "/dev/no-such-port", "nothing://x", "loop://?what=1"])
def test_a_port_that_cannot_be_opened_is_one_line(port):
    with pytest.raises(DriveError, match=r"cannot be opened: .*; check name") as error:
        open_board(port, StepClock())
    assert "\n" not in str(error.value)
