"""Motors on the bus: frames exactly as of the codec, commands, watchdog."""

from __future__ import annotations

import math
import random
import statistics
import time
from collections.abc import Callable
from itertools import pairwise

import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DesignError, DriveError
from spiraltrunk.hardware.bus.frame_bus import Frame
from spiraltrunk.hardware.bus.memory_bus import build_memory_pair
from spiraltrunk.hardware.clock import SystemClock
from spiraltrunk.hardware.motors.gm6020 import (
    CURRENT_RAW,
    GM6020,
    TORQUE_PER_RAW,
    CommandMode,
    Feedback,
    decode_feedback,
    encode_command,
)
from spiraltrunk.hardware.motors.gm6020_motors import GM6020Motors
from spiraltrunk.hardware.safety.watchdog import (
    ANSWER_ID,
    CLEAR_FLAG,
    HEARTBEAT_FORMAT,
    HEARTBEAT_ID,
    RELEASE,
    TIMEOUT,
    BoardMode,
)
from spiraltrunk.hardware.twin.assembly import AssemblyOptions, build_twin
from spiraltrunk.hardware.twin.clock import TwinClock
from spiraltrunk.hardware.twin.motor import MotorParameters, MotorTwin
from spiraltrunk.hardware.twin.motors import FeedbackNoise, MotorTwins
from spiraltrunk.hardware.twin.trunk.anchor import Anchor
from spiraltrunk.hardware.twin.trunk.spring_trunk import SpringTrunk

from .conftest import Setup, feedback_of

LOOSE = Anchor(10.0, 10.0, 10.0)


@pytest.mark.parametrize(("period", "count"), [(1e-3, 1000), (2e-3, 500), (1e-2, 100)])
def test_every_motor_answers_at_its_rate(build: Callable[..., Setup], period: float, count: int) -> None:
    frames = build(feedback_period=period).run(1.0)
    for identifier in (0x205, 0x206, 0x207):
        times = [frame.time for frame in frames if frame.id == identifier]
        assert len(times) == count
        assert times == pytest.approx([period * (k + 1) for k in range(count)])
    assert len(frames) == 3 * count


def test_feedback_is_the_codecs_frame_of_the_motors_state(build: Callable[..., Setup]) -> None:
    setup = build(LOOSE, encoder_start=100, ambient=25.4)
    setup.command(0.2, 0.0, -0.2)
    frames = setup.run(0.3)
    for motor_id, motor in enumerate(setup.motors.motors, 1):
        last = next(frame for frame in reversed(frames) if frame.id == 0x204 + motor_id)
        rpm = round(motor.speed * 60 / math.tau)
        current = round(motor.current / 3.0 * 16384)
        count = (100 + math.floor(motor.angle / math.tau * 8192)) % 8192
        assert decode_feedback(last.data) == Feedback(count, rpm, current, 25)
        assert len(last.data) == 8
    assert setup.motors.motors[0].speed > 1.0
    assert setup.motors.motors[2].speed < -1.0


def test_the_last_digit_of_a_motor_at_rest_fluctuates_and_the_seed_repeats_it(build: Callable[..., Setup]) -> None:
    def rest(seed: int, noise: FeedbackNoise) -> list[Feedback]:
        setup = build(LOOSE, encoder_start=100, seed=seed, noise=noise)
        return feedback_of(setup.run(2.0))

    noisy = rest(1, FeedbackNoise(encoder=0.3, current=1.0))
    currents = [feedback.current for feedback in noisy]
    assert statistics.pstdev(currents) == pytest.approx(math.sqrt(1.0 + 1.0 / 12.0), abs=0.06)
    assert abs(statistics.fmean(currents)) < 0.1
    angles = [feedback.angle for feedback in noisy]
    assert statistics.fmean(angles) == pytest.approx(99.5, abs=0.05), "the rotor stands at the edge of a count"
    assert {99, 100} <= set(angles) <= {98, 99, 100, 101}
    assert rest(1, FeedbackNoise(encoder=0.3, current=1.0)) == noisy
    assert rest(2, FeedbackNoise(encoder=0.3, current=1.0)) != noisy
    assert len(set(rest(1, FeedbackNoise(encoder=0.0, current=0.0)))) == 1
    with pytest.raises(DesignError, match=r"noise\.current"):
        FeedbackNoise(current=-1.0)


