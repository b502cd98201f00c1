"""Load cells: frames of the telemetry in any pieces, and what is not believed."""

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.errors import DesignError, DriveError
from spiraltrunk.hardware.motors.load_cell import LoadCells, LoadCellSettings, check_known_mass
from spiraltrunk.hardware.twin.clock import TwinClock

SETTINGS = LoadCellSettings(port="board", cables=(2, 0), offsets=(0.0, 0.5), scales=(1.0, -2.0))


class Wire:
    """Bytes that a board sent."""

    def __init__(self):
        self.sent, self.is_gone = bytearray(), False

    def read(self, size):
        if self.is_gone:
            raise OSError("device disconnected")
        taken = bytes(self.sent[:size])
        del self.sent[:size]
        return taken

    def write(self, data):
        raise AssertionError("nothing is sent to load cells")

    def close(self):
        self.is_gone = True


def encode(time_us, *tensions, lengths=(0.0, 0.0)):
    return b"\xaa\x55" + struct.pack("<Iffff", time_us, *tensions, *lengths)


class Bench:
    def __init__(self):
        self.wire, self.clock = Wire(), TwinClock()
        self.cells = LoadCells(SETTINGS, self.wire, self.clock)

    def read(self, sent=b""):
        self.wire.sent += sent
        return self.cells.read()

    def wait(self, seconds):
        self.clock.sleep_until(self.clock.now() + seconds)


@pytest.fixture
def bench():
    return Bench()


def test_tensions_by_cable(bench):
    """Cell 0 is at cable 2; cell 1 at cable 0, its offset 0.5 N and scale -2: -2 (-1 - 0.5) = 3."""
    assert bench.read() == (None, None, None)
    found = bench.read(encode(1000, 4.0, -1.0) + encode(2667, 4.0, -1.0))
    assert found[0].tension == 3.0
    assert found[1] is None
    assert found[2].tension == 4.0


def test_a_first_frame_waits_for_the_mark_of_the_next(bench):
    assert bench.read(encode(1, 4.0, 4.0)) == (None, None, None)
    assert bench.read(b"\xaa\x55")[2].tension == 4.0


def test_a_reading_becomes_too_old(bench):
    bench.read(encode(1, 4.0, 4.0) + encode(2, 4.0, 4.0))
    bench.wait(0.04)
    assert bench.read()[2].tension == 4.0
    bench.wait(0.02)
    assert bench.read() == (None, None, None)


def test_a_board_that_repeats_its_last_frame_becomes_too_old(bench):
    bench.read(encode(1, 4.0, 4.0) + encode(2, 4.0, 4.0))
    for _ in range(6):
        bench.wait(0.01)
        found = bench.read(encode(2, 4.0, 4.0))
    assert found == (None, None, None)
    assert bench.cells.n_refused == 6


def test_a_board_that_restarts_is_believed_again(bench):
    bench.read(encode(9_000_000, 4.0, 4.0) + encode(9_001_667, 4.0, 4.0))
    bench.wait(0.1)
    assert bench.read(encode(10, 5.0, 5.0) + encode(1677, 5.0, 5.0))[2].tension == 5.0


def test_the_time_of_the_board_wraps(bench):
    found = bench.read(encode(2**32 - 1000, 4.0, 4.0) + encode(667, 6.0, 4.0) + b"\xaa\x55")
    assert found[2].tension == 6.0
    assert bench.cells.n_refused == 0


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 201.0, 1e30])
def test_values_that_are_not_believed(bench, bad):
    good = encode(1, 4.0, 4.0)
    found = bench.read(good + encode(2, bad, 7.0) + encode(3, 5.0, 4.0) + encode(4, 5.0, 4.0))
    assert found[2].tension == 5.0
    assert bench.cells.n_refused >= 1
    assert bench.read(encode(5, 7.0, 4.0, lengths=(bad * 100, 0.0)))[2].tension == 5.0


def test_a_mark_inside_a_frame_is_no_beginning(bench):
    """A tension whose bytes hold AA 55, read from the middle of a frame."""
    tension = struct.unpack("<f", b"\x00\xaa\x55\x41")[0]
    stream = b"".join(encode(1000 * i, tension, 2.0) for i in range(1, 20))
    found = bench.read(stream[5:])
    assert found[2].tension == pytest.approx(tension)
    assert found[0].tension == -2.0 * (2.0 - 0.5)


@given(st.lists(st.floats(-200, 200, width=32), min_size=3, max_size=10), st.integers(1, 30))
def test_frames_arrive_in_any_pieces(tensions, size):
    bench, seen = Bench(), []
    stream = b"".join(encode(i + 1, tension, 0.0) for i, tension in enumerate(tensions)) + b"\xaa\x55"
    for start in range(0, len(stream), size):
        found = bench.read(stream[start : start + size])[2]
        if found is not None:
            seen.append(found.tension)
    assert seen[-1] == tensions[-1]
    assert set(seen) <= set(tensions)


@given(st.binary(max_size=300))
def test_noise_gives_no_tension_beyond_belief_and_is_forgotten(noise):
    bench = Bench()
    for sample in bench.read(noise):
        assert sample is None or abs(sample.tension) <= 2 * 200.5
    bench.wait(0.1)
    stream = b"".join(encode(2**31 + 1000 * i, 4.0, 4.0) for i in range(20))
    bench.read(stream)
    assert bench.read(encode(2**31 + 50_000, 4.0, 4.0))[2].tension == 4.0


def test_no_endless_memory(bench):
    bench.wire.sent += bytes(10**6)
    for _ in range(10):
        bench.cells.read()
    assert len(bench.cells._received) < 10_000


def test_a_board_that_is_unplugged(bench):
    bench.cells.close()
    with pytest.raises(DriveError, match=r"load cells on board: .*plugged in"):
        bench.cells.read()


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"cables": (0, 0)}, "no cable twice"),
        ({"cables": (0, 3)}, "from 0 to 2"),
        ({"scales": (1.0,)}, "2 numbers"),
        ({"scales": (1.0, 0.0)}, "other than 0"),
        ({"offsets": (math.nan, 0.0)}, "finite"),
        ({"age_max": 0.0}, "above 0"),
    ],
)
def test_settings_that_are_refused(changes, text):
    given = {"port": "board", "cables": (2, 0), "offsets": (0.0, 0.0), "scales": (1.0, 1.0)} | changes
    with pytest.raises(DesignError, match=text):
        LoadCellSettings(**given)


def test_units_are_told_apart_by_a_known_mass():
    check_known_mass(4.9, 0.5)
    for reading, unit in ((0.5, "kg"), (500.0, "g"), (1.1, "lbf")):
        with pytest.raises(DriveError, match=f"sends {unit}; allowed: newtons, 4.9 N"):
            check_known_mass(reading, 0.5)
    for reading in (-4.9, 0.0, 7.0, math.nan):
        with pytest.raises(DriveError, match="set scale and offset"):
            check_known_mass(reading, 0.5)
