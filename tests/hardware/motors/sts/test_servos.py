"""STS servos on their twin: the start, bytes on the wire, faults of line and servos."""

import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.errors import DesignError, DriveError
from spiraltrunk.hardware.motors.serial_port import open_serial
from spiraltrunk.hardware.motors.sts import codec
from spiraltrunk.hardware.motors.sts.discovery import discover
from spiraltrunk.hardware.motors.sts.models import COMPENSATION, MODELS, compute_duty, estimate_torque
from spiraltrunk.hardware.motors.sts.request_times import QUIET
from spiraltrunk.hardware.motors.sts.servos import StsServos, StsSettings
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.safety.watches.feedback_watch import find_stale
from spiraltrunk.hardware.twin.clock import TwinClock
from spiraltrunk.hardware.twin.faults.device_faults import CableBreak, IdSwap, OverTemperature, PowerCycle, Stall
from spiraltrunk.hardware.twin.sts_bus import MemoryStream, PseudoTerminal, StsTwin
from spiraltrunk.hardware.twin.sts_servo import ServoTwin
from spiraltrunk.hardware.twin.trunk.anchor import Anchor

PERIOD = 0.01
SETTINGS = StsSettings(port="twin", servo_ids=(1, 2, 3), directions=(1, 1, 1))


class RecordingStream:
    """A stream that keeps what was written."""

    def __init__(self, stream):
        self.stream, self.written = stream, []
        self.read, self.close = stream.read, stream.close

    def write(self, data):
        self.written.append(bytes(data))
        return self.stream.write(data)


class Bench:
    def __init__(self, *, slack=10.0, seed=0, settings=SETTINGS):
        self.twin = StsTwin(Anchor(slack, slack, slack), [ServoTwin(i) for i in (1, 2, 3)], seed=seed)
        self.clock = TwinClock(self.twin)
        self.stream = RecordingStream(MemoryStream(self.twin))
        self.port = StsServos.from_settings(settings, self.clock, stream=self.stream)

    def run(self, seconds, torques=(0.0, 0.0, 0.0), each=None):
        for _ in range(round(seconds / PERIOD)):
            self.port.send(torques)
            self.clock.sleep_until(self.clock.now() + PERIOD)
            states = self.port.read()
            if each is not None:
                each(states)
        return states


@pytest.fixture
def bench():
    return Bench()


def test_the_start_leaves_the_servos_on_in_the_mode_of_duty_cycles_at_rest(bench):
    for servo in bench.twin.servos:
        assert servo.mode == codec.MODE_PWM
        assert servo.is_on
        assert servo.duty == 0
    bench.clock.sleep_until(0.2)
    assert [servo.motor.angle for servo in bench.twin.servos] == [0.0, 0.0, 0.0]


def test_the_motors_are_off_while_the_mode_changes(bench):
    """A servo that is switched on in its mode of positions would run to a stored goal."""
    writes = [packet for data in bench.stream.written for packet in codec.take_packets(bytearray(data))]
    of_one = [(p.data[0], p.data[1]) for p in writes if p.servo_id == 1 and p.code == 3]
    assert of_one == [(40, 0), (55, 1), (33, 2), (44, 0), (45, 0), (40, 1)]


def test_one_period_on_the_wire(bench):
    """Sync write of -25 %, 0 and +50 % to register 44, then sync read of 8 bytes from 56."""
    bench.stream.written.clear()
    limit = bench.port.data_sheet.torque_max
    bench.port.send([-0.25 * limit, 0.0, 0.5 * limit])
    command, request = bench.stream.written
    assert command.hex() == "fffffe0d832c02" + "01fa04" + "020000" + "03f401" + "4a"
    assert request.hex() == "fffffe0782" + "3808" + "010203" + "32"
    assert len(command) + len(request) + 3 * 14 == 70  # 0.7 ms at 1 Mbit/s.


