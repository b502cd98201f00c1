"""One contract for every family of motors, each on its twin: what winders rely on."""

import math
import time
from abc import ABC, abstractmethod

import pytest

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.bus.frame_bus import FrameBus
from spiraltrunk.hardware.bus.memory_bus import build_memory_pair
from spiraltrunk.hardware.motors.gm6020 import CommandMode
from spiraltrunk.hardware.motors.gm6020_motors import GM6020Motors
from spiraltrunk.hardware.motors.serial_port import open_serial
from spiraltrunk.hardware.motors.sts.servos import StsServos, StsSettings
from spiraltrunk.hardware.twin.clock import TwinClock
from spiraltrunk.hardware.twin.motor import MotorParameters, MotorTwin
from spiraltrunk.hardware.twin.motors import MotorTwins
from spiraltrunk.hardware.twin.sts_bus import MemoryStream, PseudoTerminal, StsTwin
from spiraltrunk.hardware.twin.sts_servo import STS3215, ServoTwin
from spiraltrunk.hardware.twin.trunk.anchor import Anchor

SLACK = 10.0  # Cables of this slack [m] load no motor.


class Rig(ABC):
    """Motors on a twin; the second is mounted the other way round."""

    port = None
    clock = None

    def run(self, seconds, torques=None):
        """Read, and send torques where they are given, every period; the last states."""
        period = self.port.data_sheet.period
        for _ in range(round(seconds / period)):
            if torques is not None:
                self.port.send(torques)
            self.settle()
            self.clock.sleep_until(self.clock.now() + period)
            self.settle()
            states = self.port.read()
        return states

    @abstractmethod
    def settle(self):
        """Wait until the bytes that are under way have arrived."""

    @abstractmethod
    def set_silent(self, is_silent):
        """Let the motors answer no more, or again."""

    @abstractmethod
    def find_motors(self):
        """Their true states."""

    @abstractmethod
    def count_commands(self):
        """Commands that arrived."""


class StsRig(Rig):
    def __init__(self):
        reversed_motor = type(STS3215)(**{**_fields(STS3215), "is_reversed": True, "encoder_start": 5})
        servos = [ServoTwin(7), ServoTwin(1, reversed_motor), ServoTwin(3)]
        self.twin = StsTwin(Anchor(SLACK, SLACK, SLACK), servos)
        self.clock = TwinClock(self.twin)
        self.settings = StsSettings(port="twin", servo_ids=(7, 1, 3), directions=(1, -1, 1))
        self.open()

    def open(self):
        self.port = StsServos.from_settings(self.settings, self.clock, stream=MemoryStream(self.twin))

    def settle(self):
        """Nothing is under way in memory."""

    def set_silent(self, is_silent):
        self.twin.faults.is_silent = is_silent

    def find_motors(self):
        return [servo.motor for servo in self.twin.servos]

    def count_commands(self):
        return self.twin.n_command

    def close(self):
        self.port.close()


class CountingStream:
    """A serial port whose bytes are counted."""

    def __init__(self, port):
        self.port, self.n_read, self.n_written, self.is_closed = port, 0, 0, False

    def read(self, size):
        data = self.port.read(size)
        self.n_read += len(data)
        return data

    def write(self, data):
        written = self.port.write(data)
        self.n_written += written
        return written

    def close(self):
        self.is_closed = True
        self.port.close()


class PseudoTerminalRig(StsRig):
    """The same through the operating system, pyserial and a thread."""

    def open(self):
        self.terminal = PseudoTerminal(self.twin)
        self.serving = self.terminal.serving()
        self.stream = CountingStream(open_serial(self.serving.__enter__(), 1_000_000))
        self.port = StsServos.from_settings(self.settings, self.clock, stream=self.stream)

    def settle(self):
        """Wait until everything written was answered, and the answers can be read."""
        end = time.monotonic() + 20.0
        while not self.is_settled() and time.monotonic() < end:
            time.sleep(1e-4)

    def is_settled(self):
        stream, terminal = self.stream, self.terminal
        if stream.is_closed:
            return terminal.n_received == stream.n_written
        arrived = stream.n_read + stream.port._port.in_waiting
        return terminal.n_received == stream.n_written and arrived == terminal.n_sent

    def close(self):
        self.port.close()
        self.serving.__exit__(None, None, None)
        self.terminal.close()


class Gm6020Rig(Rig):
    """GM6020 motors on a bus in memory."""

    def __init__(self):
        self.clock = TwinClock()
        bus, self.far_end = build_memory_pair(self.clock)
        self.commands = CountingBus(self.far_end)
        motors = [MotorTwin(MotorParameters(is_reversed=i == 1, encoder_start=5)) for i in range(3)]
        load = Anchor(SLACK, SLACK, SLACK)
        self.twin = MotorTwins(self.commands, load, motors, motor_ids=(2, 1, 3))
        self.clock.attach(self.twin)
        self.port = GM6020Motors(bus, motor_ids=(2, 1, 3), directions=(1, -1, 1))

    def settle(self):
        """Nothing is under way in memory."""

    def set_silent(self, is_silent):
        self.far_end.set_off(is_silent)

    def find_motors(self):
        return self.twin.motors

    def count_commands(self):
        self.clock.sleep_until(self.clock.now() + 1e-3)  # Receives what was sent.
        return self.commands.n_command

    def close(self):
        self.port.close()


