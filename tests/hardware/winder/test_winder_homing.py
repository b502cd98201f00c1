"""Homing by gentle tension: taut, slack, soft, broken and jammed cables, and lost turns."""

from dataclasses import replace

import pytest

from spiraltrunk.errors import DesignError, DriveError
from spiraltrunk.hardware.winder.homing import HomingStatus, begin_homing, find_time_limit, step_homing
from spiraltrunk.hardware.winder.winder import WinderTarget


def _home(rigs, **options):
    winders = [one.winder for one in rigs]
    state = begin_homing(winders, [one.feedback() for one in rigs], **options)
    while state.status is HomingStatus.RUNNING:
        feedback = [one.feedback() for one in rigs]
        state, torques = step_homing(winders, state, feedback, winders[0].gains.period)
        for one, torque in zip(rigs, torques, strict=True):
            one.advance(torque)
    return state, feedback


def _rigs(rig, period, motor, *others):
    winder = rig.build_rig_winder(period, motor)
    substeps = 10 if motor is rig.DIRECT else 100
    cables = ({"slack": 0.02, "angle": 3.0}, {"slack": 0.01, "angle": -40.0 if motor is rig.DIRECT else 1.0}, *others)
    cables = [
        {**cable, "slack": cable.get("slack", 0.0) + winder.drum.pull(cable.get("angle", 0.0))} for cable in cables
    ]
    return [rig.Rig(winder, substeps=substeps, **cable) for cable in cables]


@pytest.mark.parametrize("period", [pytest.param(1e-3, marks=pytest.mark.slow), 2e-3])
@pytest.mark.parametrize("other", [{}, {"slack": 0.05}, {"slack": 0.01, "stiffness": 300.0}])
def test_all_cables_are_homed_together(rig, period, other):
    rigs = _rigs(rig, period, rig.DIRECT, other)
    state, feedback = _home(rigs)
    assert state.status is HomingStatus.HOMED, state.reason
    for one, cable, motor in zip(rigs, state.cables, feedback, strict=True):
        assert cable.winder.zero_angle == pytest.approx(motor.angle, abs=1e-9)
        assert abs(one.speed) < 0.1
        assert 0.2 * state.tension <= one.tension <= 3 * state.tension  # Dry friction is 2 N of it.


@pytest.mark.parametrize("period", [pytest.param(10e-3, marks=pytest.mark.slow), 20e-3])
def test_a_geared_motor_is_homed(rig, period):
    rigs = _rigs(rig, period, rig.GEARED, {"slack": 0.005})
    state, _ = _home(rigs)
    assert state.status is HomingStatus.HOMED, state.reason
    assert all(0.3 * state.tension <= one.tension <= 1.5 * state.tension for one in rigs)


def test_control_goes_on_from_the_straight_trunk_without_a_jump(rig):
    rigs = _rigs(rig, 2e-3, rig.DIRECT)
    state, _ = _home(rigs)
    one, before = rigs[0], rigs[0].tension
    one.state = state.cables[0].winder
    seen = one.run(WinderTarget(tension=state.tension), 0.1)
    assert seen[0][2].pull == pytest.approx(0.0, abs=1e-5)
    assert max(abs(tension - before) for tension, *_ in seen) < 0.5


@pytest.mark.parametrize("period", [pytest.param(1e-3, marks=pytest.mark.slow), 2e-3])
def test_a_broken_cable_fails_within_the_travel(rig, period):
    rigs = _rigs(rig, period, rig.DIRECT, {"stiffness": 0.0})
    state, _ = _home(rigs)
    assert (state.status, state.cable) == (HomingStatus.FAILED, 2)
    assert "not taut after winding in 251 mm, the drum's travel is 251 mm" in state.reason
    drum = rigs[2].winder.drum
    assert drum.pull(rigs[2].angle) < drum.design.travel_in + drum.design.travel_out + 1e-3


def test_a_jammed_drum_fails(rig):
    rigs = _rigs(rig, 2e-3, rig.DIRECT, {"is_jammed": True})
    state, _ = _home(rigs)
    assert (state.status, state.cable) == (HomingStatus.FAILED, 2)
    assert state.reason.startswith("moved less than 0.03 mm in 3 s under 3.0 N: is its drum jammed")
    assert state.time < 5.0


def test_a_cable_that_never_rests_runs_into_the_time_limit(rig):
    (one,) = _rigs(rig, 2e-3, rig.DIRECT)[:1]
    winder, dt = one.winder, one.winder.gains.period
    state, k = begin_homing([winder], [one.feedback()]), 0
    while state.status is HomingStatus.RUNNING:
        k += 1
        motor = replace(one.feedback(), time=k * dt, angle=3.0 + 0.2 * (k // 100 % 2), speed=0.0, torque=0.03)
        state, _ = step_homing([winder], state, [motor], dt)
    assert state.status is HomingStatus.FAILED
    assert "did not come to rest" in state.reason
    assert state.time == pytest.approx(find_time_limit(winder), abs=0.01)


def test_lost_turns_fail_unless_they_were_lost_before(rig):
    (one,) = _rigs(rig, 2e-3, rig.DIRECT)[:1]
    lost = replace(one.feedback(), is_count_lost=True)
    state, _ = step_homing([one.winder], begin_homing([one.winder], [one.feedback()]), [lost], 2e-3)
    assert (state.status, state.cable) == (HomingStatus.FAILED, 0)
    assert "turns were lost" in state.reason
    state, _ = step_homing([one.winder], begin_homing([one.winder], [lost]), [lost], 2e-3)
    assert state.status is HomingStatus.RUNNING
    failed = replace(state, status=HomingStatus.FAILED)
    with pytest.raises(DriveError, match="homing is over: failed"):
        step_homing([one.winder], failed, [lost], 2e-3)


def test_a_tension_beyond_the_limits_is_refused(rig):
    (one,) = _rigs(rig, 2e-3, rig.DIRECT)[:1]
    for tension in (0.1, 100.0, float("nan")):
        with pytest.raises(DesignError, match=r"homing.tension is .*at least 1, at most 60"):
            begin_homing([one.winder], [one.feedback()], tension)