def test_a_reversed_motor_tells_the_opposite(build: Callable[..., Setup]) -> None:
    setup = build(LOOSE, is_reversed=True)
    setup.motors.motors[0].speed = 10.0
    first = feedback_of(setup.run(1e-3))[0]
    assert first.speed_rpm < 0
    setup.command(0.5, 0.0, 0.0)
    setup.run(0.05)
    assert setup.motors.motors[0].wound < 0.0  # Its command has the sign of its feedback.


def test_a_field_that_is_too_small_is_limited(build: Callable[..., Setup]) -> None:
    setup = build(LOOSE)
    motor = setup.motors.motors[0]
    motor.speed, motor.temperature, motor.is_blocked = 1e5, 999.0, False
    data = next(frame.data for frame in setup.run(1e-3) if frame.id == 0x205)
    assert data[2:4] == b"\x7f\xff"
    assert data[6] == 255


def test_the_last_command_is_held_when_commands_stop(build: Callable[..., Setup]) -> None:
    setup = build()
    setup.motors.motors[1].is_blocked = True
    setup.command(0.0, 1.0, 0.0)
    setup.run(10.0)
    assert setup.motors.motors[1].torque == pytest.approx(1.0, abs=TORQUE_PER_RAW)


@pytest.mark.parametrize(
    "frame",
    [
        Frame(CommandMode.VOLTAGE.value, encode_command([20000, 0, 0, 0], CommandMode.VOLTAGE)),
        Frame(CommandMode.CURRENT.value, b"\x10\x00\x10\x00\x10\x00\x10"),
        Frame(CommandMode.CURRENT.value, b""),
        Frame(CommandMode.CURRENT.value + 0x100, encode_command([9000] * 4, CommandMode.CURRENT)),
        Frame(0x123, b"\xff" * 8),
    ],
)
def test_what_is_no_command_for_these_motors_changes_nothing(build: Callable[..., Setup], frame: Frame) -> None:
    setup = build()
    setup.bus.send(frame)
    setup.bus.flush()
    setup.run(0.02)
    assert [motor.current for motor in setup.motors.motors] == [0.0] * 3


def test_no_frame_whatever_breaks_the_motors(build: Callable[..., Setup]) -> None:
    """100,000 random frames, most of them with ids that mean something here, under a watchdog or without one."""
    chance = random.Random(3)
    for is_watched in (False, True):
        setup = build(SpringTrunk(PAPER), is_watched=is_watched)
        for _ in range(500):
            for _ in range(100):
                identifier = chance.choice((0x1FE, 0x1FF, 0x2FE, 0x205, HEARTBEAT_ID, chance.randrange(0x800)))
                setup.bus.send(Frame(identifier, chance.randbytes(chance.randrange(9))))
                setup.bus.flush()
            setup.run(1e-3)
        for motor, tension in zip(setup.motors.motors, setup.motors.tensions, strict=True):
            assert abs(motor.current) <= 3.0
            assert abs(motor.speed) < 2 * GM6020.speed_max
            assert 0.0 <= tension < 1e4
        assert len(feedback_of(setup.run(0.01))) == 10


def test_finer_substeps_give_the_same_pull() -> None:
    ends = []
    for substeps in (1, 4):
        clock = TwinClock()
        driver, device = build_memory_pair(clock)
        trunk = SpringTrunk(PAPER)
        twins = MotorTwins(device, trunk, [MotorTwin(MotorParameters()) for _ in range(3)], substeps=substeps)
        clock.attach(twins)
        GM6020Motors(driver, motor_ids=(1, 2, 3)).send([0.2, 0.05, 0.05])
        clock.sleep_until(0.5)
        ends.append(trunk.taken[0])
    assert ends[0] == pytest.approx(ends[1], rel=0.01)


