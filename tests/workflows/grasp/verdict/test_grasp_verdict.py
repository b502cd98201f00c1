"""The verdict: a clean record succeeds, and each thing that can go wrong is found and named."""

import math
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.sim.ground_truth import Sample
from spiraltrunk.sim.robot.panda import PANDA
from spiraltrunk.sim.scene.build import build_task
from spiraltrunk.sim.scene.options import PLACE_ASIDE, SceneOptions
from spiraltrunk.workflows.grasp.verdict.evidence import Evidence
from spiraltrunk.workflows.grasp.verdict.grasp_verdict import evaluate_grasp
from spiraltrunk.workflows.grasp.verdict.moments import Moments

TASK = build_task(PAPER, SceneOptions())
START, AXIS = TASK.target.position, TASK.target.axis
MOMENTS = Moments(lift=(1.0, 3.0), carry=(3.0, 5.0), hold=(5.0, 8.0))
TIMES = np.arange(0, 501) * 0.02


def _height(t):
    return np.interp(t, [1, 3, 8, 9.0], [0, 0.20, 0.20, 0.08])


def _aside(t):
    return np.interp(t, [3, 5, 8, 9.0], [0, 0.20, 0.20, PLACE_ASIDE])


def _sample(t):
    lifted = 1.0 < t < 9.0
    position = START + np.array([0.0, _aside(t), _height(t)])
    home = np.array(PANDA.home)
    return Sample(
        time=t, qpos=np.zeros(1), object_position=position, object_axis=AXIS, slip_velocity=np.zeros(3),
        joint_bend=np.full(17, 0.4), cable_pull=np.zeros(3),
        cable_tension=np.zeros(3), grip_force=5.0 if lifted else 0.0, string_tension=0.0 if lifted else 2.45,
        penetration=1e-3, bend_most=0.5, touches_robot=False, touches_table=t >= 9.0,
        arm_touches_ground=False, arm_torque=np.full(7, 5.0),
        arm_position=home, arm_velocity=np.zeros(7), arm_command=home,
    )  # fmt: skip


CLEAN = [_sample(float(t)) for t in TIMES]


def _doctored(when, **changes):
    """The clean record with some samples changed; a change may be a function of the sample."""

    def change(sample):
        return replace(sample, **{k: v(sample) if callable(v) else v for k, v in changes.items()})

    return [change(sample) if when(sample.time) else sample for sample in CLEAN]


def _evaluate(trace, moments=MOMENTS, **changes):
    given = {"gave_up": None, "warnings": 0, "limits": PANDA.limits, **changes}
    return evaluate_grasp(Evidence(trace=trace, task=TASK, moments=moments, **given))


def _moved(*by):
    return lambda sample: sample.object_position + np.array(by)


def test_a_record_of_one_instant_is_judged():
    verdict = _evaluate(CLEAN[:1], Moments(), gave_up="out of reach")
    assert verdict.reason == "out of reach"


def test_a_clean_record_succeeds():
    verdict = _evaluate(CLEAN)
    assert verdict.success
    assert verdict.reason == "success"
    assert verdict.lift == pytest.approx(0.20, abs=1e-9)
    assert verdict.carry == pytest.approx(0.20, abs=1e-9)
    assert verdict.hold == pytest.approx(3.0, abs=0.03)
    assert verdict.place_error == pytest.approx(0.0, abs=1e-9)
    assert verdict.penetration == 1e-3
    assert verdict.bend == 0.5


def _at(moment):
    return lambda t: abs(t - moment) < 1e-6


def _jump(joint, size):
    def command(sample):
        moved = sample.arm_command.copy()
        moved[joint] += size
        return moved

    return command


