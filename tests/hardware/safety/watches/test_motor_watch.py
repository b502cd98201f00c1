"""Watches of the motor: temperature, voltage, stall."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from spiraltrunk.hardware.motors.motor_port import MotorDataSheet, MotorState
from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.safety.reading import CableReading
from spiraltrunk.hardware.safety.watches.motor_watch import (
    StallState,
    derate,
    find_hot,
    find_reported,
    watch_stall,
    watch_voltage,
)

SHEET = MotorDataSheet(
    name="test", torque_max=2.0, speed_max=30.0, torque_step=1e-4, angle_step=1e-3, period=1e-3, silence_max=0.1,
    temperature_derate=70.0, temperature_stop=90.0, rotor_inertia=1e-4, rotor_friction=0.02,
)  # fmt: skip
LIMITS = SafetyLimits(voltage_least=20.0, voltage_most=26.0)
DT = 0.002


def build(angle: float = 0.0, speed: float = 0.0, **others) -> MotorState:
    return MotorState(time=0.0, angle=angle, speed=speed, torque=0.0, **{"temperature": 30.0, **others})


@pytest.mark.parametrize(("temperature", "part"), [(20, 1), (70, 1), (75, 0.75), (80, 0.5), (90, 0), (120, 0)])
def test_the_tension_is_derated_linearly(temperature, part):
    assert derate(temperature, SHEET) == pytest.approx(part)


def test_a_motor_stops_at_its_temperature():
    assert find_hot(build(temperature=89.9), SHEET) is None
    found = find_hot(build(temperature=90.0), SHEET)
    assert found.kind is FaultKind.OVER_TEMPERATURE
    assert found.text == "the motor has 90 degC; allowed: below 90 degC"


def test_a_fault_that_the_motor_reports_is_told():
    assert find_reported(build()) is None
    found = find_reported(build(problem="overload"))
    assert found.kind is FaultKind.MOTOR
    assert found.text == "the motor reports a fault: overload; switch it off and on"


def watch_voltages(voltages: list[float | None]) -> int | None:
    elapsed = 0.0
    for number, voltage in enumerate(voltages):
        elapsed, found = watch_voltage(elapsed, build(voltage=voltage), DT, LIMITS)
        if found:
            assert found.kind is FaultKind.VOLTAGE
            return number
    return None


@pytest.mark.parametrize("good", [None, 20.0, 24.0, 26.0])
def test_a_good_voltage_is_fine(good):
    assert watch_voltages([good] * 1000) is None


@pytest.mark.parametrize("bad", [19.9, 26.1])
def test_a_bad_voltage_is_a_fault_after_100_ms(bad):
    assert watch_voltages([bad] * 1000) == pytest.approx(0.1 / DT, abs=1)
    assert watch_voltages([*[bad] * 40, 24.0] * 20) is None


def run_stall(
    torques: list[float], angles: list[float], speeds: list[float] | None = None, others: float = 0.0, sheet=SHEET
) -> int | None:
    state = StallState()
    for number, (torque, angle) in enumerate(zip(torques, angles, strict=True)):
        speed = speeds[number] if speeds else 0.0
        reading = CableReading(motor=build(angle=angle, speed=speed), torque=torque)
        state, found = watch_stall(state, reading, DT, sheet, LIMITS, others=others)
        if found:
            assert found.kind is FaultKind.STALL
            return number
    return None


def test_a_drum_that_stands_at_a_constant_tension_is_fine():
    assert run_stall([1.7] * 5000, [1.0] * 5000) is None
    assert run_stall([-1.7] * 5000, [1.0] * 5000) is None


@pytest.mark.parametrize("torque", [1.8, -1.8])
def test_a_motor_that_stands_at_its_largest_torque_is_stalled(torque):
    number = run_stall([torque] * 1000, [1.0] * 1000)
    assert number * DT == pytest.approx(LIMITS.stall_time, abs=2 * DT)
    turning = [0.0004 * i for i in range(1000)]
    assert run_stall([torque] * 1000, turning, [0.2] * 1000) is None
    assert run_stall([torque] * 1000, turning, [-0.2] * 1000) is None
    assert run_stall([torque] * 1000, turning, [0.19] * 1000) is not None
    assert run_stall(([torque] * 200 + [torque / 2] * 50) * 8, [0.01 * i for i in range(2000)]) is None


def test_a_drum_that_a_changing_torque_does_not_turn_is_blocked():
    needed = LIMITS.blocked_torque + 2 * SHEET.rotor_friction
    for change, is_blocked in ((1.01 * needed, True), (0.99 * needed, False)):
        up = run_stall([0.1] * 100 + [0.1 + change] * 400, [1.0] * 500)
        down = run_stall([0.1 + change] * 100 + [0.1] * 400, [1.0] * 500)
        assert up == down
        assert (up is not None) == is_blocked
    assert run_stall([0.1] * 100 + [0.5] * 400, [1.0] * 500) == pytest.approx(100 + LIMITS.blocked_time / DT, abs=2)


def test_a_geared_drum_may_stand_through_its_friction_and_what_is_compensated_of_it():
    """An STS servo's 0.15 N m hold both ways, 80 % of it are compensated, and a part of that is wrong."""
    geared = replace(SHEET, rotor_friction=0.15)
    needed = LIMITS.blocked_frictions * geared.rotor_friction
    assert needed > LIMITS.blocked_torque + 2 * geared.rotor_friction
    for change, is_blocked in ((1.01 * needed, True), (0.99 * needed, False)):
        number = run_stall([0.1] * 100 + [0.1 + change] * 400, [1.0] * 500, sheet=geared)
        assert (number is not None) == is_blocked


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_drum_that_turns_by_a_few_steps_is_not_blocked(sense):
    """15 N more stretch 0.6 m of braid by 0.75 mm: 75 mrad on 10 mm."""
    torques = [0.1] * 100 + [0.5] * 400
    assert run_stall(torques, [1.0] * 100 + [1.0 + sense * 0.0031] * 400) is None
    assert run_stall(torques, [1.0] * 100 + [1.0 + sense * 0.0029] * 400) is not None