def test_a_command_beyond_the_motors_current_is_limited_by_it(build: Callable[..., Setup]) -> None:
    setup = build()
    setup.motors.motors[0].is_blocked = True
    setup.bus.send(Frame(CommandMode.CURRENT.value, b"\x7f\xff" + bytes(6)))
    setup.bus.flush()
    frames = setup.run(0.05)
    assert setup.motors.motors[0].current == pytest.approx(3.0)
    assert feedback_of(frames)[-1].current == CURRENT_RAW


def test_ids_beyond_four_have_their_own_frame() -> None:
    clock = TwinClock()
    driver, device = build_memory_pair(clock)
    twins = MotorTwins(device, LOOSE, [MotorTwin(MotorParameters()) for _ in range(3)], motor_ids=(2, 5, 7))
    clock.attach(twins)
    motors = GM6020Motors(driver, motor_ids=(2, 5, 7))
    for twin in twins.motors:
        twin.is_blocked = True
    motors.send([0.1, 0.2, 0.3])
    clock.sleep_until(0.02)
    assert [motor.torque for motor in twins.motors] == pytest.approx([0.1, 0.2, 0.3], abs=TORQUE_PER_RAW)
    assert None not in motors.read()


def test_the_driver_reads_what_the_twin_does() -> None:
    """Over 2 s and many turns: angle within a step of the encoder, speed within half a turn per minute."""
    clock = TwinClock()
    driver, device = build_memory_pair(clock)
    parameters = MotorParameters(encoder_start=8000)
    twins = MotorTwins(device, LOOSE, [MotorTwin(parameters) for _ in range(3)])
    clock.attach(twins)
    motors = GM6020Motors(driver, motor_ids=(1, 2, 3))
    clock.sleep_until(1e-3)
    motors.read()
    for k in range(1000):
        motors.send([0.1, 0.4 * math.sin(0.01 * k), -0.2])
        clock.sleep_until(1e-3 + 2e-3 * (k + 1))
        for twin, state in zip(twins.motors, motors.read(), strict=True):
            assert state is not None
            assert state.angle == pytest.approx(twin.angle, abs=math.tau / 8192 + 1e-9)
            assert state.speed == pytest.approx(twin.speed, abs=0.5 * math.tau / 60 + 1e-9)
            assert not state.is_count_lost
    assert twins.motors[0].angle > 3 * math.tau


def test_thirty_newtons_curl_the_papers_trunk() -> None:
    """Torque T r on each drum: the pulled cable's tension is the model's within friction, and the others go slack."""
    clock = TwinClock()
    driver, device = build_memory_pair(clock)
    p = MotorParameters()
    trunk = SpringTrunk(PAPER)
    twins = MotorTwins(device, trunk, [MotorTwin(p) for _ in range(3)])
    clock.attach(twins)
    motors = GM6020Motors(driver, motor_ids=(1, 2, 3))
    motors.send([30.0 * p.drum_radius, p.friction, p.friction])
    clock.sleep_until(4.0)
    assert twins.tensions[0] == pytest.approx(30.0, abs=p.friction / p.drum_radius + 0.1)
    assert trunk.taken[0] == pytest.approx(0.129, abs=2e-3)
    assert trunk.taken[1] == pytest.approx(-0.058, abs=2e-3)


def test_motors_survive_a_bus_that_is_off() -> None:
    clock = TwinClock()
    driver, device = build_memory_pair(clock)
    twins = MotorTwins(device, Anchor(), [MotorTwin(MotorParameters()) for _ in range(3)])
    twins.motors[0].is_blocked = True
    clock.attach(twins)
    motors = GM6020Motors(driver, motor_ids=(1, 2, 3))
    motors.send([0.5, 0.0, 0.0])
    clock.sleep_until(0.02)
    driver.receive()
    device.set_off(True)
    clock.sleep_until(0.12)
    assert driver.receive() == []
    assert twins.motors[0].torque == pytest.approx(0.5, abs=TORQUE_PER_RAW)
    device.set_off(False)
    clock.sleep_until(0.22)
    assert len(driver.receive()) == 300


