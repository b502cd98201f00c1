"""The driver on STS servos: their twin answers in memory, and once at the other end of a pseudo-terminal."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace

import pytest

from spiraltrunk.design.drum import size_drum
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.driver.options import DriverOptions
from spiraltrunk.hardware.driver.trunk_driver import TrunkDriver
from spiraltrunk.hardware.motors.sts import line as sts_line
from spiraltrunk.hardware.motors.sts.servos import StsServos, StsSettings
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.hardware.safety.watchdog import NoWatchdog
from spiraltrunk.hardware.twin.clock import TwinClock
from spiraltrunk.hardware.twin.device import TwinDevice
from spiraltrunk.hardware.twin.faults.device_faults import CableBreak, CableSlip, PowerCycle, TangledDrum
from spiraltrunk.hardware.twin.sts_bus import MemoryStream, PseudoTerminal, StsTwin
from spiraltrunk.hardware.twin.sts_servo import STS3215, ServoTwin
from spiraltrunk.hardware.twin.trunk.spring_trunk import SpringTrunk
from spiraltrunk.hardware.winder.drum import DrumGeometry
from spiraltrunk.hardware.winder.winder import build_winder

PERIOD = 0.01
TIME_BAR, LENGTH_BAR = 0.2, 3e-3
"""A cable that breaks or slips is noticed within one of them [s], [m]."""
PULL = (20.0, 10.0, 10.0)


class Line(TwinDevice):
    """Serves the pseudo-terminal in simulated time."""

    def __init__(self, terminal: PseudoTerminal) -> None:
        self.terminal = terminal

    def advance(self, dt: float) -> None:
        self.terminal.serve()


class Robot:
    """Three servos in simulated time; with a terminal, the operating system carries their bytes."""

    def __init__(self, encoder_start: int = 1000, *, has_terminal: bool = False) -> None:
        drum = size_drum(PAPER)
        motor = replace(STS3215, drum_radius=drum.winding_radius, encoder_start=encoder_start)
        servos = [ServoTwin(i, replace(motor, wound=-0.002 * i)) for i in (1, 2, 3)]
        self.twin = StsTwin(SpringTrunk(PAPER), servos)
        self.clock = TwinClock()
        self.terminal = PseudoTerminal(self.twin) if has_terminal else None
        motors = self._open_terminal(self.terminal) if self.terminal else self._open_memory()
        self.clock.attach(self.twin)
        winder = build_winder(PAPER, motors.data_sheet, DrumGeometry(design=drum), PERIOD)
        options = DriverOptions(period=PERIOD, without_watchdog=True)
        self.driver = TrunkDriver(
            design=PAPER, motors=motors, winders=[winder] * 3, watchdog=NoWatchdog(), clock=self.clock,
            options=options,
        )  # fmt: skip

    def _open_terminal(self, terminal: PseudoTerminal) -> StsServos:
        with terminal.serving() as port:
            settings = StsSettings(port=port, servo_ids=(1, 2, 3), directions=(1, 1, 1))
            motors = StsServos.from_settings(settings, self.clock)
        self.clock.attach(Line(terminal))
        return motors

    def _open_memory(self) -> StsServos:
        settings = StsSettings(port="memory", servo_ids=(1, 2, 3), directions=(1, 1, 1))
        return StsServos.from_settings(settings, self.clock, stream=MemoryStream(self.twin))

    def close(self) -> None:
        with self.terminal.serving() if self.terminal else nullcontext():
            self.driver.close()
        if self.terminal:
            self.terminal.close()

    def run(self, seconds: float, tension: tuple[float, ...] | None = None) -> None:
        end = self.clock.now() + seconds
        while self.clock.now() < end:
            if tension is not None and self.driver.mode is Mode.ARMED:
                self.driver.set_targets(tension, valid_for=0.05)
            self.driver.wait()
            self.driver.tick()

    def prepare(self) -> None:
        self.run(0.2)
        self.driver.home()
        end = self.clock.now() + 60.0
        while self.driver.mode is Mode.HOMING and self.clock.now() < end:
            self.run(0.1)
        assert self.driver.faults == ()
        self.driver.arm()

    def is_off(self) -> bool:
        """Whether no servo is driven; one whose cable turns it still brakes."""
        return all(servo.duty == 0 for servo in self.twin.servos)


@pytest.fixture
def build(monkeypatch):
    robots = []

    def build(**options):
        # A thread answers on the terminal, on a computer that may be busy; in memory an answer is there at once.
        monkeypatch.setattr(sts_line, "ANSWER_TIME", 2.0 if options.get("has_terminal") else 0.01)
        try:
            robots.append(Robot(**options))
        except DriveError as error:
            if "pseudo-terminal" in str(error):
                pytest.skip(str(error))
            raise
        return robots[-1]

    yield build
    for robot in robots:
        robot.close()


@pytest.mark.parametrize("has_terminal", [True, False])
def test_servos_are_homed_and_pull(build, has_terminal):
    robot = build(has_terminal=has_terminal)
    robot.prepare()
    start = robot.twin.motors[0].wound
    robot.run(4.0, (45.0, 5.0, 5.0))
    assert robot.driver.faults == ()
    pulled = robot.twin.motors[0].wound - start
    print([round(one, 1) for one in robot.twin.tensions], f"{1e3 * pulled:.1f} mm")
    assert pulled > 0.01
    assert robot.twin.tensions[0] > robot.twin.tensions[1]
    robot.driver.disarm()
    robot.run(1.0)
    assert robot.driver.mode is Mode.SAFE
    assert robot.is_off()


def test_an_encoder_that_wraps_makes_no_jump(build):
    pulls = []
    for start in (1000, 4095):
        robot = build(encoder_start=start)
        robot.prepare()
        robot.run(3.0, (20.0, 10.0, 10.0))
        assert robot.driver.faults == ()
        pulls.append([cable.pull for cable in robot.driver.snapshot().cables])
        print([1e3 * (pull - motor.wound) for pull, motor in zip(pulls[-1], robot.twin.motors, strict=True)])
    assert pulls[1] == pytest.approx(pulls[0], abs=1e-3)


@pytest.mark.parametrize("fault", [PowerCycle(), TangledDrum()])
def test_a_fault_of_servo_or_drum_ends_the_torque(build, fault):
    robot = build()
    robot.prepare()
    robot.run(1.0, PULL)
    began = robot.clock.now()
    fault.begin(robot.twin)
    robot.run(2.0, PULL)
    first = robot.driver.faults[0]
    print(f"{fault.name}: {first.kind.value} after {1e3 * (first.time - began):.0f} ms: {first.text}")
    assert robot.driver.mode is Mode.FAULT
    assert first.time - began <= 1.0
    assert robot.is_off()


@pytest.mark.parametrize(
    ("fault", "tension"),
    [
        (CableBreak(), PULL),
        (CableSlip(length=0.01, cable=1), PULL),
        (CableSlip(length=0.005), PULL),
        (CableSlip(length=0.006), (30.0, 5.0, 5.0)),
    ],
)
def test_a_cable_that_breaks_or_slips_is_noticed_before_much_of_it_comes_in(build, fault, tension):
    robot = build()
    robot.prepare()
    robot.run(3.0, tension)
    fault.begin(robot.twin)
    began, motor = robot.clock.now(), robot.twin.motors[fault.cable]
    start = motor.wound
    while not robot.driver.faults and robot.clock.now() < began + 2.0:
        robot.run(PERIOD, tension)
    assert robot.driver.faults
    first, wound = robot.driver.faults[0], motor.wound - start
    print(f"{fault.name}: after {1e3 * (first.time - began):.0f} ms and {1e3 * wound:.1f} mm: {first.text}")
    assert first.time - began <= TIME_BAR or wound <= LENGTH_BAR
    robot.run(0.5)
    assert robot.is_off()


def test_hard_pulls_that_change_at_once_are_no_fault(build):
    robot = build()
    robot.prepare()
    for tension in ((45.0, 0.0, 0.0), (0.0, 60.0, 0.0), (60.0, 60.0, 0.0), (30.0, 30.0, 30.0)):
        robot.run(1.5, tension)
        assert robot.driver.faults == ()
