"""Live recording of Motive's stream, by the package natnet (NatNet over UDP)."""

from __future__ import annotations

import contextlib
import io
import math
import struct
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, final

import numpy as np

from spiraltrunk.checks import check_number
from spiraltrunk.errors import MissingPackage, TakeError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.mocap.recordings.axes import read_axes, turn_quaternions
from spiraltrunk.mocap.recordings.take import Body, Marker, Take

_Rows = dict[int, tuple[float, ...]]
"""Values of one frame by the number of the track."""

_POLL = 2e-3
_OCCLUDED = 0x01
_NUMBER = 0xFFFF
"""Bits of a labelled marker's number that count it within its rigid body; the upper bits are the body's."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class LiveSettings:
    """Address and axes of the stream."""

    axes: str
    """Axis convention of the stream (`axes.NAMED`, or three axes), as in Motive's Streaming pane."""
    server: str = "127.0.0.1"
    """Address of the computer running Motive."""
    local: str = "127.0.0.1"
    """This computer's address in the same network."""
    is_multicast: bool = False
    """Whether Motive streams by multicast."""
    command_port: int = 1510
    """UDP port of Motive's commands."""
    data_port: int = 1511
    """UDP port of the frames, for multicast."""
    patience: float = 2.0
    """Time without a new frame after which the stream counts as ended [s]."""

    def __post_init__(self) -> None:
        read_axes(self.axes)
        check_number("patience", self.patience, least=0.01, most=60.0)


@final
@dataclass
class _Stream:
    """Frames received so far."""

    number: list[int] = field(default_factory=list)
    stamp: list[float] = field(default_factory=list)
    bodies: list[_Rows] = field(default_factory=list)
    markers: list[_Rows] = field(default_factory=list)
    names: dict[int, str] = field(default_factory=dict)
    late: int = 0
    bad: int = 0

    def add_frame(self, data: Any) -> None:
        """Keep a frame; late and duplicate frames are left out, as UDP does not keep the order."""
        number = int(data.prefix.frame_number)
        if self.number and number <= self.number[-1]:
            self.late += 1
            return
        self.number.append(number)
        self.stamp.append(float(data.suffix.timestamp))
        tracked = [body for body in data.rigid_bodies if body.tracking_valid]
        seen = [marker for marker in data.labeled_markers or () if not (marker.param or 0) & _OCCLUDED]
        self.bodies.append({body.id_num: (*body.pos, *body.rot, body.marker_error) for body in tracked})
        self.markers.append({marker.id_num: tuple(marker.pos) for marker in seen})

    def add_names(self, descriptions: Any) -> None:
        self.names.update({body.id_num: body.name for body in descriptions.rigid_bodies})


def record_live(settings: LiveSettings, duration: float, watch: Callable[[float], None] | None = None) -> Take:
    """Record rigid bodies and labelled markers.

    Untracked poses are not a number; lost frames are missing and noted. A stream that ends early gives a shorter take
    with a note.

    Args:
        settings: address and axes.
        duration: length of the recording [s].
        watch: called with the recorded time [s].

    Raises:
        TakeError: where no stream is found, or no frames arrive.
        MissingPackage: where natnet is not installed.
    """
    check_number("duration", duration, above=0.0, most=36_000.0)
    client, stream = _connect(settings), _Stream()
    client.on_data_frame_received_event.handlers.append(stream.add_frame)
    client.on_data_description_received_event.handlers.append(stream.add_names)
    ended = ""
    try:
        client.request_modeldef()
        begin = last = time.monotonic()
        while time.monotonic() - begin < duration:
            before = len(stream.number)
            _poll(client, stream)
            now = time.monotonic()
            last = now if len(stream.number) > before else last
            if now - last > settings.patience:
                ended = f"the stream stopped after {last - begin:.2f} s"
                break
            if watch is not None:
                watch(now - begin)
            time.sleep(_POLL)
    finally:
        client.shutdown()
    return _build_take(settings, stream, ended)


