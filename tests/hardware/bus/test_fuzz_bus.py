"""Random frames move no motor and stop no loop, and the script would notice if they did."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path

import pytest

from spiraltrunk.hardware.bus import board, board_frame
from spiraltrunk.hardware.bus.board_frame import BoardMessage
from spiraltrunk.hardware.bus.frame_bus import Frame
from spiraltrunk.hardware.motors import gm6020_motors
from spiraltrunk.hardware.motors.gm6020 import Feedback
from spiraltrunk.hardware.motors.gm6020_motors import GM6020Motors

SCRIPT = Path(__file__).parents[3] / "benchmarks" / "fuzz_bus.py"


@pytest.fixture
def fuzz():
    spec = importlib.util.spec_from_file_location("fuzz_bus", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_random_frames_move_no_motor(fuzz):
    found = fuzz.run(20_000, 600.0, seed=7)
    assert found["can_frames"] == found["board_pieces"] == 20_000
    shares = [found[name] for name in found if name.startswith(("can_", "board_"))]
    assert min(shares) > 100


def test_the_same_seed_gives_the_same_frames(fuzz):
    one, other = (fuzz.random.Random(3) for _ in range(2))
    for _ in range(100):
        assert fuzz.draw_frame(one, 0.0) == fuzz.draw_frame(other, 0.0)
        assert fuzz.draw_stream(one) == fuzz.draw_stream(other)


def trust(data: bytes) -> Feedback:
    return Feedback(int.from_bytes(data[:2], "big"), 0, 0, data[6])


def answer(motors: GM6020Motors, frame: Frame) -> None:
    motors._bus.send(frame)


def reply(board: board.BoardBus, message: BoardMessage, now: float) -> list[Frame]:
    board._port.write(message.data)
    return []


@pytest.mark.parametrize(
    "change",
    [
        (gm6020_motors, "decode_feedback", trust),
        (gm6020_motors.GM6020Motors, "_accept", answer),
        (board_frame, "LONGEST", 60_000),
        (board, "decode_frames", lambda data, now: [Frame(0x800, b"", now)]),
        (board.BoardBus, "_take_in", reply),
    ],
    ids=["trusts anything", "sends when it hears", "believes any length", "hands on any id", "answers the board"],
)
def test_a_driver_that_breaks_is_noticed(fuzz, monkeypatch, capsys, change):
    monkeypatch.setattr(*change)
    with pytest.raises(AssertionError):
        fuzz.run(20_000, 600.0, seed=7)
    assert "of seed 7" in capsys.readouterr().err


def test_the_script_prints_its_figures(fuzz, monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["fuzz_bus.py", "--count", "100"])
    assert fuzz.main() == 0
    assert json.loads(capsys.readouterr().out)["can_frames"] == 100
