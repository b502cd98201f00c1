"""Text that names a bus: an adapter of python-can, a board or a line of servos on a serial port."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple, final

from spiraltrunk.errors import DriveError, describe
from spiraltrunk.hardware.bus.can_address import INTERFACES, parse_can_address


@final
class BusKind(Enum):
    """Kind of a bus."""

    CAN = "can"
    """A CAN adapter, see `can_address.INTERFACES`."""
    BOARD = "board"
    """A RoboMaster development board on a serial port, with the motors' bus and the servo behind it."""
    STS = "sts"
    """STS servos on a serial port."""


SERIAL = {
    BusKind.BOARD: "board:/dev/ttyACM0, a development board on a serial port",
    BusKind.STS: "sts:/dev/ttyUSB0, STS servos on a serial port",
}
"""Kinds on serial ports, with an example each."""

ALLOWED = "; ".join((*INTERFACES.values(), *SERIAL.values()))
"""What a bus may be, for errors and the help."""


@final
class BusAddress(NamedTuple):
    """A bus that can be opened."""

    kind: BusKind
    """What is there."""
    text: str
    """Address as it was typed."""
    port: str
    """Serial port; of a CAN adapter, the channel."""


def parse_bus_address(text: str) -> BusAddress:
    """The bus that a text names, such as ``socketcan:can0`` or ``board:/dev/ttyACM0``; nothing is opened.

    Raises:
        DriveError: with the text and what is allowed.
    """
    name, _, port = text.partition(":") if isinstance(text, str) else ("", "", "")
    for kind, example in SERIAL.items():
        if name == kind.value:
            return BusAddress(kind, text, check_port(text, port, example))
    if name not in INTERFACES:
        raise DriveError(f"bus is {describe(text)}; allowed: {ALLOWED}")
    return BusAddress(BusKind.CAN, text, parse_can_address(text).channel)


def check_port(text: str, port: str, example: str) -> str:
    """The serial port of an address; pyserial's URLs, which may name a computer, are refused.

    Raises:
        DriveError: with the address and an example.
    """
    is_name = bool(port.strip()) and port.isprintable() and len(port) <= 200 and "://" not in port
    if not is_name:
        raise DriveError(f"serial port of {describe(text)} is {describe(port)}; allowed: {example}")
    return port
