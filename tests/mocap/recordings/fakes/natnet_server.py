"""A small NatNet 3.1 server on UDP: answers who it is, describes its rigid bodies, and streams frames."""

from __future__ import annotations

import socket
import struct
import threading
from collections.abc import Callable, Sequence

PING, INFO, DESCRIBE, DESCRIPTION, FRAME = 0, 1, 4, 5, 7

Pose = tuple[int, tuple[float, float, float], tuple[float, float, float, float], bool]
"""Number, position, quaternion xyzw and whether it is tracked."""


def pack_info() -> bytes:
    return b"fake".ljust(256, b"\0") + bytes([3, 1, 0, 0]) + bytes([3, 1, 0, 0])


def pack_description(names: dict[int, str]) -> bytes:
    parts = [struct.pack("<I", len(names))]
    for number, name in names.items():
        parts.append(struct.pack("<I", 1) + name.encode() + b"\0" + struct.pack("<ii3f", number, -1, 0, 0, 0))
        parts.append(struct.pack("<I", 0))
    return b"".join(parts)


def pack_frame(number: int, time: float, poses: Sequence[Pose], markers: Sequence[tuple[int, int, tuple]]) -> bytes:
    """One frame; markers are (rigid body, count, position)."""
    parts = [struct.pack("<IIII", number, 0, 0, len(poses))]
    for ident, position, turn, is_tracked in poses:
        parts.append(struct.pack("<i3f4ffh", ident, *position, *turn, 1e-4, int(is_tracked)))
    parts.append(struct.pack("<II", 0, len(markers)))
    for body, count, position in markers:
        parts.append(struct.pack("<I3ffhf", (body << 16) | count, *position, 0.009, 0, 0.0))
    parts.append(struct.pack("<IIIIdQQQh", 0, 0, 0, 0, time, 0, 0, 0, 0))
    return b"".join(parts)


class Server:
    """Serves packets, given as functions of nothing, one after the other, to whoever pings it."""

    def __init__(self, names: dict[int, str], packets: Sequence[Callable[[], bytes]], pause: float = 1e-3) -> None:
        self._names, self._packets, self._pause = names, packets, pause
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.settimeout(0.05)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)

    @property
    def port(self) -> int:
        return self._socket.getsockname()[1]

    def __enter__(self) -> Server:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()
        self._socket.close()

    def _serve(self) -> None:
        left = None
        client = None
        while not self._stop.is_set():
            try:
                data, client = self._socket.recvfrom(65536)
                kind = struct.unpack_from("<H", data)[0]
                if kind == PING:
                    self._send(client, INFO, pack_info())
                elif kind == DESCRIBE:
                    self._send(client, DESCRIPTION, pack_description(self._names))
                    left = iter(self._packets)
            except TimeoutError:
                pass
            while left is not None and client is not None and (packet := next(left, None)) is not None:
                self._send(client, FRAME, packet())
                self._stop.wait(self._pause)

    def _send(self, client: tuple[str, int], kind: int, data: bytes) -> None:
        self._socket.sendto(struct.pack("<HH", kind, len(data)) + data, client)
