"""Text that names a CAN adapter, such as ``socketcan:can0``."""

from __future__ import annotations

import ipaddress
from typing import NamedTuple, final

from spiraltrunk.errors import DriveError, describe

INTERFACES = {
    "socketcan": "socketcan:can0, an interface of Linux",
    "gs_usb": "gs_usb:0, the number of a candleLight adapter",
    "slcan": "slcan:/dev/ttyACM0, the port of a serial adapter",
    "virtual": "virtual:NAME, inside this process",
    "udp_multicast": "udp_multicast:239.74.163.2, a multicast group",
}
"""Interfaces of python-can that can be used, with an example each."""


@final
class CanAddress(NamedTuple):
    """An interface of python-can and its channel."""

    interface: str
    """One of `INTERFACES`."""
    channel: str
    """Adapter, port, group or name."""


def parse_can_address(text: str) -> CanAddress:
    """Interface and channel of a text ``INTERFACE:CHANNEL``; nothing is opened.

    Raises:
        DriveError: with the text and what is allowed.
    """
    interface, colon, channel = text.partition(":") if isinstance(text, str) else ("", "", "")
    if interface not in INTERFACES or not colon:
        raise DriveError(f"bus is {describe(text)}; allowed: {'; '.join(INTERFACES.values())}")
    if not (_is_channel(interface, channel) and channel.isprintable() and len(channel) <= 200):
        raise DriveError(f"channel of bus {describe(text)} is {describe(channel)}; allowed: {INTERFACES[interface]}")
    return CanAddress(interface, channel)


def _is_channel(interface: str, channel: str) -> bool:
    if interface == "gs_usb":
        return channel.isascii() and channel.isdecimal() and len(channel) <= 2
    if interface == "socketcan":  # Linux allows names of up to 15 characters.
        return 0 < len(channel) <= 15 and not any(sign.isspace() or sign == "/" for sign in channel)
    if interface == "udp_multicast":
        return _is_multicast(channel)
    return bool(channel.strip())


def _is_multicast(channel: str) -> bool:
    try:
        return ipaddress.ip_address(channel).is_multicast
    except ValueError:
        return False
