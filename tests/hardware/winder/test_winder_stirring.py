"""Stirring at the end of homing: the limit of what settles, and the zeros of drums that settle slowly."""

import importlib.util
import math
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.hardware.winder.homing import HomingStatus, begin_homing, step_homing
from spiraltrunk.hardware.winder.stirring import (
    FADE_TIME,
    LEFT_MOST,
    STIR_TIME,
    Stirring,
    fit_settling,
    step_stirring,
)

SCRIPT = Path(__file__).parents[3] / "benchmarks" / "sts_homing.py"
LENGTH = st.floats(-0.01, 0.01)


def _settle(limits, amplitudes, constant, count):
    return [[z + c * math.exp(-k / constant) for z, c in zip(limits, amplitudes, strict=True)] for k in range(count)]


@given(st.tuples(LENGTH, LENGTH, LENGTH), st.tuples(LENGTH, LENGTH, LENGTH), st.floats(1.0, 25.0))
def test_the_limit_of_an_exponential_is_found(limits, amplitudes, constant):
    """Exactly but for the steps of the time constants, which differ by 8 %."""
    found, left = fit_settling(_settle(limits, amplitudes, constant, 19))
    for z, c, one, rest in zip(limits, amplitudes, found, left, strict=True):
        assert abs(one - z) < 0.1 * abs(c) + 1e-6
        assert abs(rest + c * math.exp(-18 / constant)) < 0.1 * abs(c) + 1e-6


def test_what_rests_is_its_own_limit():
    found, left = fit_settling([[0.001, -0.002]] * 6)
    assert found == pytest.approx([0.001, -0.002], abs=1e-12)
    assert left == pytest.approx([0.0, 0.0], abs=1e-12)


def _stir(rig, pull_at):
    winder, stirring, time = rig.build_rig_winder(10e-3, rig.GEARED), Stirring(), 0.0
    while not (stirring.zeros or stirring.is_unsettled):
        time += 10e-3
        stirring = step_stirring(winder, stirring, [pull_at(time)], 10e-3)
    return winder, stirring


@pytest.mark.parametrize("amplitude", [0.0, 0.004])
def test_what_is_left_is_not_waited_for(rig, amplitude):
    winder, stirring = _stir(rig, lambda time: 0.002 - amplitude * math.exp(-time / 20.0))
    assert stirring.elapsed == pytest.approx(STIR_TIME, abs=1.5)
    assert stirring.zeros == pytest.approx([0.002], abs=2e-4)
    while not stirring.is_over:
        stirring = step_stirring(winder, stirring, [0.0], 10e-3)
    assert stirring.elapsed == pytest.approx(STIR_TIME + FADE_TIME, abs=1.5)
    assert stirring.zeros == pytest.approx([0.002], abs=2e-4)


def test_what_something_moves_on_has_no_zero_and_homing_fails(rig):
    _, stirring = _stir(rig, lambda time: LEFT_MOST * time)
    assert stirring.is_unsettled
    winders = [rig.build_rig_winder(10e-3, rig.GEARED)]
    motor = rig.Rig(winders[0]).feedback()
    state = replace(begin_homing(winders, [motor]), stirring=stirring)
    state, _ = step_homing(winders, state, [motor], 10e-3)
    assert state.status is HomingStatus.FAILED
    assert state.reason == "did not settle while the drums were stirred: does something move the trunk?"


@pytest.mark.parametrize(
    ("slack", "scale"),
    [
        ((0.006, 0.002, 0.001), 2.0),
        *(
            pytest.param(slack, scale, marks=pytest.mark.slow)
            for slack, scale in (
                ((0.006, 0.002, 0.001), 0.5), ((0.006, 0.002, 0.001), 1.0),
                ((0.010, 0.001, 0.001), 0.5), ((0.010, 0.001, 0.001), 1.0), ((0.010, 0.001, 0.001), 2.0),
            )
        ),
    ],
)  # fmt: skip
def test_servos_are_homed_whatever_slack_and_friction(slack, scale):
    """Where the drums come to rest, 1 to 5 mm are left."""
    spec = importlib.util.spec_from_file_location("sts_homing", SCRIPT)
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    homed = script.Homed(slack, scale)
    print(f"error of the zero {1e3 * max(map(abs, homed.end)):.2f} mm after {homed.time:.1f} s")
    assert homed.faults == ()
    assert max(map(abs, homed.end)) < 0.5e-3
