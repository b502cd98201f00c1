"""The verdicts on kick and sweep: a clean record succeeds, and each thing that can go wrong is found and named."""

import math
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.sim.ground_truth import Sample
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.robot.panda import PANDA
from spiraltrunk.sim.scene.build import build_task
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.workflows.grasp.verdict.cause import Cause
from spiraltrunk.workflows.grasp.verdict.evidence import Evidence
from spiraltrunk.workflows.grasp.verdict.moments import Moments
from spiraltrunk.workflows.grasp.verdict.push_verdict import evaluate_kick, evaluate_sweep

TASK = build_task(
    PAPER, SceneOptions(shape=parse_object("ball-100"), support="ground", position=(0.5, 0.0, 0.0), push=(0.0, 0.17))
)
START, AXIS = TASK.target.position, TASK.target.axis
TIMES = np.arange(0, 801) * 0.02
SWEPT = 4.0
MOMENTS = Moments(push=(1.0, SWEPT), lift=(5.0, 7.0), carry=(7.0, 9.0), hold=(9.0, 12.0))


def _sample(t, position, is_held=False):
    home = np.array(PANDA.home)
    return Sample(
        time=t, qpos=np.zeros(1), object_position=position, object_axis=AXIS, slip_velocity=np.zeros(3),
        joint_bend=np.full(17, 0.4), cable_pull=np.zeros(3),
        cable_tension=np.zeros(3), grip_force=5.0 if is_held else 0.0, string_tension=0.0, penetration=1e-3,
        bend_most=0.5, touches_robot=False, touches_table=not is_held, arm_touches_ground=False,
        arm_torque=np.full(7, 5.0), arm_position=home, arm_velocity=np.zeros(7), arm_command=home,
    )  # fmt: skip


def _kicked(way=0.20, angle=0.0):
    ahead = np.interp(TIMES, [1.0, 2.0], [0.0, way])
    places = START + np.stack([ahead * math.sin(angle), ahead * math.cos(angle), 0 * ahead], axis=1)
    return [_sample(float(t), place) for t, place in zip(TIMES, places, strict=True)]


def _swept(way=0.17, lift=0.20):
    ahead = np.interp(TIMES, [1.0, 3.0, 7.0, 9.0], [0.0, way, way, way + 0.20])
    height = np.interp(TIMES, [5.0, 7.0, 12.0, 14.0], [0.0, lift, lift, 0.0])
    places = START + np.stack([0 * ahead, ahead, height], axis=1)
    held = (TIMES > 5.0) & (TIMES < 14.0)
    return [_sample(float(t), place, bool(h)) for t, place, h in zip(TIMES, places, held, strict=True)]


def _evidence(trace, moments, **changes):
    given = {"gave_up": None, "warnings": 0, "limits": PANDA.limits, **changes}
    return Evidence(trace=trace, task=TASK, moments=moments, **given)


def _kick(trace, **changes):
    return evaluate_kick(_evidence(trace, Moments(), **changes))


def _sweep(trace, moments=MOMENTS, **changes):
    return evaluate_sweep(_evidence(trace, moments, **changes))


def test_clean_records_succeed():
    kick, sweep = _kick(_kicked()), _sweep(_swept())
    assert (kick.success, kick.reason) == (True, "success")
    assert kick.carry == pytest.approx(0.20)
    assert kick.place_error == 0.0
    assert (sweep.success, sweep.reason) == (True, "success")
    assert sweep.lift == pytest.approx(0.20)
    assert sweep.place_error == pytest.approx(0.0, abs=1e-9)


def test_a_kick_must_pass_the_line_and_it_is_told_what_lacked():
    verdict = _kick(_kicked(0.16))
    assert verdict.reason == "went 16 cm the goal's way"
    assert verdict.place_error == pytest.approx(0.01)
    assert not _kick(_kicked(-0.30)).success


