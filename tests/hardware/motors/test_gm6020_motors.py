"""GM6020 motors over a bus: what is sent, what is believed, and what is refused."""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.bus.frame_bus import Frame
from spiraltrunk.hardware.bus.memory_bus import build_memory_pair
from spiraltrunk.hardware.clock import Clock
from spiraltrunk.hardware.motors.gm6020 import GM6020, Feedback, decode_command, encode_feedback
from spiraltrunk.hardware.motors.gm6020_motors import FrameCounts, GM6020Motors
from spiraltrunk.hardware.motors.motor_port import MotorState


class StepClock(Clock):
    """Time that the test sets."""

    def __init__(self) -> None:
        self.time = 0.0

    def now(self) -> float:
        return self.time

    def sleep_until(self, moment: float) -> None:
        self.time = max(self.time, moment)


class Bench:
    """Motors, and the other end of their bus."""

    def __init__(self, motor_ids=(1, 2, 3), directions=None) -> None:
        self.clock = StepClock()
        bus, self.device = build_memory_pair(self.clock)
        self.bus = bus
        self.motors = GM6020Motors(bus, motor_ids=motor_ids, directions=directions)

    def answer(self, motor_id: int, **values: int) -> None:
        feedback = Feedback(**({"angle": 0, "speed_rpm": 0, "current": 0, "temperature": 25} | values))
        self.inject(0x204 + motor_id, encode_feedback(feedback))

    def inject(self, identifier: int, data: bytes) -> None:
        self.device.send(Frame(identifier, data))
        self.device.flush()

    def sent(self) -> dict[int, tuple[int, ...]]:
        return {frame.id: decode_command(frame.data) for frame in self.device.receive()}


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_torques_travel_in_current_mode_in_one_frame(bench):
    bench.motors.send([2.223, -1.1115, 0.0])
    assert bench.sent() == {0x1FE: (16384, -8192, 0, 0)}


def test_motors_of_both_frames_and_directions():
    """Cable 0 has motor 5, which winds in with its negative sense."""
    bench = Bench((5, 4, 7), (-1, 1, 1))
    bench.motors.send([1.1115, 1.1115, -1.1115])
    assert bench.sent() == {0x2FE: (-8192, 0, -8192, 0), 0x1FE: (0, 0, 0, 8192)}


def test_feedback_in_si_units_and_in_the_cables_sense():
    bench = Bench((1, 2), (1, -1))
    bench.clock.time = 2.5
    for motor_id in (1, 2):
        bench.answer(motor_id, angle=100)
        bench.clock.time += 0.01
        bench.answer(motor_id, angle=228, speed_rpm=60, current=16384, temperature=40)
    first, second = bench.motors.read()
    angle = 128 / 8192 * 2 * math.pi
    assert first == MotorState(
        time=2.51, angle=angle, speed=2 * math.pi, torque=2.223, temperature=40.0, is_count_lost=False, n_frame=2
    )
    assert (second.angle, second.speed, second.torque) == (-angle, -2 * math.pi, -2.223)


def test_nothing_is_told_of_a_motor_that_was_never_heard(bench):
    bench.answer(2)
    assert [state is None for state in bench.motors.read()] == [True, False, True]


def test_a_state_keeps_the_time_of_its_feedback(bench):
    bench.answer(1)
    bench.motors.read()
    bench.clock.time = 3.0
    assert bench.motors.read()[0].time == 0.0


REFUSED = [
    [math.nan, 0, 0],
    [0, math.inf, 0],
    [0, 0, -math.inf],
    [2.224, 0, 0],
    [0, -2.224, 0],
    [0, 0],
    [0, 0, 0, 0],
    [],
    ["1", 0, 0],
    [None, 0, 0],
    [10**400, 0, 0],
    np.array([0, np.nan, 0]),
]


@pytest.mark.parametrize("torques", REFUSED, ids=str)
def test_bad_torques_are_refused_and_nothing_is_sent_then_or_later(bench, torques):
    with pytest.raises(DriveError, match="allowed: "):
        bench.motors.send(torques)
    bench.bus.flush()
    assert bench.sent() == {}


