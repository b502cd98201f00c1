"""Random and mutated frames into the motors and the board's parser: none moves a motor, none stops the loop.

Each case is one CAN frame for `GM6020Motors`, of any identifier, length and content, and one piece of a serial stream
for `BoardBus`: messages that are whole, mutated, or wrongly filled behind right checksums, and noise. What may not
happen ends the run: an error, anything written to bus or line, a state that another frame than sound feedback changed
(judged by code of its own), or a sound frame that is not read afterwards.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import resource
import sys
import time

from spiraltrunk.hardware.bus.board import BoardBus
from spiraltrunk.hardware.bus.board_frame import LONGEST, START, BoardMessage, encode_message
from spiraltrunk.hardware.bus.board_messages import BoardCommand, encode_frames
from spiraltrunk.hardware.bus.frame_bus import Frame, FrameBus
from spiraltrunk.hardware.clock import Clock
from spiraltrunk.hardware.motors.gm6020_motors import GM6020Motors

MOTOR_IDS = (1, 2, 7)
FEEDBACK_IDS = {0x205: 0, 0x206: 1, 0x20B: 2}
IDS = (*FEEDBACK_IDS, 0, 0x1FE, 0x1FF, 0x204, 0x207, 0x20C, 0x2FE, 0x7FF, 0x800, 0x1FFFFFFF)
BATCH = 20
"""Cases between two looks at the states."""

REST = [(0x1FE, bytes(8)), (0x2FE, bytes(8))]
"""What three motors at rest are sent."""


class StepClock(Clock):
    """One millisecond at each look."""

    def __init__(self) -> None:
        self.time = 0.0

    def now(self) -> float:
        """The next millisecond [s]."""
        self.time += 0.001
        return self.time

    def sleep_until(self, moment: float) -> None:
        """Not used."""


class OpenBus(FrameBus):
    """A bus that hands on whatever it is given, sound or not, and keeps what is sent."""

    def __init__(self) -> None:
        self.waiting: list[Frame] = []
        self.sent: list[Frame] = []
        self.flushes = 0

    def send(self, frame: Frame) -> None:
        """Keep it."""
        self.sent.append(frame)

    def flush(self) -> None:
        """Count it."""
        self.flushes += 1

    def receive(self) -> list[Frame]:
        """What waits."""
        frames, self.waiting = self.waiting, []
        return frames

    def close(self) -> None:
        """Nothing."""


class Line:
    """A serial port in memory."""

    def __init__(self) -> None:
        self.incoming, self.written = bytearray(), bytearray()

    @property
    def in_waiting(self) -> int:
        """Bytes that wait."""
        return len(self.incoming)

    def read(self, size: int) -> bytes:
        """The next bytes."""
        data = bytes(self.incoming[:size])
        del self.incoming[:size]
        return data

    def write(self, data: bytes) -> int:
        """Keep them."""
        self.written += data
        return len(data)

    def reset_output_buffer(self) -> None:
        """Nothing."""

    def close(self) -> None:
        """Nothing."""


def is_sound(frame: Frame) -> bool:
    """Whether a frame is feedback of one of the motors, by the manual's layout."""
    if frame.id not in FEEDBACK_IDS or len(frame.data) != 8:
        return False
    angle, speed = int.from_bytes(frame.data[:2], "big"), int.from_bytes(frame.data[2:4], "big", signed=True)
    return angle < 8192 and -960 <= speed <= 960 and frame.data[6] <= 150


def build_sound(draw: random.Random, identifier: int) -> Frame:
    """Feedback that a motor may send."""
    angle, speed = draw.randrange(8192), draw.randint(-960, 960)
    data = angle.to_bytes(2, "big") + speed.to_bytes(2, "big", signed=True) + draw.randbytes(2)
    return Frame(identifier, data + bytes([draw.randrange(151), draw.randrange(256)]))


def draw_frame(draw: random.Random, now: float) -> Frame:
    """A frame: sound, mutated, or of any identifier and content."""
    pool = draw.choices((tuple(FEEDBACK_IDS), IDS, range(0x20000000)), (6, 3, 1))[0]
    identifier = draw.choice(pool)
    kind = draw.randrange(4)
    if kind == 0:
        data = draw.randbytes(draw.choice((0, 1, 6, 7, 8, 8, 8, 9, 64)))
    elif kind == 1:
        data = bytes([draw.choice((0, 255))]) * draw.randrange(12)
    else:
        mutated = bytearray(build_sound(draw, identifier).data)
        for _ in range(draw.randrange(3)):
            mutated[draw.randrange(8)] = draw.randrange(256)
        data = bytes(mutated)
    return Frame(identifier, data, now)


def draw_stream(draw: random.Random) -> bytes:
    """A piece of the board's stream."""
    command = draw.choice(tuple(BoardCommand)) if draw.random() < 0.9 else draw.randrange(0x10000)
    if draw.random() < 0.5:
        frames = [build_sound(draw, draw.choice(IDS[:11])) for _ in range(draw.randrange(5))]
        data = bytearray(encode_frames(frame for frame in frames if frame.id <= 0xFFFF))
    else:
        data = bytearray(draw.randbytes(draw.choice((0, 2, 6, 11, 33, 40, LONGEST))))
    if data and draw.random() < 0.3:
        data[draw.randrange(len(data))] = draw.randrange(256)
    stream = bytearray(encode_message(BoardMessage(command, bytes(data), draw.randrange(256))))
    kind, at = draw.randrange(8), draw.randrange(len(stream))
    if kind == 0:
        stream[at] ^= 1 << draw.randrange(8)
    elif kind == 1:
        del stream[at:]
    elif kind == 2:
        del stream[:at]
    elif kind == 3:
        stream[at:at] = draw.randbytes(draw.randrange(20))
    elif kind == 4:
        stream[at:at] = bytes([START]) * draw.randrange(1, 9)
    elif kind == 5:
        stream = bytearray(draw.randbytes(draw.randrange(60)))
    return bytes(stream)


