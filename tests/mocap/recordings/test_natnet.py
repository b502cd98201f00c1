"""What a server streams is recorded, and what goes wrong is told or noted."""

from __future__ import annotations

import importlib.util
import socket
import sys
from pathlib import Path

import numpy as np
import pytest

from spiraltrunk.errors import DesignError, MissingPackage, TakeError
from spiraltrunk.mocap.recordings.natnet import LiveSettings, record_live

_SPEC = importlib.util.spec_from_file_location("natnet_server", Path(__file__).parent / "fakes" / "natnet_server.py")
fake = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(fake)

TURN = (0.0, 0.0, 0.6, 0.8)
NAMES = {1: "base", 7: "section_01"}


def frame(number, tracked=True, step=0.01):
    x = 0.001 * number
    poses = [(1, (0.0, 1.0, 0.0), TURN, True), (7, (x, 2.0, 3.0), TURN, tracked)]
    return lambda: fake.pack_frame(number, step * number, poses, [(7, 1, (x, 2.5, 3.0))] if tracked else [])


def record(packets, axes="y-up", duration=1.0, **more):
    pytest.importorskip("natnet", reason="natnet is not installed")
    with fake.Server(NAMES, packets) as server:
        settings = LiveSettings(axes=axes, command_port=server.port, patience=0.3, **more)
        return record_live(settings, duration)


def test_a_stream_becomes_a_take():
    take = record([frame(number, tracked=number != 105) for number in range(100, 120)])
    np.testing.assert_array_equal(take.frame, np.arange(100, 120))
    assert take.rate == pytest.approx(100.0)
    np.testing.assert_allclose(take.time, take.frame / 100.0)
    body = take.body("section_01")
    np.testing.assert_array_equal(body.is_seen, take.frame != 105)
    np.testing.assert_allclose(body.position[0], [0.1, 2.0, 3.0], atol=1e-6)
    np.testing.assert_allclose(body.quaternion_wxyz[0], [0.8, 0, 0, 0.6], atol=1e-6)
    np.testing.assert_allclose(body.marker_error[0], 1e-4, rtol=1e-5)
    np.testing.assert_allclose(take.marker("section_01:Marker1").position[1], [0.101, 2.5, 3.0], atol=1e-6)
    assert take.body("base").is_stale[2:].all()
    assert any("the stream stopped" in note for note in take.notes)


def test_axes_turn_a_stream():
    take = record([frame(number) for number in range(5)], axes="z-up")
    np.testing.assert_allclose(take.body("section_01").position[1], [0.001, 3.0, -2.0], atol=1e-6)


def test_frames_out_of_order_missing_or_broken_are_noted():
    packets = [frame(0), frame(1), frame(4), frame(2), frame(4), lambda: b"\1\0\0", frame(5)]
    take = record(packets)
    np.testing.assert_array_equal(take.frame, [0, 1, 4, 5])
    assert any("2 frames missing" in note for note in take.notes)
    assert any("2 frames came late or twice" in note for note in take.notes)
    assert any("1 packets could not be read" in note for note in take.notes)


def test_a_stream_of_nothing_is_refused():
    with pytest.raises(TakeError, match="0 frames came"):
        record([])
    with pytest.raises(TakeError, match="clock stands still"):
        record([frame(number, step=0.0) for number in range(3)])


def test_nobody_there_is_told():
    pytest.importorskip("natnet", reason="natnet is not installed")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as silent:
        silent.bind(("127.0.0.1", 0))
        settings = LiveSettings(axes="y-up", command_port=silent.getsockname()[1], patience=0.1)
        with pytest.raises(TakeError, match="allowed: an address where Motive streams"):
            record_live(settings, 1.0)


def test_settings_are_checked(monkeypatch):
    with pytest.raises(TakeError, match="allowed: y-up"):
        LiveSettings(axes="up")
    with pytest.raises(DesignError):
        LiveSettings(axes="y-up", patience=float("nan"))
    with pytest.raises(DesignError):
        record_live(LiveSettings(axes="y-up"), float("inf"))
    monkeypatch.setitem(sys.modules, "natnet", None)
    with pytest.raises(MissingPackage, match=r"spiraltrunk\[mocap\]"):
        record_live(LiveSettings(axes="y-up"), 1.0)
