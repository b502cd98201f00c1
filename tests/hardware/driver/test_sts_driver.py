"""The driver on STS servos: their twin answers in memory, and once at the other end of a pseudo-terminal."""

from __future__ import annotations

import pytest

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.hardware.twin.faults.device_faults import CableBreak, CableSlip, PowerCycle, TangledDrum
from spiraltrunk.hardware.twin.sts_servo import ServoTwin

PERIOD = 0.01
TIME_BAR, LENGTH_BAR = 0.2, 3e-3
"""A cable that breaks or slips is noticed within one of them [s], [m]."""
PULL = (20.0, 10.0, 10.0)


@pytest.mark.parametrize("has_terminal", [True, pytest.param(False, marks=pytest.mark.slow)])
@pytest.mark.slow
def test_servos_are_homed_and_pull(build_sts, has_terminal):
    robot = build_sts(has_terminal=has_terminal)
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


@pytest.mark.slow
def test_an_encoder_that_wraps_makes_no_jump(build_sts):
    pulls = []
    for start in (1000, 4095):
        robot = build_sts(encoder_start=start)
        robot.prepare()
        robot.run(3.0, (20.0, 10.0, 10.0))
        assert robot.driver.faults == ()
        pulls.append([cable.pull for cable in robot.driver.snapshot().cables])
        print([1e3 * (pull - motor.wound) for pull, motor in zip(pulls[-1], robot.twin.motors, strict=True)])
    assert pulls[1] == pytest.approx(pulls[0], abs=1e-3)


@pytest.mark.parametrize("fault", [PowerCycle(), TangledDrum()])
def test_a_fault_of_servo_or_drum_ends_the_torque(build_sts, fault):
    robot = build_sts()
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
def test_a_cable_that_breaks_or_slips_is_noticed_before_much_of_it_comes_in(build_sts, fault, tension):
    robot = build_sts()
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


def test_a_fault_that_a_servo_reports_ends_the_torque_and_keeps_it_off(build_sts, monkeypatch):
    robot = build_sts()
    robot.prepare()
    robot.run(0.5, PULL)
    errors = property(lambda servo: 32 if servo is robot.twin.servos[1] else 0)
    monkeypatch.setattr(ServoTwin, "errors", errors)
    robot.run(0.1, PULL)
    first = robot.driver.faults[0]
    assert (first.kind, first.cable) == (FaultKind.MOTOR, 1)
    assert first.text == "the motor reports a fault: overload; switch it off and on"
    assert robot.is_off()
    robot.driver.clear_fault("Ada")
    with pytest.raises(DriveError, match="cannot home: motor 2: the motor reports a fault: overload"):
        robot.driver.home()
    monkeypatch.undo()
    robot.run(0.1)
    robot.driver.home()


def test_hard_pulls_that_change_at_once_are_no_fault(build_sts):
    robot = build_sts()
    robot.prepare()
    for tension in ((45.0, 0.0, 0.0), (0.0, 60.0, 0.0), (60.0, 60.0, 0.0), (30.0, 30.0, 30.0)):
        robot.run(1.5, tension)
        assert robot.driver.faults == ()