def _connect(settings: LiveSettings) -> Any:
    try:
        import natnet  # type: ignore[import-untyped]
    except ImportError:
        raise MissingPackage("live capture needs the package natnet: pip install 'spiraltrunk[mocap]'") from None
    client = natnet.NatNetClient(
        server_ip_address=settings.server, local_ip_address=settings.local, command_port=settings.command_port,
        data_port=settings.data_port, use_multicast=settings.is_multicast,
    )  # fmt: skip
    allowed = "allowed: an address where Motive streams (Streaming pane on, same network, same unicast or multicast)"
    try:
        with contextlib.redirect_stdout(io.StringIO()):  # The package prints its warnings.
            client.connect(timeout=settings.patience)
    except (TimeoutError, OSError, natnet.NatNetError, struct.error, UnicodeError) as error:
        client.shutdown()
        reason = " ".join(str(error).split())[:120] or "no answer"
        raise TakeError(f"{settings.server}:{settings.command_port}: {reason}; {allowed}") from None
    return client


def _poll(client: Any, stream: _Stream) -> None:
    """Process received packets; unreadable ones are counted."""
    import natnet

    try:
        with contextlib.redirect_stdout(io.StringIO()):
            client.update_sync()
    except (struct.error, UnicodeError, ValueError, TypeError, natnet.NatNetError, ConnectionError):
        stream.bad += 1


def _build_take(settings: LiveSettings, stream: _Stream, ended: str) -> Take:
    source = f"{settings.server}:{settings.command_port}"
    if len(stream.number) < 2:
        allowed = "two or more: is Motive tracking, and live?"
        raise TakeError(f"{len(stream.number)} frames came; allowed: {allowed}", file=source)
    frame = np.array(stream.number, np.int64)
    rate = _find_rate(frame, np.array(stream.stamp), source)
    notes = [ended] if ended else []
    missing = int(frame[-1] - frame[0]) + 1 - len(frame)
    counts = {"frames missing": missing, "frames came late or twice": stream.late,
              "packets could not be read": stream.bad}  # fmt: skip
    notes += [f"{count} {what}" for what, count in counts.items() if count]
    turn = read_axes(settings.axes)
    bodies = tuple(_build_body(stream, *track, turn) for track in _collect(stream.bodies, 8))
    markers = tuple(_build_marker(stream, *track, turn) for track in _collect(stream.markers, 3))
    return Take(
        source=source, name="live", started="", rate=rate, frame=frame, time=frame / rate, bodies=bodies,
        markers=markers, notes=tuple(notes),
    )  # fmt: skip


def _find_rate(frame: np.ndarray, stamp: np.ndarray, source: str) -> float:
    """Frames per second from frame numbers and the server's clock [Hz]."""
    step = np.diff(stamp)
    good = step > 0
    rate = float(np.median(np.diff(frame)[good] / step[good])) if good.any() else math.nan
    if not (math.isfinite(rate) and 0.01 <= rate <= 1e5):
        raise TakeError("the stream's clock stands still; allowed: a live stream or a playback", file=source)
    return round(rate, 3)


def _collect(rows: list[_Rows], width: int) -> Iterator[tuple[int, np.ndarray]]:
    """Numbers of the tracks, and their values over time, not a number where missing, shape (n, width)."""
    for number in sorted({number for row in rows for number in row}):
        values = np.array([row.get(number, (math.nan,) * width) for row in rows], float)
        values[~np.isfinite(values).all(axis=1)] = math.nan
        yield number, values


def _build_body(stream: _Stream, number: int, values: np.ndarray, turn: np.ndarray) -> Body:
    position, xyzw = values[:, :3] @ turn.T, values[:, 3:7]
    size = np.linalg.norm(xyzw, axis=1)
    xyzw = np.where((np.abs(size - 1) < 0.02)[:, None], xyzw / np.where(size > 0, size, 1.0)[:, None], math.nan)
    quaternion = turn_quaternions(xyzw[:, [3, 0, 1, 2]], turn)
    return Body(
        name=stream.names.get(number, f"body {number}"), id=str(number), position=position,
        quaternion_wxyz=quaternion, marker_error=values[:, 7],
    )  # fmt: skip


def _build_marker(stream: _Stream, number: int, values: np.ndarray, turn: np.ndarray) -> Marker:
    body, count = number >> 16, number & _NUMBER
    name = f"{stream.names.get(body, f'body {body}')}:Marker{count}"
    return Marker(name=name, id=str(number), is_solved=False, position=values @ turn.T)
