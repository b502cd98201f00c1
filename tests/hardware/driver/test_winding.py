"""Which drums are stirred: those that are taut and stand while another one moves."""

from __future__ import annotations

import math

import pytest

from spiraltrunk.design.drum import size_drum
from spiraltrunk.design.presets import PAPER
from spiraltrunk.hardware.driver.targets import Targets
from spiraltrunk.hardware.driver.winding import STIR_LENGTH, STOOD_LENGTH, Winding, _is_taut
from spiraltrunk.hardware.motors.gm6020 import GM6020
from spiraltrunk.hardware.motors.motor_port import MotorState
from spiraltrunk.hardware.winder.drum import DrumGeometry
from spiraltrunk.hardware.winder.winder import WinderState, build_winder

DRUM = DrumGeometry(design=size_drum(PAPER))


@pytest.fixture
def find_stirred():
    """Drums that are stirred at these pulls [mm]."""
    winding = Winding([build_winder(PAPER, GM6020, DRUM, 2e-3)] * 3, GM6020)

    def find(*pulls_mm, tension=20.0):
        winding._states = tuple(one._replace(tension_set=20.0, tension=tension) for one in winding._states)
        angles = [DRUM.angle(1e-3 * pull) for pull in pulls_mm]
        motors = [MotorState(time=0.0, angle=one, speed=0.0, torque=0.0, temperature=25.0) for one in angles]
        return winding._find_stirred(motors)

    find.restart = winding.restart
    return find


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_drum_that_stands_is_stirred_each_time_another_one_has_moved_so_far(find_stirred, sense):
    step = 1e3 * STIR_LENGTH
    assert find_stirred(0.0, 0.0, 0.0) == [False, False, False]
    assert find_stirred(0.0, sense * 0.99 * step, 0.0) == [False, False, False]
    assert find_stirred(0.0, sense * 1.01 * step, 0.0) == [True, False, True]
    assert find_stirred(0.0, sense * 1.99 * step, 0.0) == [False, False, False]
    assert find_stirred(0.0, sense * 2.02 * step, 0.0) == [True, False, True]
    assert find_stirred(0.0, sense * 2.02 * step, 0.0) == [False, False, False]


def test_a_drum_that_has_moved_since_is_not_stirred(find_stirred):
    step, little = 1e3 * STIR_LENGTH, 1e3 * STOOD_LENGTH
    assert find_stirred(0.0, 0.0, 0.0) == [False, False, False]
    assert find_stirred(1.01 * little, 0.9 * step, 0.99 * little) == [False, False, False]
    assert find_stirred(1.01 * little, 1.8 * step, 0.99 * little) == [False, False, True]
    assert find_stirred(1.01 * little, 2.0 * step, 0.99 * little) == [True, False, False]


def test_it_begins_anew_after_a_time_without_torque(find_stirred):
    assert find_stirred(0.0, 0.0, 0.0) == [False, False, False]
    find_stirred.restart()
    assert find_stirred(0.0, 50.0, 0.0) == [False, False, False]


def test_a_slack_drum_is_not_stirred(find_stirred):
    assert find_stirred(0.0, 0.0, 0.0) == [False, False, False]
    assert find_stirred(0.0, 50.0, 0.0, tension=9.9) == [False, False, False]
    assert find_stirred(0.0, 50.0, 0.0, tension=10.1) == [True, False, True]


def test_pull_and_resistance_are_told_as_late_as_the_tension():
    """The first feedback is taken as it is; then a jump of the pull comes in with the observer's rate."""
    winding = Winding([build_winder(PAPER, GM6020, DRUM, 2e-3)] * 3, GM6020)
    targets, rate = Targets(tension=(5.0,) * 3, pull=(math.inf,) * 3, expires=math.inf), 1.0 / winding.lag
    assert rate == pytest.approx(83.3, abs=0.1)
    seen = []
    for number, pull in enumerate([0.0, 0.01, 0.01, 0.01]):
        motor = MotorState(time=2e-3 * number, angle=DRUM.angle(pull), speed=0.0, torque=0.1, temperature=25.0)
        readings, _ = winding.step(targets, [motor] * 3, (0.0,) * 3, 2e-3)
        seen.append(readings[1])
    assert [one.pull for one in seen] == pytest.approx([0.0, 0.01, 0.01, 0.01])
    late = [0.01 * -math.expm1(-2e-3 * rate * number) for number in range(4)]
    assert [one.pull_at_tension for one in seen] == pytest.approx(late, abs=1e-12)
    assert [one.resistance for one in seen] == pytest.approx([0.1 / DRUM.radius(0.0)] * 4)


def test_only_what_is_set_beyond_floor_and_friction_counts_as_taut():
    winder = build_winder(PAPER, GM6020, DRUM, 2e-3)
    least = winder.limits.tension_floor + GM6020.rotor_friction / DRUM.design.winding_radius
    for part, is_taut in ((0.99, False), (1.01, True)):
        state = WinderState(zero_angle=0.0, tension_set=part * least, tension=least)
        assert _is_taut(winder, state) == is_taut