def test_reading_alone_brings_feedback(bench):
    bench.port.read()
    bench.clock.sleep_until(0.05)
    bench.port.read()
    states = bench.port.read()
    assert all(state is not None for state in states)
    assert states[0].voltage == pytest.approx(12.0)
    assert [state.problem for state in states] == [""] * 3


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"servo_ids": (1, 1, 3)}, "no id twice"),
        ({"servo_ids": ()}, "one id per motor"),
        ({"servo_ids": (1, 2, 254)}, "from 0 to 252"),
        ({"servo_ids": (1, 2, 3.0)}, "whole number"),
        ({"directions": (1, 1)}, "3 numbers"),
        ({"directions": (1, 0, 1)}, "1 or -1"),
        ({"model": "sts3032"}, "sts3215-12v or sts3215-7v4"),
        ({"port": ""}, "printable text"),
    ],
)
def test_settings_that_are_refused(changes, text):
    given = {"port": "twin", "servo_ids": (1, 2, 3), "directions": (1, 1, 1)} | changes
    with pytest.raises(DesignError, match=text):
        StsSettings(**given)


def _start(settings, servos):
    twin = StsTwin(Anchor(10.0, 10.0, 10.0), servos)
    return StsServos.from_settings(settings, TwinClock(twin), stream=MemoryStream(twin))


def test_an_absent_servo_is_named_by_motor_and_id():
    with pytest.raises(DriveError, match=r"motor 1 \(servo id 2\) on twin does not answer"):
        _start(SETTINGS, [ServoTwin(i) for i in (1, 5, 3)])


def test_a_supply_of_the_other_variant_is_refused():
    settings = StsSettings(port="twin", servo_ids=(1,), directions=(1,), model="sts3215-7v4")
    with pytest.raises(DriveError, match=r"servo id 1\) has 12.0 V; allowed: 5.9 to 8.9 V"):
        _start(settings, [ServoTwin(1)])


def test_data_sheet():
    """30 kgf cm is 2.94 N m and 45 rpm 4.71 rad/s (manufacturer's figures)."""
    sheet = MODELS["sts3215-12v"].data_sheet
    assert sheet.torque_max == pytest.approx(2.942, abs=1e-3)
    assert sheet.speed_max == pytest.approx(4.712, abs=1e-3)
    assert sheet.angle_step == math.tau / 4096
    assert sheet.silence_max < math.pi / sheet.speed_max


def test_the_twin_reaches_the_nominal_speed_less_friction(bench):
    limit = bench.port.data_sheet.torque_max
    states = bench.run(1.0, [limit] * 3)
    nominal = bench.port.data_sheet.speed_max
    assert states[0].speed == pytest.approx(nominal * (1 - 0.15 / limit), rel=0.02)


def test_a_stalled_servo_gives_the_torque_of_its_duty_cycle(bench):
    """At rest, duty * stall torque less nothing: friction acts against motion only, and the cable takes the rest."""
    taut = Bench(slack=0.0)
    limit = taut.port.data_sheet.torque_max
    taut.run(6.0, [0.5 * limit] * 3)
    radius = taut.twin.motors[0].parameters.drum_radius
    pull = taut.twin.tensions[0] * radius
    assert 0.5 * limit - 0.15 * 1.05 <= pull <= 0.5 * limit + 0.15 * 1.05
    assert taut.port.read()[0].torque == pytest.approx(0.5 * limit, rel=2e-3)


@pytest.mark.parametrize("loss", [0.01, 0.05])
def test_lost_bytes_age_the_feedback_and_lose_no_turn(loss):
    bench = Bench(seed=3)
    bench.twin.faults.loss = loss
    ages = []
    torque = 0.5 * bench.port.data_sheet.torque_max
    states = bench.run(6.0, [torque] * 3, lambda found: ages.extend(bench.clock.now() - s.time for s in found if s))
    print(f"loss {loss:.0%}: age of the feedback {max(ages) * 1e3:.0f} ms at most")
    assert max(ages) > 1.5 * PERIOD  # Some were lost.
    assert max(ages) < 0.05
    for state, motor in zip(states, bench.twin.motors, strict=True):
        assert not state.is_count_lost
        assert state.angle == pytest.approx(motor.angle, abs=0.2)


def test_changed_bytes_are_noticed():
    bench = Bench(seed=4)
    bench.twin.faults.corruption = 0.2
    torque = 0.3 * bench.port.data_sheet.torque_max

    def check(states):
        for state in states:
            assert state is None or abs(state.speed) <= bench.port.data_sheet.speed_max
            assert state is None or state.voltage == pytest.approx(12.0)

    states = bench.run(3.0, [torque] * 3, check)
    for state, motor in zip(states, bench.twin.motors, strict=True):
        assert state.angle == pytest.approx(motor.angle, abs=0.3)


