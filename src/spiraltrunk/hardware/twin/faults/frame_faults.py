"""Faults of the bus."""

from __future__ import annotations

import random
from dataclasses import dataclass
from typing import ClassVar, final

from spiraltrunk.checks import check_count, check_number
from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.bus.frame_bus import Frame
from spiraltrunk.hardware.bus.frame_queue import LARGEST_ID, LARGEST_LENGTH
from spiraltrunk.hardware.motors.gm6020 import compute_feedback_id
from spiraltrunk.hardware.twin.faults.frame_fault import Direction, FrameFault, FrameMemory, read_direction


@final
@dataclass(frozen=True, kw_only=True)
class FrameLoss(FrameFault):
    """Frames are lost, each with the same probability."""

    name: ClassVar[str] = "frame_loss"
    probability: float = 0.05
    """Part of the frames that is lost [-]."""
    direction: Direction = Direction.BOTH
    """Frames that it concerns."""

    def __post_init__(self) -> None:
        check_number("probability", self.probability, least=0.0, most=1.0)
        _set_direction(self)

    def change(self, frames: list[Frame], memory: FrameMemory, now: float) -> list[Frame]:
        """See `FrameFault.change`."""
        return [frame for frame in frames if memory.random.random() >= self.probability]


@final
@dataclass(frozen=True, kw_only=True)
class Delay(FrameFault):
    """Every frame arrives late, in order."""

    name: ClassVar[str] = "delay"
    duration: float = 0.01
    """Delay [s]."""
    direction: Direction = Direction.BOTH
    """Frames that it concerns."""

    def __post_init__(self) -> None:
        check_number("duration", self.duration, least=0.0, most=60.0)
        _set_direction(self)

    def change(self, frames: list[Frame], memory: FrameMemory, now: float) -> list[Frame]:
        """See `FrameFault.change`."""
        memory.held += [(now + self.duration, frame) for frame in frames]
        return memory.release(now)


@final
@dataclass(frozen=True, kw_only=True)
class Reorder(FrameFault):
    """Some frames are overtaken by later ones."""

    name: ClassVar[str] = "reorder"
    probability: float = 0.2
    """Part of the frames that is held back [-]."""
    duration: float = 0.005
    """How long it is held back [s]."""
    direction: Direction = Direction.BOTH
    """Frames that it concerns."""

    def __post_init__(self) -> None:
        check_number("probability", self.probability, least=0.0, most=1.0)
        check_number("duration", self.duration, least=0.0, most=60.0)
        _set_direction(self)

    def change(self, frames: list[Frame], memory: FrameMemory, now: float) -> list[Frame]:
        """See `FrameFault.change`; what was held back comes after what is on time."""
        prompt = []
        for frame in frames:
            if memory.random.random() < self.probability:
                memory.held.append((now + self.duration, frame))
            else:
                prompt.append(frame)
        return prompt + memory.release(now)


@final
@dataclass(frozen=True, kw_only=True)
class Duplicate(FrameFault):
    """Some frames arrive twice."""

    name: ClassVar[str] = "duplicate"
    probability: float = 0.2
    """Part of the frames that is repeated [-]."""
    duration: float = 0.0
    """Time between a frame and its repetition [s]."""
    direction: Direction = Direction.BOTH
    """Frames that it concerns."""

    def __post_init__(self) -> None:
        check_number("probability", self.probability, least=0.0, most=1.0)
        check_number("duration", self.duration, least=0.0, most=60.0)
        _set_direction(self)

    def change(self, frames: list[Frame], memory: FrameMemory, now: float) -> list[Frame]:
        """See `FrameFault.change`."""
        again = [frame for frame in frames if memory.random.random() < self.probability]
        memory.held += [(now + self.duration, frame) for frame in again]
        return frames + memory.release(now)


@final
@dataclass(frozen=True, kw_only=True)
class BusOff(FrameFault):
    """The controller at the wrapped end takes itself off the bus, as after too many errors."""

    name: ClassVar[str] = "bus_off"
    loses_frames: ClassVar[bool] = True
    direction: Direction = Direction.BOTH
    """Frames that it concerns; both is what a controller does."""

    def __post_init__(self) -> None:
        _set_direction(self)

    def change(self, frames: list[Frame], memory: FrameMemory, now: float) -> list[Frame]:
        """See `FrameFault.change`."""
        raise DriveError("the bus is off; wait until it is back, then arm again")


@final
@dataclass(frozen=True, kw_only=True)
class FrozenFeedback(FrameFault):
    """A motor repeats the content of one feedback for ever, at the usual rate."""

    name: ClassVar[str] = "frozen_feedback"
    motor_id: int = 1
    """Id of the motor."""
    direction: Direction = Direction.FEEDBACK
    """Frames that it concerns."""

    def __post_init__(self) -> None:
        check_count("motor_id", self.motor_id, least=1, most=7)
        _set_direction(self)

    def change(self, frames: list[Frame], memory: FrameMemory, now: float) -> list[Frame]:
        """See `FrameFault.change`."""
        own, first = compute_feedback_id(self.motor_id), memory.contents
        return [
            frame._replace(data=first.setdefault(own, frame.data)) if frame.id == own else frame for frame in frames
        ]


@final
@dataclass(frozen=True, kw_only=True)
class Corrupt(FrameFault):
    """Some frames have a wrong bit, a wrong length or a wrong id.

    CAN's own checksum finds that on the wire; an adapter, its driver and a serial line can still do it.
    """

    name: ClassVar[str] = "corrupt"
    probability: float = 0.05
    """Part of the frames that is changed [-]."""
    direction: Direction = Direction.BOTH
    """Frames that it concerns."""

    def __post_init__(self) -> None:
        check_number("probability", self.probability, least=0.0, most=1.0)
        _set_direction(self)

    def change(self, frames: list[Frame], memory: FrameMemory, now: float) -> list[Frame]:
        """See `FrameFault.change`."""
        chance = memory.random
        return [_corrupt(frame, chance) if chance.random() < self.probability else frame for frame in frames]


def _corrupt(frame: Frame, chance: random.Random) -> Frame:
    """The frame with one bit of its content turned, another length, or another id."""
    kind = chance.randrange(3)
    if kind == 0 and frame.data:
        data = bytearray(frame.data)
        data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
        return frame._replace(data=bytes(data))
    if kind == 1:
        lengths = [length for length in range(LARGEST_LENGTH + 1) if length != len(frame.data)]
        return frame._replace(data=(frame.data + bytes(LARGEST_LENGTH))[: chance.choice(lengths)])
    return frame._replace(id=(frame.id + chance.randrange(1, LARGEST_ID + 1)) % (LARGEST_ID + 1))


def _set_direction(fault: FrameFault) -> None:
    """Read the direction where it is given by name."""
    object.__setattr__(fault, "direction", read_direction(fault.direction))