@pytest.mark.parametrize(("angle", "success"), [(28.0, True), (-28.0, True), (32.0, False), (-32.0, False)])
def test_a_kick_must_go_the_goals_way(angle, success):
    verdict = _kick(_kicked(0.30, math.radians(angle)))
    assert verdict.success == success
    assert success or verdict.reason == "went 32 deg off the goal's way"


@pytest.mark.parametrize("change", [
    {"touches_table": False},
    {"object_position": START + np.array([0.0, 0.25, -0.60])},
])  # fmt: skip
def test_what_left_the_ground_is_no_success(change):
    trace = _kicked()
    trace[-100:] = [replace(sample, **change) for sample in trace[-100:]]
    assert _kick(trace).reason == "not at rest on the ground"


def test_what_still_rolls_at_the_end_is_no_success():
    trace = _kicked()
    trace[-5:] = [
        replace(s, object_position=s.object_position + np.array([0, 0.001 * i, 0])) for i, s in enumerate(trace[-5:])
    ]
    assert _kick(trace).reason == "not at rest on the ground"


@pytest.mark.parametrize(("change", "reason"), [
    ({"touches_robot": True}, "the object touched housing or arm"),
    ({"arm_touches_ground": True}, "housing or arm touched the ground"),
    ({"penetration": 0.006}, "bodies overlapped by 6.0 mm"),
    ({"bend_most": math.radians(34.0)}, "a joint bent 34.0 deg"),
    ({"arm_torque": np.full(7, 90.0)}, "the arm passed its torque limit"),
])  # fmt: skip
def test_faults_are_found_in_both(change, reason):
    for judged, trace in ((_kick, _kicked()), (_sweep, _swept())):
        trace[50] = replace(trace[50], **change)
        assert judged(trace).reason == reason


def test_giving_up_and_warnings_are_no_success():
    for judged, trace in ((_kick, _kicked()), (_sweep, _swept())):
        assert judged(trace, gave_up="enough").reason == "enough"
        assert judged(trace, warnings=2).reason == "the solver warned 2 times"


@pytest.mark.parametrize(("way", "success"), [(0.125, True), (0.215, True), (0.115, False), (0.225, False)])
def test_a_sweep_must_end_in_the_zone(way, success):
    verdict = _sweep(_swept(way))
    assert verdict.success == success
    assert success or verdict.reason.startswith("swept to 5.5 cm from the place")


def test_a_sweep_must_begin_outside_the_zone():
    trace = [replace(s, object_position=s.object_position + np.array([0.0, 0.13, 0.0])) for s in _swept(0.04)]
    verdict = _sweep(trace)
    assert verdict.reason == "the object began in the zone"
    assert verdict.failure is not None
    assert verdict.failure.cause is Cause.MISPLACED


def test_a_sweep_must_end_at_rest():
    moving = _swept()
    i = round(SWEPT / 0.02)
    moving[i] = replace(moving[i], object_position=moving[i].object_position + np.array([0.0, 0.005, 0.0]))
    verdict = _sweep(moving)
    assert verdict.reason == "not at rest after the sweep"
    assert verdict.failure is not None
    assert (verdict.failure.cause, verdict.failure.time) == (Cause.MISPLACED, pytest.approx(SWEPT))


@pytest.mark.parametrize(("gave_up", "reason"), [(None, "the strategy reported no push"), ("enough", "enough")])
def test_a_sweep_that_reported_no_push_is_no_success(gave_up, reason):
    assert _sweep(_swept(), replace(MOMENTS, push=None), gave_up=gave_up).reason == reason


def test_the_grasp_after_a_sweep_is_judged_as_any_grasp():
    assert _sweep(_swept(lift=0.10)).reason == "lifted 10 cm"
    far = _swept()
    far[650:] = [replace(s, object_position=s.object_position + np.array([0.06, 0.0, 0.0])) for s in far[650:]]
    assert _sweep(far).reason.startswith("released 6.0 cm")