def test_answers_that_come_late_or_twice_move_nothing_wrong():
    bench = Bench(seed=5)
    bench.twin.faults.duplication = 0.5
    bench.twin.faults.delay = 0.012
    torque = 0.5 * bench.port.data_sheet.torque_max
    states = bench.run(2.0, [torque] * 3)
    for state, motor in zip(states, bench.twin.motors, strict=True):
        assert not state.is_count_lost
        assert state.angle == pytest.approx(motor.angle, abs=0.2)


def test_an_answer_one_period_late_loses_no_turn_at_full_speed(bench):
    """A request that the adapter holds back is measured up to one period after its time."""
    limit, count = bench.port.data_sheet.torque_max, 0
    bench.run(1.0, [limit] * 3)
    for late in (0.0, PERIOD, 0.0, 0.0, PERIOD, PERIOD, 0.0) * 10:
        bench.port.send([limit] * 3)
        bench.twin._answers.clear()
        bench.clock.sleep_until(bench.clock.now() + late)
        for servo in bench.twin.servos:
            bench.twin._answer(codec.Packet(servo.id, 2, bench.stream.written[-1][5:7]))
        bench.clock.sleep_until(bench.clock.now() + PERIOD - late)
        count += sum(state.is_count_lost for state in bench.port.read())
    assert bench.twin.motors[0].speed > 0.9 * bench.port.data_sheet.speed_max
    assert count == 0


@pytest.mark.parametrize("delay", [0.0, 0.004, 0.016, 0.1, 0.3])
def test_late_feedback_is_told_as_old_as_it_is(delay):
    """The servos measure when the request arrives; a steady speed gives the time at which an angle was reached."""
    bench = Bench()
    bench.run(0.05)  # Angles count from the first feedback.
    bench.twin.faults.delay = delay
    torque, ages = 0.3 * bench.port.data_sheet.torque_max, []

    def check(states):
        if states[0] is not None and bench.clock.now() > 1.0:
            age = (bench.twin.motors[0].angle - states[0].angle) / bench.twin.motors[0].speed
            ages.append(bench.clock.now() - states[0].time)
            assert ages[-1] == pytest.approx(age, abs=2e-3)

    states = bench.run(3.0, [torque] * 3, check)
    print(f"answers late by {1e3 * delay:g} ms: told as {1e3 * min(ages):.0f} to {1e3 * max(ages):.0f} ms old")
    assert min(ages) >= delay
    assert (delay > 0.04) == (find_stale(states[0], bench.clock.now(), SafetyLimits()) is not None)
    assert not any(state.is_count_lost for state in states) or delay > 0.1


def test_a_lost_answer_ages_no_later_one():
    bench, lost = Bench(), iter([False, False, True])  # Command, request, the first servo's answer.
    bench.run(0.1)
    damage = bench.twin._damage
    bench.twin._damage = lambda data: None if next(lost, False) else damage(data)
    after = [[bench.clock.now() - state.time for state in bench.run(PERIOD)] for _ in range(3)]
    assert after[0] == pytest.approx([2 * PERIOD, PERIOD, PERIOD])
    assert after[1:] == [pytest.approx([PERIOD] * 3)] * 2


@pytest.mark.parametrize("silence", [0.05, 0.08, 0.1, 0.3, 3.0])
def test_servos_that_were_silent_are_heard_again_and_no_answer_is_told_as_younger(bench, silence):
    limit = bench.port.data_sheet.torque_max
    bench.run(0.3, [0.3 * limit] * 3)
    bench.twin.faults.is_silent = True
    bench.run(silence, [0.3 * limit] * 3)
    bench.twin.faults.is_silent = False
    states = bench.run(QUIET + 4 * PERIOD, [0.3 * limit] * 3)
    for state, motor in zip(states, bench.twin.motors, strict=True):
        assert bench.clock.now() - state.time == pytest.approx(PERIOD)
        assert (motor.angle - state.angle) % math.tau == pytest.approx(PERIOD * motor.speed, abs=0.01)
        assert state.is_count_lost == (silence > 0.4)