def test_no_setting_raises_the_data_sheet(bench):
    with pytest.raises(dataclasses.FrozenInstanceError):
        bench.motors.data_sheet.torque_max = 99.0
    bench.motors.data_sheet = dataclasses.replace(GM6020, torque_max=99.0)
    with pytest.raises(DriveError, match=r"from -2\.223 to 2\.223 N m"):
        bench.motors.send([2.3, 0.0, 0.0])
    assert bench.sent() == {}


@given(st.lists(st.floats(allow_nan=True, allow_infinity=True), max_size=5))
def test_what_is_sent_is_what_was_asked_for_or_nothing(torques):
    bench = Bench()
    if len(torques) == 3 and all(math.isfinite(torque) and abs(torque) <= GM6020.torque_max for torque in torques):
        bench.motors.send(torques)
        values = bench.sent()[0x1FE]
        assert values[3] == 0
        assert np.allclose(np.array(values[:3]) * GM6020.torque_step, torques, rtol=0, atol=GM6020.torque_step / 2)
    else:
        with pytest.raises(DriveError):
            bench.motors.send(torques)
        assert bench.sent() == {}


def test_frames_that_are_not_sound_feedback_are_counted_and_change_nothing(bench):
    for motor_id in (1, 2, 3):
        bench.answer(motor_id, angle=4000)
    before = bench.motors.read()
    sound = encode_feedback(Feedback(4100, 0, 0, 25))
    bench.inject(0x123, sound)
    bench.inject(0x204, sound)
    bench.inject(0x208, sound)
    bench.inject(0x205, sound[:7])
    bench.inject(0x206, b"")
    bench.inject(0x207, b"\x20\x00" + sound[2:])
    bench.inject(0x205, sound[:6] + b"\xff\x00")
    assert bench.motors.read() == before
    assert bench.motors.counts == FrameCounts(accepted=3, unknown=3, malformed=2, implausible=2)


def test_a_power_cycle_loses_the_count_until_it_is_restarted(bench):
    for moment, angle in ((0.0, 8000), (0.05, 100), (0.2, 120)):
        bench.clock.time = moment
        bench.answer(1, angle=angle)
    state = bench.motors.read()[0]
    assert state.is_count_lost
    bench.motors.restart_count()
    assert bench.motors.read()[0].angle == state.angle == pytest.approx(312 / 8192 * 2 * math.pi)
    assert not bench.motors.read()[0].is_count_lost


def test_after_the_bus_returns_no_stale_frame_is_sent(bench):
    bench.bus.set_off(True)
    with pytest.raises(DriveError, match="off"):
        bench.motors.send([1.0, 1.0, 1.0])
    with pytest.raises(DriveError, match="off"):
        bench.motors.read()
    bench.bus.set_off(False)
    bench.bus.flush()
    assert bench.sent() == {}
    bench.motors.send([0.5, 0.0, 0.0])
    assert bench.sent() == {0x1FE: (3685, 0, 0, 0)}


def test_closing_sends_zero_once_and_nothing_afterwards(bench):
    bench.motors.send([1.0, 1.0, 1.0])
    bench.motors.close()
    assert bench.sent() == {0x1FE: (0, 0, 0, 0)}
    bench.motors.close()
    with pytest.raises(DriveError, match="closed"):
        bench.motors.send([0.0, 0.0, 0.0])
    assert bench.sent() == {}


def test_closing_on_a_bus_that_is_gone_is_harmless(bench):
    bench.bus.set_off(True)
    bench.motors.close()
    with pytest.raises(DriveError, match="closed"):
        bench.motors.send([0.0, 0.0, 0.0])


def test_opening_sends_nothing(bench):
    assert bench.sent() == {}


@pytest.mark.parametrize("directions", [(1, 1), (1, 0, 1), (1, 1, 2), (1, 1, 1, 1)])
def test_directions_that_do_not_fit_are_refused(directions):
    with pytest.raises(DriveError, match="allowed: 1 or -1 for each of 3 motors"):
        Bench(directions=directions)


@pytest.mark.parametrize("order", list(itertools.permutations((1, 2, 3))))
def test_each_cable_has_its_own_motor(order):
    bench = Bench(order)
    bench.answer(order[0], current=16384)
    bench.motors.send([1.0, 0.0, 0.0])
    assert [index for index, value in enumerate(bench.sent()[0x1FE]) if value] == [order[0] - 1]
    assert [state is not None for state in bench.motors.read()] == [True, False, False]