NEGATIVE = {
    "bend": (_doctored(_at(4.0), bend_most=math.radians(33.5)), "a joint bent 33.5 deg"),
    "overlap": (_doctored(_at(4.0), penetration=0.0051), "bodies overlapped by 5.1 mm"),
    "robot": (_doctored(_at(4.0), touches_robot=True), "the object touched housing or arm"),
    "never lifted": (_doctored(lambda t: t > 1, object_position=START), "lifted 0 cm"),
    "lifted too low": (_doctored(lambda t: 3 <= t < 9, object_position=_moved(0, 0, -0.06)), "lifted 14 cm"),
    "lifted too high": (_doctored(lambda t: 3 <= t < 9, object_position=_moved(0, 0, 0.06)), "lifted 26 cm"),
    "carried too short": (_doctored(lambda t: 5 <= t < 9, object_position=_moved(0, -0.06, 0)), "carried 14 cm aside"),
    "strings carry": (_doctored(lambda t: 6 < t < 6.2, string_tension=0.5), "held alone for 1"),
    "table carries": (_doctored(lambda t: 6 < t < 6.2, touches_table=True), "held alone for 1"),
    "no grip": (_doctored(lambda t: 6 < t < 6.2, grip_force=0.0), "held alone for 1"),
    "sinking": (_doctored(lambda t: 5 <= t <= 8, object_position=lambda s: s.object_position
                          - [0, 0, 0.05 * (s.time - 6.5)]), "held alone for 0"),
    "still gripped": (_doctored(lambda t: t > 9, grip_force=0.1), "not released at rest"),
    "in the air": (_doctored(lambda t: t > 9, touches_table=False), "not released at rest"),
    "rolling": (_doctored(lambda t: t > 9.5, object_position=lambda s: s.object_position
                          + np.array([0.02 * (s.time - 9.5), 0, 0])), "not released at rest"),
    "misplaced": (_doctored(lambda t: t >= 9, object_position=_moved(0.051, 0, 0)), "released 5.1 cm from the target"),
    "dropped and caught": (_doctored(lambda t: 3.5 < t < 3.57, grip_force=0.0, object_position=lambda s:
                                     s.object_position - [0, 0, 4.9 * (s.time - 3.5) ** 2]), "fell 1.8 cm"),
    "dropped at its place": (_doctored(lambda t: 8.85 < t < 9.0, grip_force=0.0), "fell 1.7 cm"),
    "set down on the way": (_doctored(_at(4.0), touches_table=True), "touched table or ground while it was carried"),
    "slid down the trunk": (_doctored(_at(8.5), object_position=_moved(0, 0, 0.012)), "came down at 0.7 m/s"),
    "speed": (_doctored(_at(4.0), arm_velocity=np.array([0, 0, 0, 2.2, 0, 0, 0])), "speed limit"),
    "torque": (_doctored(_at(4.0), arm_torque=np.array([0, 0, 0, 0, 0, -12.5, 0])), "torque limit"),
    "acceleration": (_doctored(lambda t: t > 4.0, arm_command=_jump(1, 0.0035)), "acceleration limit"),
    "range": (_doctored(_at(4.0), arm_position=_jump(3, 2.3)), "the arm passed a joint range"),
}  # fmt: skip


@pytest.mark.parametrize("name", NEGATIVE)
def test_what_went_wrong_is_named(name):
    trace, reason = NEGATIVE[name]
    verdict = _evaluate(trace)
    assert not verdict.success
    assert reason in verdict.reason


@pytest.mark.parametrize(
    "trace",
    [
        _doctored(lambda t: 3.5 < t < 4.0, grip_force=0.0),
        _doctored(lambda t: 8.92 < t < 9.0, grip_force=0.0),
        _doctored(_at(8.5), object_position=_moved(0, 0, 0.007)),
        _doctored(lambda t: t < 3.0, touches_table=True),
    ],
)
def test_a_grip_that_jumps_or_a_short_fall_is_no_drop(trace):
    """Contacts that flicker while the height stays, or for 7 mm; 0.47 m/s down; a touch before the lift has ended."""
    assert _evaluate(trace).success


def test_jerk_beyond_the_limit_is_named():
    """A jerk's limit alone: the acceleration that it takes within one period is far over its own."""
    limits = replace(PANDA.limits, acceleration=None, jerk=np.full(7, 100.0))
    verdict = _evaluate(_doctored(lambda t: t > 4.0, arm_command=_jump(2, 0.002)), limits=limits)
    assert verdict.reason == "the arm passed its jerk limit"


def test_what_the_strategy_says_is_the_reason():
    assert _evaluate(CLEAN, gave_up="nothing was lifted").reason == "nothing was lifted"


def test_a_solver_warning_comes_first():
    assert _evaluate(NEGATIVE["bend"][0], warnings=2, gave_up="nothing").reason == "the solver warned 2 times"


@pytest.mark.parametrize("moment", ["lift", "carry", "hold"])
def test_a_milestone_that_was_not_reported_is_no_success(moment):
    assert _evaluate(CLEAN, replace(MOMENTS, **{moment: None})).reason == f"the strategy reported no {moment}"


def test_limits_that_nobody_states_are_not_judged_and_the_verdict_says_so():
    nothing = replace(PANDA.limits, position=None, velocity=None, acceleration=None, jerk=None, torque=None)
    for name in ("speed", "torque", "acceleration", "range"):
        assert _evaluate(NEGATIVE[name][0], limits=nothing).success


@pytest.mark.parametrize("field", ["penetration", "bend_most"])
def test_a_figure_that_is_not_a_number_is_no_success(field):
    assert not _evaluate(_doctored(lambda t: True, **{field: math.nan})).success