class CountingBus(FrameBus):
    """A bus whose received commands are counted."""

    def __init__(self, bus):
        self.bus, self.n_command = bus, 0

    def send(self, frame):
        self.bus.send(frame)

    def flush(self):
        self.bus.flush()

    def close(self):
        self.bus.close()

    def receive(self):
        frames = self.bus.receive()
        self.n_command += sum(frame.id == CommandMode.CURRENT.value for frame in frames)
        return frames


def _fields(instance):
    return {name: getattr(instance, name) for name in type(instance).__dataclass_fields__}


@pytest.fixture(params=[Gm6020Rig, StsRig, PseudoTerminalRig])
def rig(request):
    made = request.param()
    yield made
    made.close()


def test_feedback_is_fresh_after_the_start(rig):
    states = rig.run(5 * rig.port.data_sheet.period)
    assert len(states) == rig.port.n_motor == 3
    for state in states:
        assert rig.clock.now() - state.time <= 3 * rig.port.data_sheet.period
        assert state.angle == state.speed == state.torque == 0.0
        assert state.temperature == pytest.approx(25.0, abs=1.0)
        assert not state.is_count_lost


@pytest.mark.parametrize(
    "torques",
    [
        [math.nan, 0.0, 0.0],
        [0.0, math.inf, 0.0],
        [0.0, 0.0, -math.inf],
        [0.0, 0.0],
        [0.0] * 4,
        [],
        [0.0, 1e9, 0.0],
        [0.0, 0.0, "1"],
        [None, 0.0, 0.0],
    ],
)
def test_bad_torques_are_refused_and_nothing_is_sent(rig, torques):
    rig.run(2 * rig.port.data_sheet.period, [0.0, 0.0, 0.0])
    sent = rig.count_commands()
    with pytest.raises(DriveError) as refused:
        rig.port.send(torques)
    assert "\n" not in str(refused.value)
    assert "allowed" in str(refused.value)
    rig.settle()
    assert rig.count_commands() == sent


def test_the_largest_torque_is_allowed_and_a_little_more_is_not(rig):
    limit = rig.port.data_sheet.torque_max
    rig.port.send([limit, -limit, 0.0])
    with pytest.raises(DriveError):
        rig.port.send([limit * (1 + 1e-9), 0.0, 0.0])


def test_a_positive_torque_winds_in_however_the_motor_is_mounted(rig):
    torque = 0.4 * rig.port.data_sheet.torque_max
    states = rig.run(0.3, [torque, torque, -torque])
    for state, motor, sign in zip(states, rig.find_motors(), (1, 1, -1), strict=True):
        assert sign * motor.angle > 0.1
        assert sign * state.angle > 0.1
        assert sign * state.speed > 0.1
        assert 0.0 < sign * state.torque <= 1.02 * torque  # Less where the speed leaves no voltage for more.
        assert abs(state.speed) <= rig.port.data_sheet.speed_max


def test_turns_are_counted_through_the_wrap(rig):
    rig.run(2 * rig.port.data_sheet.period)
    torque = 0.8 * rig.port.data_sheet.torque_max
    states = rig.run(2.5, [torque, torque, -torque])
    for state, motor, sign in zip(states, rig.find_motors(), (1, 1, -1), strict=True):
        assert sign * state.angle > math.tau
        # The feedback is as old as its time says.
        assert state.angle == pytest.approx(motor.angle, abs=motor.speed * sign * 0.02 + 0.01)
        assert not state.is_count_lost


def test_feedback_ages_when_the_motors_are_silent(rig):
    before = rig.run(0.1, [0.0] * 3)
    rig.set_silent(True)
    silence = 0.5 * rig.port.data_sheet.silence_max
    after = rig.run(silence, [0.0] * 3)
    for old, new in zip(before, after, strict=True):
        assert new.time - old.time <= rig.port.data_sheet.period
        assert rig.clock.now() - new.time >= 0.8 * silence
    rig.set_silent(False)
    for state in rig.run(0.1, [0.0] * 3):
        assert rig.clock.now() - state.time <= 3 * rig.port.data_sheet.period
        assert not state.is_count_lost


def test_the_count_is_lost_after_a_long_silence_until_it_is_restarted(rig):
    rig.run(0.1, [0.0] * 3)
    rig.set_silent(True)
    rig.run(1.2 * rig.port.data_sheet.silence_max, [0.0] * 3)
    rig.set_silent(False)
    assert all(state.is_count_lost for state in rig.run(0.1, [0.0] * 3))
    angles = [state.angle for state in rig.port.read()]
    rig.port.restart_count()
    states = rig.run(0.1, [0.0] * 3)
    assert not any(state.is_count_lost for state in states)
    assert [state.angle for state in states] == pytest.approx(angles, abs=0.01)


def test_close_ends_the_torque_and_may_be_repeated(rig):
    rig.run(0.1, [0.3 * rig.port.data_sheet.torque_max] * 3)
    rig.port.close()
    rig.port.close()
    rig.settle()
    rig.clock.sleep_until(rig.clock.now() + 0.5)
    for motor in rig.find_motors():
        assert motor.current == pytest.approx(0.0, abs=1e-3)
        assert motor.speed == 0.0
    with pytest.raises(DriveError):
        rig.port.send([0.0] * 3)