def test_an_answer_that_was_not_asked_for_is_no_feedback(bench):
    states = bench.run(0.1)
    data = codec.encode_feedback(codec.Feedback(100, 500, 0, 12.0, 30.0))
    for size in range(codec.FEEDBACK_SIZE, codec.FEEDBACK_SIZE_MOST + 1):
        bench.twin._due += codec.encode_packet(codec.Packet(1, 0, data.ljust(size, b"\0")))
    assert bench.port.read() == states


def test_frozen_feedback_is_passed_on_as_it_is(bench):
    """Time goes on and nothing else: it is for the safety layer to notice."""
    bench.run(0.2, [1.0] * 3)
    bench.twin.servos[1].freeze(True)
    states = bench.run(0.1, [1.0] * 3)
    frozen = [bench.run(PERIOD, [1.0] * 3)[1].angle for _ in range(10)]
    assert len(set(frozen)) == 1
    assert bench.run(PERIOD, [1.0] * 3)[0].angle > states[0].angle


def test_a_power_cycle_leaves_a_servo_limp_and_makes_no_jump(bench):
    states = bench.run(0.5, [1.0] * 3)
    before = states[0].angle
    fault = PowerCycle(cable=0)
    fault.begin(bench.twin)
    bench.run(0.3, [1.0] * 3)
    fault.end(bench.twin)
    states = bench.run(0.5, [1.0] * 3)
    servo = bench.twin.servos[0]
    assert servo.mode == 0
    assert not servo.is_on
    assert states[0].torque == 0.0
    assert abs(states[0].angle - before) < 0.5
    assert states[1].speed > 1.0


def test_a_power_cycle_longer_than_half_a_turn_loses_the_count(bench):
    bench.run(0.5, [1.0] * 3)
    fault = PowerCycle(cable=0)
    fault.begin(bench.twin)
    bench.run(1.1 * bench.port.data_sheet.silence_max)
    fault.end(bench.twin)
    states = bench.run(0.1)
    assert [state.is_count_lost for state in states] == [True, False, False]


def test_swapped_ids_lose_the_count(bench):
    bench.run(0.5, [1.5, 0.0, 0.0])
    IdSwap(cable=0, other=1).begin(bench.twin)
    states = bench.run(0.05)
    assert [state.is_count_lost for state in states] == [True, True, False]


def test_an_overheated_servo_says_so_and_switches_off(bench):
    fault = OverTemperature(cable=2, temperature=90.0, rate=50.0)
    states = bench.run(2.0, [0.5] * 3, lambda _: fault.step(bench.twin, 0.0))
    assert states[2].temperature > bench.port.data_sheet.temperature_stop
    assert [state.problem for state in states] == ["", "", "overheated"]
    assert states[2].torque == 0.0


def test_a_stall_shows_torque_without_speed(bench):
    Stall(cable=1).begin(bench.twin)
    states = bench.run(0.3, [1.0] * 3)
    assert states[1].speed == 0.0
    assert states[1].torque == pytest.approx(1.0, rel=0.01)
    assert states[0].speed > 0.5


def test_the_estimated_torque_is_the_motors_own_at_any_speed(bench):
    """Within the twin's law: at a constant speed it is the friction of the gears."""
    torque = 0.6 * bench.port.data_sheet.torque_max
    states = bench.run(1.0, [torque, -torque, 0.0])
    assert [state.torque for state in states] == pytest.approx([0.15, -0.15, 0.0], abs=0.02)
    assert states[0].speed > 2.0


def test_the_estimated_torque_follows_the_supply():
    model = MODELS["sts3215-12v"]
    limit = model.data_sheet.torque_max
    assert estimate_torque(model, 1.0, 0.0, 10.0) == pytest.approx(limit * 10 / 12)
    assert estimate_torque(model, 1.0, -4.0, 12.0) == limit


@given(st.floats(-0.5, 0.5), st.floats(-1.0, 1.0), st.floats(9.6, 14.4))
def test_a_commanded_torque_is_the_estimated_one_less_what_is_not_compensated(share, speed, voltage):
    model = MODELS["sts3215-12v"]
    limit, speed_max = model.data_sheet.torque_max, model.data_sheet.speed_max
    duty = compute_duty(model, share * limit, speed, voltage)
    rest = (1 - COMPENSATION) * speed / speed_max
    assert estimate_torque(model, duty, speed, voltage) == pytest.approx(limit * (share - rest), abs=1e-9)


