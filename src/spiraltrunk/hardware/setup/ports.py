"""Buses and serial ports of this computer, and the motors that answer on one of them."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from typing import final

from spiraltrunk.errors import DriveError, MissingPackage
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.bus.board import open_board
from spiraltrunk.hardware.bus.bus_address import BusAddress, BusKind
from spiraltrunk.hardware.bus.can_bus import open_can_bus
from spiraltrunk.hardware.bus.frame_bus import FrameBus
from spiraltrunk.hardware.clock import Clock, SystemClock
from spiraltrunk.hardware.motors.gm6020 import compute_feedback_id
from spiraltrunk.hardware.motors.serial_port import list_ports
from spiraltrunk.hardware.motors.sts.discovery import discover

LISTENING = 0.3
"""Time for which motors that send by themselves are listened to [s] (ours: 300 periods of a GM6020's feedback)."""

_MOST_ID = 7


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class FoundPorts:
    """What there is."""

    can: tuple[str, ...]
    """CAN adapters that the operating system knows, as --bus takes them."""
    serial: tuple[str, ...]
    """Serial ports: of a board, of servos, of a relay or of an slcan adapter."""


def find_ports() -> FoundPorts:
    """CAN adapters and serial ports of this computer; none is opened.

    Raises:
        MissingPackage: without python-can or pyserial.
    """
    try:
        import can
    except ImportError:
        raise MissingPackage("a CAN bus needs python-can: pip install 'spiraltrunk[hardware]'") from None
    found: list[str] = []
    for interface in ("socketcan", "gs_usb"):
        with contextlib.suppress(Exception):  # Without its library or its tool an interface finds nothing.
            configs = can.detect_available_configs([interface])
            found += (f"{config['interface']}:{config['channel']}" for config in configs)
    return FoundPorts(can=tuple(sorted(set(found))), serial=tuple(list_ports()))


def ask_ids(address: BusAddress, clock: Clock | None = None) -> tuple[int, ...]:
    """Ids of the motors on a bus, which is opened for it. Nothing moves: GM6020 send by themselves, STS are pinged.

    Raises:
        DriveError: where it cannot be opened, or does not work.
        MissingPackage: without what it needs.
    """
    if address.kind is BusKind.STS:
        found = discover([address.port])[0]
        if found.problem:
            raise DriveError(found.problem)
        return tuple(sorted(found.models))
    clock = SystemClock() if clock is None else clock
    bus: FrameBus
    bus = open_board(address.port, clock) if address.kind is BusKind.BOARD else open_can_bus(address.text, clock)
    motors, seen = {compute_feedback_id(i): i for i in range(1, _MOST_ID + 1)}, set[int]()
    try:
        end = clock.now() + LISTENING
        while clock.now() < end:
            seen |= {motors[frame.id] for frame in bus.receive() if frame.id in motors and len(frame.data) == 8}
            clock.sleep_until(clock.now() + 0.01)
    finally:
        bus.close()
    return tuple(sorted(seen))
