"""Stability of the loop, from the control's own linearisation: rotor, cable, delay of one period, and `step`.

Without friction and rounding, small deviations from an equilibrium follow a linear map; its Jacobian is taken of the
code that runs. The loop is stable where every eigenvalue lies inside the unit circle; its gain margin is shown by
multiplying the torque's deviation.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from spiraltrunk.design import presets
from spiraltrunk.errors import DesignError
from spiraltrunk.hardware.motors.motor_port import MotorState
from spiraltrunk.hardware.winder.gains import derive_gains
from spiraltrunk.hardware.winder.limits import FLOOR_MARGIN, FRICTION_SHARE, build_limits
from spiraltrunk.hardware.winder.winder import WinderState, WinderTarget, step

TENSION = 20.0
CARRIED = ("speed", "slow_speed", "tension_limit", "tension_set", "slow_set", "resistance", "tension")
"""States of the control that are carried; the others are constants here."""


def _loop(winder, stiffness, target, gain, delay):
    """Map of one period on deviations from an equilibrium at `TENSION`."""
    radius, dt = winder.drum.radius(0.0), winder.gains.period
    motion = np.array([[0.0, 1.0], [-stiffness * radius**2 / winder.inertia, 0.0]])
    block = np.zeros((3, 3))
    block[:2, :2], block[1, 2] = motion, 1 / winder.inertia
    held = expm(block * dt)[:2]
    rest = WinderState(
        zero_angle=0.0, motor_time=0.0, tension_limit=TENSION, tension_set=TENSION, slow_set=TENSION,
        resistance=TENSION, tension=TENSION,
    )  # fmt: skip

    def advance(x):
        angle, speed, *torques = x[: 2 + delay]
        carried = dict(zip(CARRIED, x[2 + delay :], strict=True))
        state = rest._replace(**{name: getattr(rest, name) + value for name, value in carried.items()})
        last = x[2]  # The torque that acted while this feedback came about.
        motor = MotorState(time=dt, angle=angle, speed=speed, torque=TENSION * radius + last, temperature=30.0)
        after, _, torque = step(winder, state, target, motor, dt)
        moved = held @ np.array([angle, speed, torques[1] if delay > 1 else last])
        change = gain * (torque - TENSION * radius)
        control = [getattr(after, name) - getattr(rest, name) for name in CARRIED]
        return np.array([*moved, *torques[1:], change, *control])

    return advance


def _spectral_radius(winder, stiffness, pull=math.inf, *, gain=1.0, delay=2):
    advance = _loop(winder, stiffness, WinderTarget(tension=TENSION, pull=pull), gain, delay)
    size, small = 2 + delay + len(CARRIED), 1e-7
    origin = advance(np.zeros(size))
    np.testing.assert_allclose(origin, 0.0, atol=1e-12)
    columns = [(advance(small * unit) - advance(-small * unit)) / (2 * small) for unit in np.eye(size)]
    return float(np.abs(np.linalg.eigvals(np.array(columns).T)).max())


@pytest.fixture(params=[(1e-3, "DIRECT"), (2e-3, "DIRECT"), (10e-3, "GEARED"), (20e-3, "GEARED")])
def winder(rig, request):
    period, motor = request.param
    return replace(rig.build_rig_winder(period, getattr(rig, motor)), friction=0.0)


SPRINGS = [100.0, 200.0, 500.0, 1e3, 2e3, 5e3, 1e4, 2e4]


@pytest.mark.parametrize("stiffness", SPRINGS)
def test_tension_is_stable_with_a_gain_margin_of_two(winder, stiffness):
    for gain in (0.5, 1.0, 1.5, 2.0):
        assert _spectral_radius(winder, stiffness, gain=gain) < 1.0 + 1e-9


@pytest.mark.parametrize("stiffness", SPRINGS)
def test_the_limit_of_pull_is_stable_with_a_gain_margin_of_two(winder, stiffness):
    for gain in (0.5, 1.0, 1.5, 2.0):
        assert _spectral_radius(winder, stiffness, 0.0, gain=gain) < 1.0 - 1e-4


def test_the_gain_margin_is_finite_so_that_the_test_can_fail(rig):
    """The least margin over springs and laws, printed; at ten times the gain every period is unstable."""
    for period, motor in ((1e-3, rig.DIRECT), (2e-3, rig.DIRECT), (10e-3, rig.GEARED), (20e-3, rig.GEARED)):
        winder = replace(rig.build_rig_winder(period, motor), friction=0.0)
        worst = [
            gain
            for gain in np.arange(2.0, 10.1, 0.5).tolist()
            if any(_spectral_radius(winder, k, pull, gain=gain) > 1 + 1e-9 for k in SPRINGS for pull in (math.inf, 0.0))
        ]
        print(f"{motor.name} at {1e3 * period:g} ms: gain margin {worst[0] - 0.5:g}")
        assert worst


@pytest.mark.parametrize("stiffness", SPRINGS)
def test_one_more_period_of_delay_stays_stable(rig, stiffness):
    for period in (1e-3, 2e-3):
        winder = replace(rig.build_rig_winder(period), friction=0.0)
        assert _spectral_radius(winder, stiffness, delay=3) < 1.0 + 1e-9
        assert _spectral_radius(winder, stiffness, 0.0, delay=3) < 1.0


def test_gains_follow_from_period_inertia_and_cable():
    gains = derive_gains(2e-3, 1.3e-4, 9.85e-3)
    resonance = 9.85e-3 * math.sqrt(2e4 / 1.3e-4)
    crossover = 1 / (2 * 1.5 * 2e-3)
    assert gains.damping == pytest.approx(min(0.75 * crossover, 1.4 * resonance))
    assert gains.damping + gains.speed <= crossover + 1e-9
    assert gains.observer + gains.governor <= crossover + 1e-9
    stiffer = derive_gains(1e-3, 1.3e-4, 9.85e-3, 5e3)
    assert stiffer.damping == pytest.approx(1.4 * resonance / 2)
    assert gains.slack_speed * math.sqrt(2e4 * 1.3e-4) / 9.85e-3 == pytest.approx(5.0)


def test_a_period_too_long_for_the_resonance_is_refused():
    with pytest.raises(DesignError, match=r"winder.period is 20 ms; allowed: at most 6.5 ms: rotor and cable resonate"):
        derive_gains(20e-3, 1.3e-4, 9.85e-3)
    derive_gains(6.5e-3, 1.3e-4, 9.85e-3)
    with pytest.raises(DesignError, match=r"winder.period is nan"):
        derive_gains(math.nan, 1.3e-4, 9.85e-3)


def test_a_period_shorter_than_the_bus_allows_is_refused(rig):
    with pytest.raises(DesignError, match=r"winder.period is 0.005; allowed: .* at least 0.01"):
        rig.build_rig_winder(5e-3, rig.GEARED)


def test_limits_follow_from_design_drum_and_data_sheet(rig):
    winder = rig.build_rig_winder()
    limits, drum = winder.limits, winder.drum
    assert (limits.tension_floor, limits.tension_max, limits.tension_ceiling) == (1.0, 60.0, 60.0)
    assert limits.pull_max == pytest.approx(1.1 * drum.design.travel_in)
    assert limits.pull_min == pytest.approx(-1.1 * drum.design.travel_out)
    weak = replace(rig.DIRECT, torque_max=0.4)
    assert build_limits(presets.PAPER, drum, weak).tension_ceiling == pytest.approx((0.4 - 0.02) / 9.85e-3)
    geared = rig.build_rig_winder(10e-3, rig.GEARED)
    left = FLOOR_MARGIN * (1 - FRICTION_SHARE) * 0.15 / geared.drum.design.winding_radius
    assert geared.limits.tension_floor == pytest.approx(left)
    with pytest.raises(
        DesignError, match=r"winder.tension is 0.508 N at most with direct on 9.9 mm; allowed: at least"
    ):
        build_limits(presets.PAPER, drum, replace(rig.DIRECT, torque_max=0.025))
    for floor in (0.0, math.nan, -1.0):
        with pytest.raises(DesignError, match=r"winder.tension_floor"):
            build_limits(presets.PAPER, drum, rig.DIRECT, floor)
