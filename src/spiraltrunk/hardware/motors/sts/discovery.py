"""Which serial ports have STS servos, and under which ids."""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import NamedTuple, final

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.motors.serial_port import list_ports
from spiraltrunk.hardware.motors.sts.line import StsLine

IDS = tuple(range(1, 11))
"""Ids that are asked where none are named (ours): a servo is delivered with 1, and three are numbered on from it."""


@final
class FoundServos(NamedTuple):
    """What one port answered."""

    port: str
    """Serial port."""
    models: dict[int, int]
    """Model number by id of the servos that answered."""
    problem: str
    """Why the port could not be used or was not asked to the end; empty where it was."""


def discover(
    ports: Iterable[str] | None = None, *, servo_ids: Iterable[int] = IDS, longest: float = 10.0
) -> list[FoundServos]:
    """Ask servos for their model on every port, which moves none of them.

    Ports are opened one after the other, only by this call. A device of another kind on a port receives the pings, too:
    name the ports where that matters.

    Args:
        ports: ports to be asked; those that the operating system lists where they are None.
        servo_ids: ids to be asked.
        longest: time after which no further id is asked [s]; an id takes 0.03 s at most where none answers.

    Raises:
        MissingPackage: without pyserial or the SDK.
    """
    end = time.monotonic() + longest
    wanted = tuple(servo_ids)
    return [_ask(port, wanted, end) for port in (list_ports() if ports is None else ports)]


def _ask(port: str, servo_ids: tuple[int, ...], end: float) -> FoundServos:
    models: dict[int, int] = {}
    line = None
    try:
        line = StsLine(port)
        for servo_id in servo_ids:
            if time.monotonic() > end:
                return FoundServos(port, models, f"out of time before id {servo_id}")
            number = line.ping(servo_id)
            if number is not None:
                models[servo_id] = number
    except DriveError as error:
        return FoundServos(port, models, str(error))
    finally:
        if line is not None:
            line.close()
    return FoundServos(port, models, "")