def test_a_tension_that_swings_with_the_drum_is_fine():
    times = [DT * i for i in range(10000)]
    torques = [0.5 + 0.3 * math.sin(3 * t) for t in times]
    assert run_stall(torques, [1.0 + 0.02 * math.sin(3 * t) for t in times]) is None


def test_torques_of_before_are_forgotten_while_other_drums_explain_their_change():
    """A ramp of 6.7 N/s on 10 mm, as when a trunk squeezes an object: drums stand for seconds in nominal running."""
    ramp = [0.1 + 0.067 * DT * i for i in range(3000)]
    falling = [0.5 - torque for torque in ramp]
    little = 0.9 * LIMITS.blocked_motion
    assert run_stall(ramp, [1.0] * 3000, others=1e-3) is None
    assert run_stall(falling, [1.0] * 3000, others=-1e-3) is None
    assert run_stall([0.1 + 0.3 * DT * i for i in range(3000)], [1.0] * 3000, others=1e-3) is not None
    for torques, others in ((ramp, 0.0), (ramp, little), (ramp, -1e-3), (falling, 1e-3), (falling, -little)):
        number = run_stall(torques, [1.0] * 3000, others=others)
        needed = LIMITS.blocked_torque + 2 * SHEET.rotor_friction
        assert number * DT == pytest.approx(needed / 0.067 + LIMITS.blocked_time, abs=3 * DT)


@pytest.mark.parametrize(("others", "kept"), [(1e-3, "most"), (-1e-3, "least")])
def test_the_span_of_torques_decays_with_its_time_constant(others, kept):
    state = StallState(angle=1.0, least=0.1, most=0.3)
    reading = CableReading(motor=build(angle=1.0, speed=0.0), torque=0.2)
    limits = replace(LIMITS, blocked_memory=0.5)
    share = DT / 0.5
    for dt, part in ((DT, share), (10.0, 1.0)):
        after, _ = watch_stall(state, reading, dt, SHEET, limits, others=others)
        wanted = {"least": 0.1 + 0.1 * part, "most": 0.3 - 0.1 * part} | {kept: getattr(state, kept)}
        assert (after.least, after.most) == pytest.approx((wanted["least"], wanted["most"]))
        assert after.stood == dt


def test_the_motion_of_a_cable_is_forgotten_too():
    state, pulls = StallState(), [0.0] * 10 + [0.01] * 1000
    motions = []
    for pull in pulls:
        reading = CableReading(motor=build(angle=50 * pull, speed=0.0), torque=0.2, pull=pull)
        motions.append(state.compute_motion(pull))
        state, _ = watch_stall(state, reading, DT, SHEET, LIMITS)
    assert motions[:10] == [0.0] * 10
    assert motions[10] == 0.01
    assert motions[10 + 500] == pytest.approx(0.01 * math.exp(-1.0), rel=2e-3)