def test_in_real_time_a_driver_finds_its_motors() -> None:
    """The twin runs in a thread by the computer's clock, and answers as in simulated time."""
    twin = build_twin(PAPER, AssemblyOptions(is_watched=False), clock=SystemClock())
    motors = GM6020Motors(twin.bus, motor_ids=(1, 2, 3))
    with twin.in_real_time():
        motors.send([0.3, 0.0, 0.0])
        deadline = time.monotonic() + 60.0
        while (state := motors.read()[0]) is None or state.angle < 0.1:
            assert time.monotonic() < deadline
            time.sleep(1e-3)
    assert twin.motors.motors[0].angle > 0.1
    assert twin.board is None


def test_ids_that_do_not_fit_the_motors_are_refused() -> None:
    _, device = build_memory_pair(TwinClock())
    with pytest.raises(DriveError, match="2 motor ids for 1"):
        MotorTwins(device, LOOSE, [MotorTwin(MotorParameters())], motor_ids=(1, 2))
    with pytest.raises(DriveError, match="no two alike"):
        MotorTwins(device, LOOSE, [MotorTwin(MotorParameters())] * 2, motor_ids=(1, 1))


class Host:
    """Sends heartbeats with every command."""

    def __init__(self, setup: Setup) -> None:
        self.setup, self.counter = setup, 0

    def beat(self, torque: float, duration: float, flags: int = 0) -> list[Frame]:
        """Command motor 1 at 500 Hz, with heartbeats."""
        frames = []
        for _ in range(round(duration / 2e-3)):
            self.counter += 1
            self.setup.bus.send(Frame(HEARTBEAT_ID, HEARTBEAT_FORMAT.pack(self.counter, flags)))
            self.setup.command(torque, 0.0, 0.0)
            frames += self.setup.run(2e-3)
        return frames


def test_a_board_lets_nothing_pass_before_the_first_heartbeat(build: Callable[..., Setup]) -> None:
    setup = build(is_watched=True)
    board = setup.board
    assert board is not None
    setup.command(0.5, 0.0, 0.0)
    setup.run(0.1)
    assert setup.motors.motors[0].current == 0.0
    assert board.mode is BoardMode.WAITING


def test_a_dead_host_loses_its_torque_by_a_ramp(build: Callable[..., Setup]) -> None:
    """Held for the timeout, then less in every millisecond, and none after the release time; it stays so."""
    setup = build(is_watched=True)
    board = setup.board
    assert board is not None
    motor = setup.motors.motors[0]
    motor.is_blocked = True
    host = Host(setup)
    frames = host.beat(0.5, 0.1)
    assert motor.torque == pytest.approx(0.5, abs=0.01)
    answers = [frame for frame in frames if frame.id == ANSWER_ID]
    assert len(answers) == 50
    assert HEARTBEAT_FORMAT.unpack(answers[-1].data) == (50, BoardMode.WATCHING)
    torques = []
    for _ in range(100):
        setup.run(1e-3)
        torques.append(motor.torque)
    held = round(TIMEOUT / 1e-3) - 5
    assert torques[held] == pytest.approx(0.5, abs=0.01)
    ramp = torques[round(TIMEOUT / 1e-3) + 2 : round((TIMEOUT + RELEASE) / 1e-3) - 2]
    assert all(-0.05 < later - earlier < 0 for earlier, later in pairwise(ramp))
    assert torques[-1] == pytest.approx(0.0, abs=1e-6)
    assert board.mode is BoardMode.TRIPPED
    host.beat(0.5, 0.1)
    assert motor.torque == pytest.approx(0.0, abs=1e-6)
    host.beat(0.2, 0.1, CLEAR_FLAG)
    assert motor.torque == pytest.approx(0.2, abs=0.01)


def test_without_a_board_a_dead_host_leaves_its_torque(build: Callable[..., Setup]) -> None:
    setup = build()
    setup.motors.motors[0].is_blocked = True
    Host(setup).beat(0.5, 0.1)
    setup.run(1.0)
    assert setup.motors.motors[0].torque == pytest.approx(0.5, abs=0.01)