def test_the_back_emf_is_compensated_only_by_a_fresh_speed_and_never_of_zero(bench):
    """A stale speed would drive a motor on that has stopped; zero torque brakes."""
    bench.run(0.5, [1.0] * 3)
    servo, stall = bench.twin.servos[0], 1000 / bench.port.data_sheet.torque_max
    assert servo.duty > 1.5 * stall
    bench.port.send([0.0] * 3)
    assert servo.duty == 0
    bench.clock.sleep_until(bench.clock.now() + 0.05)
    bench.port._collect = lambda: None
    bench.port.send([1.0] * 3)
    assert servo.duty == round(stall)


def test_a_broken_cable_lets_the_motor_run():
    bench = Bench(slack=0.0)
    bench.run(5.0, [1.0] * 3)
    CableBreak(cable=0).begin(bench.twin)
    states = bench.run(0.3, [1.0] * 3)
    assert states[0].speed > 1.0
    assert abs(states[1].speed) < 0.1


def test_an_adapter_that_is_unplugged(bench):
    bench.run(0.1)
    bench.twin.faults.is_gone = True
    for call in (bench.port.read, lambda: bench.port.send([0.0] * 3)):
        with pytest.raises(DriveError, match=r"serial port twin: .*plugged in"):
            call()
    bench.port.close()
    bench.port.close()


def test_a_host_that_dies_leaves_the_last_duty_cycle(bench):
    """The documented danger, which only a relay removes."""
    bench.run(0.1, [1.0] * 3)
    bench.clock.sleep_until(2.0)
    assert bench.twin.motors[0].speed > 1.0


def test_a_write_that_failed_once_does_not_keep_the_motors_on(bench):
    """Closing stops servos that hold a duty cycle, whatever failed before."""
    bench.run(0.1, [1.0] * 3)
    write = bench.stream.stream.write

    def fail(data):
        bench.stream.stream.write = write
        raise OSError("interrupted")

    bench.stream.stream = type("Once", (), {"write": staticmethod(fail)})()
    with pytest.raises(DriveError):
        bench.port.send([1.0] * 3)
    bench.port.close()
    assert not any(servo.is_on for servo in bench.twin.servos)


def test_closing_while_bytes_are_lost_still_stops_every_servo():
    bench = Bench(seed=8)
    bench.run(0.1, [1.0] * 3)
    lost = iter([True, False, True, False])  # The duty cycles, and the first servo's first answer.
    damage = bench.twin._damage
    bench.twin._damage = lambda data: None if next(lost, False) else damage(data)
    bench.port.close()
    assert not any(servo.is_on for servo in bench.twin.servos)


def _make_noise(source):
    """Bytes of nobody, or a sound packet of any content."""
    if source.random() < 0.3:
        return source.randbytes(source.randrange(20))
    data = source.randbytes(source.choice((0, 2, 8, 9, 15, 16)))
    if source.random() < 0.5:
        speed, load = source.randint(-12288, 12288), source.randint(-1000, 1000)
        data = codec.encode_feedback(codec.Feedback(source.randrange(4096), speed, load, 12.0, 30.0))
        data += source.randbytes(source.randrange(8))
    return codec.encode_packet(codec.Packet(source.randrange(5), source.randrange(128), data))


def fuzz(count):
    """Angles of the motors after frames of any content: the driver sends requests alone, its states stay finite."""
    source, bench = random.Random(1), Bench()
    bench.run(0.1)
    bench.stream.written.clear()
    n_believed = 0
    for i in range(count):
        bench.twin._due += _make_noise(source)
        if source.random() < 0.5:
            bench.twin._answers.clear()
        if i % 8 == 0:
            bench.clock.sleep_until(bench.clock.now() + PERIOD)
        for state in bench.port.read():
            n_believed += state is not None and abs(state.speed) > 0.0
            assert math.isfinite(state.angle)
            assert abs(state.speed) <= 3 * math.tau
            assert abs(state.torque) <= bench.port.data_sheet.torque_max
    assert n_believed > count // 4  # Sound packets in a servo's place: only plausibility and the count doubt them.
    assert all(data[4] == 0x82 for data in bench.stream.written)
    assert len(bench.port._received) < 64
    assert all(state.is_count_lost for state in bench.port.read())
    return [motor.angle for motor in bench.twin.motors]