def require(holds: bool, what: str) -> None:
    """End the run where a claim does not hold."""
    if not holds:
        raise AssertionError(what)


class CanBench:
    """Motors on a bus that hands on anything."""

    def __init__(self, draw: random.Random) -> None:
        self.draw, self.clock, self.bus = draw, StepClock(), OpenBus()
        self.motors = GM6020Motors(self.bus, motor_ids=MOTOR_IDS)
        self.last: list[Frame | None] = [None, None, None]
        self.steps = [0, 0, 0]
        self.sound = self.given = 0

    def step(self) -> None:
        """Give a batch of frames, and look at the states."""
        frames = [draw_frame(self.draw, self.clock.now()) for _ in range(BATCH)]
        self.bus.waiting = list(frames)
        for frame in frames:
            if is_sound(frame):
                self.keep(FEEDBACK_IDS[frame.id], frame)
        self.given += BATCH
        states, counts = self.motors.read(), self.motors.counts
        require(not self.bus.sent and not self.bus.flushes, "a frame made the motors send")
        refused = counts.unknown + counts.malformed + counts.implausible
        require((counts.accepted, refused) == (self.sound, self.given - self.sound), f"counts are {counts}")
        for state, frame, steps in zip(states, self.last, self.steps, strict=True):
            require((state is None) == (frame is None), "a motor is known that never answered, or the reverse")
            if state is not None and frame is not None:
                speed = int.from_bytes(frame.data[2:4], "big", signed=True) * 2 * math.pi / 60
                is_same = (state.time, state.temperature) == (frame.time, frame.data[6])
                is_same &= abs(state.speed - speed) < 1e-9 and abs(state.angle - steps * 2 * math.pi / 8192) < 1e-6
                require(is_same, f"{state} is not what {frame} told")

    def keep(self, motor: int, frame: Frame) -> None:
        """Take note of sound feedback, and of the angle by the shortest way."""
        before, self.last[motor] = self.last[motor], frame
        self.sound += 1
        if before is not None:
            change = (int.from_bytes(frame.data[:2], "big") - int.from_bytes(before.data[:2], "big")) % 8192
            self.steps[motor] += change if change < 4096 else change - 8192

    def finish(self) -> None:
        """The motors still take a command."""
        self.motors.send([0.0, 0.0, 0.0])
        require([frame[:2] for frame in self.bus.sent] == REST and self.bus.flushes == 1, "no command after the frames")
        self.bus.sent.clear()
        self.bus.flushes = 0


class BoardBench:
    """The board's driver on a line that carries anything."""

    def __init__(self, draw: random.Random) -> None:
        self.draw, self.line = draw, Line()
        self.board = BoardBus(self.line, StepClock())
        self.frames = 0

    def step(self) -> None:
        """Give a batch of pieces, and look at what is believed."""
        for _ in range(BATCH):
            self.line.incoming += draw_stream(self.draw)
        while self.line.incoming:
            for frame in self.board.receive():
                require(0 <= frame.id <= 0x7FF and len(frame.data) <= 8, f"{frame} came out of the board")
                self.frames += 1
        require(not self.line.written, "a message made the board send")

    def finish(self) -> None:
        """A sound message is still read, once the longest frame that noise may promise has ended."""
        frame = build_sound(self.draw, 0x205)
        message = BoardMessage(BoardCommand.RECEIVED_FRAMES, encode_frames([frame]))
        self.line.incoming += bytes(LONGEST + 16) + encode_message(message)
        found = [each[:2] for each in self.board.receive()]
        require(frame[:2] in found, "a sound message was not read after the noise")


def run(count: int, seconds: float, seed: int) -> dict[str, float]:
    """Give so many frames to the motors and so many pieces to the board, or fewer when the time is over.

    Raises:
        AssertionError: with what may not happen, and the case.
    """
    draw, began, done = random.Random(seed), time.perf_counter(), 0
    can, board = CanBench(draw), BoardBench(draw)
    while done < count and time.perf_counter() - began < seconds:
        try:
            can.step()
            board.step()
            if done % 1000 == 0:
                can.finish()
                board.finish()
        except BaseException:
            print(f"between case {done} and {done + BATCH} of seed {seed}", file=sys.stderr)
            raise
        done += BATCH
        if done % 100_000 == 0:
            print(f"{done} cases, {done / (time.perf_counter() - began):.0f}/s", file=sys.stderr)
    can.finish()
    board.finish()
    counts, believed = can.motors.counts, board.board.counts
    return {
        "can_frames": done,
        "can_accepted": counts.accepted,
        "can_unknown": counts.unknown,
        "can_malformed": counts.malformed,
        "can_implausible": counts.implausible,
        "board_pieces": done,
        "board_frames": board.frames,
        "board_broken": believed.broken,
        "board_unknown": believed.unknown,
        "board_malformed": believed.malformed,
        "seconds": round(time.perf_counter() - began, 1),
        "memory_mb": round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, 1),
    }


def main() -> int:
    """Run and print the figures as JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=1_000_000, help="frames, and pieces (default 1000000)")
    parser.add_argument("--seconds", type=float, default=1e9, help="time after which it ends (default: none)")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    print(json.dumps(run(arguments.count, arguments.seconds, arguments.seed), indent=2))
    return 0


if __name__ == "__main__":
    sys.exit(main())
