"""Dynamics of a motor against closed forms."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DesignError
from spiraltrunk.hardware.motors.gm6020 import GM6020
from spiraltrunk.hardware.twin.motor import MotorParameters, MotorTwin
from spiraltrunk.hardware.twin.trunk.anchor import Anchor
from spiraltrunk.hardware.twin.trunk.spring_trunk import SpringTrunk

DT = 1e-3


def run(motor: MotorTwin, duration: float, tension: float = 0.0, dt: float = DT) -> None:
    """Advance under a constant tension."""
    for _ in range(round(duration / dt)):
        motor.advance(tension, dt)


def test_free_run_ends_at_the_speed_without_load() -> None:
    """U = R i + k_e w with the current that friction needs; without friction 320 rpm."""
    p = MotorParameters()
    motor, free = MotorTwin(p), MotorTwin(MotorParameters(friction=0.0))
    for twin in (motor, free):
        twin.command = 3.0
        run(twin, 3.0)
    assert motor.speed == pytest.approx((p.supply - p.resistance * p.friction / p.torque_constant) / p.back_emf)
    assert free.speed == pytest.approx(320 * math.tau / 60)


@pytest.mark.parametrize("command", [3.0, -3.0, 50.0, -50.0])
def test_stall_torque_is_the_data_sheets(command: float) -> None:
    motor = MotorTwin(MotorParameters())
    motor.is_blocked, motor.command = True, command
    run(motor, 0.1)
    assert motor.torque == pytest.approx(math.copysign(2.223, command))
    assert abs(motor.torque) == pytest.approx(GM6020.torque_max)
    assert motor.speed == motor.angle == 0.0


def test_current_follows_as_of_first_order() -> None:
    motor = MotorTwin(MotorParameters(current_time=5e-3))
    motor.is_blocked, motor.command = True, 1.0
    run(motor, 5e-3)
    assert motor.current == pytest.approx(1.0 - math.exp(-1.0))


@pytest.mark.parametrize("torque", [0.5, 1.0, -0.5])
def test_acceleration_is_torque_less_friction_over_inertia(torque: float) -> None:
    p = MotorParameters(current_time=1e-6)
    motor = MotorTwin(p)
    motor.command = torque / p.torque_constant
    run(motor, 0.002)
    expected = math.copysign(abs(torque) - p.friction, torque) / p.rotor_inertia * 0.002
    assert motor.speed == pytest.approx(expected)


def test_friction_sticks_truly() -> None:
    """Below its largest torque nothing moves, not by a rounding error; above it, it does."""
    p = MotorParameters()
    held, moving = MotorTwin(p), MotorTwin(p)
    held.command, moving.command = 0.99 * p.friction / p.torque_constant, 1.01 * p.friction / p.torque_constant
    for motor in (held, moving):
        run(motor, 60.0, dt=1e-3)
    assert held.angle == held.speed == 0.0
    assert moving.angle > 1.0


def test_friction_stops_a_coasting_rotor_and_does_not_reverse_it() -> None:
    """It turns by J w^2 / (2 f), and no further."""
    p = MotorParameters()
    motor = MotorTwin(p)
    motor.speed = 20.0
    run(motor, 1.0, dt=1e-5)
    assert motor.speed == 0.0
    assert motor.angle == pytest.approx(p.rotor_inertia * 20.0**2 / (2 * p.friction), rel=1e-3)


@pytest.mark.parametrize("tension", [5.0, 15.0, 30.0])
def test_static_tension_is_torque_over_radius_within_friction(tension: float) -> None:
    p = MotorParameters()
    motor, wall = MotorTwin(p), Anchor()
    motor.command = tension * p.drum_radius / p.torque_constant
    pull = 0.0
    for _ in range(2000):
        motor.advance(pull, DT)
        (pull,) = wall.advance([motor.wound], [motor.stiffness], DT)
    assert abs(pull - tension) <= p.friction / p.drum_radius + 1e-9
    assert motor.speed == 0.0
    before = motor.wound
    motor.advance(pull, DT)
    assert motor.wound == before


@pytest.mark.parametrize("radius", [0.01, 0.02, 0.037])
def test_integration_with_a_stiff_cable_does_not_gain_energy(radius: float) -> None:
    """A rotor without friction swings on a cable of 2e4 N/m at 1 ms, and less widely in each second.

    It is pulled from one side by the motor and from the other by the cable, which also becomes slack.
    """
    p = MotorParameters(friction=0.0, drum_radius=radius, current_time=1e-6, speed_free=1e6, wound=5e-3)
    motor, wall = MotorTwin(p), Anchor()
    motor.command = 10.0 * radius / p.torque_constant
    tops = []
    pull = p.cable_stiffness * p.wound
    for _ in range(30):
        top = -math.inf
        for _ in range(1000):
            motor.advance(pull, DT)
            (pull,) = wall.advance([motor.wound], [motor.stiffness], DT)
            kinetic, stretch = 0.5 * p.rotor_inertia * motor.speed**2, max(0.0, motor.wound)
            top = max(top, kinetic + 0.5 * p.cable_stiffness * stretch**2 - 10.0 * motor.wound)
        tops.append(top)
    rest = -0.5 * 10.0**2 / p.cable_stiffness
    assert tops[0] > 0.1
    assert all(later <= earlier + 1e-9 for earlier, later in pairwise(tops))
    assert tops[-1] == pytest.approx(rest, abs=1e-6)


@pytest.mark.parametrize("radius", [0.01, 0.02, 0.037])
def test_motors_and_trunk_together_do_not_gain_energy(radius: float) -> None:
    """Three rotors without friction or current, stretched cables and a curled trunk without damping, let go."""
    joint = replace(PAPER.joint, damping_time=0.0)
    trunk = SpringTrunk(replace(PAPER, joint=joint), theta_0=0.7)
    starts = (0.05, -0.01, 0.002)
    motors = [MotorTwin(MotorParameters(friction=0.0, drum_radius=radius, wound=wound)) for wound in starts]
    tension: Sequence[float] = [0.0] * 3
    stiffness, total = [2e4] * 3, []
    for k in range(5_000):
        tension = trunk.advance([motor.wound for motor in motors], stiffness, DT)
        if k % 10 == 0:
            energy = trunk.energy()
            for motor, taken in zip(motors, trunk.taken, strict=True):
                stretch = max(0.0, motor.wound - taken)
                energy += 0.5 * 2e4 * stretch**2 + 0.5 * motor.parameters.rotor_inertia * motor.speed**2
            total.append(energy)
        for motor, pull in zip(motors, tension, strict=True):
            motor.advance(pull, DT)
    tops = [max(total[k : k + 100]) for k in range(0, len(total), 100)]
    assert all(later <= earlier + 1e-9 for earlier, later in pairwise(tops))


def test_finer_steps_give_the_same_motion() -> None:
    ends = []
    for dt in (1e-3, 5e-4, 2.5e-4):
        motor = MotorTwin(MotorParameters())
        motor.command = 0.5
        run(motor, 0.2, dt=dt)
        ends.append(motor.angle)
    first, second = abs(ends[0] - ends[1]), abs(ends[1] - ends[2])
    assert first / second == pytest.approx(2.0, abs=0.3)  # First order.


def test_winding_warms_up_to_the_steady_state() -> None:
    """theta = ambient + R_th R i^2 (1 - exp(-t / tau))."""
    p = MotorParameters()
    motor = MotorTwin(p)
    motor.is_blocked, motor.command = True, 1.62
    steady = p.thermal_resistance * p.resistance * 1.62**2
    run(motor, p.thermal_time, dt=0.1)
    assert motor.temperature - p.ambient == pytest.approx(steady * (1 - math.exp(-1.0)), rel=1e-3)
    run(motor, 20 * p.thermal_time, dt=0.1)
    assert motor.temperature - p.ambient == pytest.approx(steady, rel=1e-6)


@pytest.mark.parametrize("is_reversed", [False, True])
def test_encoder_wraps_at_a_turn(is_reversed: bool) -> None:
    motor = MotorTwin(MotorParameters(encoder_start=8191, is_reversed=is_reversed))
    step = math.tau / 8192
    counts = []
    for k in range(3):
        motor.angle = (k + 0.5) * step
        counts.append(motor.count)
    assert counts == ([8190, 8189, 8188] if is_reversed else [8191, 0, 1])
    motor.angle = 5 * math.tau + 0.5 * step
    assert motor.count == (8190 if is_reversed else 8191)


def test_winding_is_radius_times_angle() -> None:
    motor = MotorTwin(MotorParameters(drum_radius=0.015, wound=-0.01))
    motor.command = 1.0
    run(motor, 0.1)
    assert motor.wound == pytest.approx(0.015 * motor.angle - 0.01)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("rotor_inertia", 0.0),
        ("friction", -1.0),
        ("drum_radius", math.nan),
        ("encoder_start", 8192),
        ("supply", math.inf),
    ],
)
def test_parameters_that_no_motor_has_are_refused(name: str, value: float) -> None:
    with pytest.raises(DesignError, match=name):
        MotorParameters(**{name: value})