def test_frames_of_any_content_move_nothing():
    assert fuzz(3000) == [0.0] * 3


@pytest.mark.slow
@pytest.mark.timeout(7200)
def test_ten_minutes_of_random_torques_on_a_poor_line_lose_no_turn():
    """1 % lost, late by up to 8 ms, cables that pull back: no turn is lost, no false alarm, nothing drifts."""
    bench, source = Bench(seed=6, slack=0.05), random.Random(7)
    limit, ages = bench.port.data_sheet.torque_max, []
    bench.twin.faults.loss = 0.01
    for _ in range(2000):
        bench.twin.faults.delay = source.uniform(0.0, 0.008)
        states = bench.run(0.3, [source.uniform(-0.3, 1.0) * limit for _ in range(3)])
        ages += [bench.clock.now() - state.time for state in states]
        assert not any(state.is_count_lost for state in states)
    bench.twin.faults.loss = bench.twin.faults.delay = 0.0
    states = bench.run(2.0)
    errors = [abs(state.angle - motor.angle) for state, motor in zip(states, bench.twin.motors, strict=True)]
    print(f"after 600 s: error {max(errors) * 1e3:.1f} mrad, age of the feedback {max(ages) * 1e3:.0f} ms at most")
    assert max(errors) < 2 * codec.STEP + 0.001


@pytest.mark.slow
@pytest.mark.timeout(7200)
def test_a_million_frames_of_any_content_move_nothing():
    assert fuzz(1_000_000) == [0.0] * 3


def test_discovery_by_pseudo_terminal():
    twin = StsTwin(Anchor(10.0, 10.0), [ServoTwin(2), ServoTwin(9)])
    terminal = PseudoTerminal(twin)
    with terminal.serving() as port:
        found = discover([port, "/dev/there-is-none"])
    terminal.close()
    assert found[0].models == {2: 777, 9: 777}
    assert found[0].problem == ""
    assert found[1].models == {}
    assert "cannot be opened" in found[1].problem
    assert "ports found" in found[1].problem


@pytest.mark.timeout(30)
def test_a_terminal_that_two_serve_never_waits_for_bytes_that_the_other_took():
    terminal = PseudoTerminal(StsTwin(Anchor(10.0), [ServoTwin(1)]))
    port = open_serial(terminal.port, 1_000_000)
    with terminal.serving():
        for _ in range(3000):
            port.write(b"\x00")
            terminal.serve()
    port.close()
    terminal.close()
    assert terminal.n_received > 0


def test_every_port_that_the_system_lists_is_asked_and_no_other(monkeypatch):
    names = ["COM3", "/dev/cu.usbmodem1101", "/dev/ttyACM0"]
    ports = [type("Port", (), {"device": name})() for name in names]
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: ports)
    opened = []

    def refuse(port, baud):
        opened.append((port, baud))
        raise DriveError("busy")

    monkeypatch.setattr("spiraltrunk.hardware.motors.sts.line.open_serial", refuse)
    assert [found.problem for found in discover()] == ["busy"] * 3
    assert opened == [(name, 1_000_000) for name in sorted(names)]
    ports.clear()
    assert discover() == []


def test_discovery_has_an_end(monkeypatch):
    """A line that chatters without pause ends each ping all the same."""

    class Chatter:
        def read(self, size):
            return b"\x00\xff\xff\x01"[: max(size, 0)] * 3

        def write(self, data):
            return len(data)

        def close(self):
            pass

    monkeypatch.setattr("spiraltrunk.hardware.motors.sts.line.open_serial", lambda *_: Chatter())
    assert discover(["COM3"], servo_ids=(1, 2), longest=0.05)[0].models == {}


def test_a_second_program_cannot_open_the_port():
    terminal = PseudoTerminal(StsTwin(Anchor(10.0), [ServoTwin(1)]))
    settings = StsSettings(port=terminal.port, servo_ids=(1,), directions=(1,))
    with terminal.serving():
        first = StsServos.from_settings(settings, TwinClock())
        with pytest.raises(DriveError, match="cannot be opened"):
            StsServos.from_settings(settings, TwinClock())
        first.close()
    terminal.close()
