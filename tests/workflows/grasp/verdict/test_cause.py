"""Every cause of failure, from records in which nothing else goes wrong, with its time."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

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
from spiraltrunk.workflows.grasp.verdict.grasp_verdict import Verdict, evaluate_grasp
from spiraltrunk.workflows.grasp.verdict.moments import Moments
from spiraltrunk.workflows.grasp.verdict.push_verdict import evaluate_kick, evaluate_sweep

STANDING = SceneOptions(shape=parse_object("cylinder-60"), support="ground", orientation="upright")
TASK = build_task(PAPER, STANDING)
PUSH = build_task(PAPER, replace(STANDING, position=(0.5, 0.0, 0.0), push=(0.0, 0.17)))
MOMENTS = Moments(lift=(1.0, 3.0), carry=(3.0, 5.0), hold=(5.0, 8.0))
TIMES = [0.02 * i for i in range(601)]
HOME = np.array(PANDA.home)
UP = np.array([0.0, 0.0, 1.0])


def _sample(time: float) -> Sample:
    """A standing object that is lifted from 1 to 3 s, carried until 5 s, held until 8 s and set down by 10 s."""
    moved = [0.0, np.interp(time, [3, 5], [0, 0.20]), np.interp(time, [1, 3, 8, 10], [0, 0.20, 0.20, 0])]
    return Sample(
        time=time, qpos=np.zeros(1), object_position=TASK.target.position + moved, object_axis=UP,
        slip_velocity=np.zeros(3), joint_bend=np.full(17, 0.5), cable_pull=np.zeros(3), cable_tension=np.zeros(3),
        grip_force=5.0 if 0.5 < time < 10.5 else 0.0, string_tension=0.0, penetration=1e-3, bend_most=0.5,
        touches_robot=False, touches_table=not 1.0 < time < 10.0, arm_touches_ground=False,
        arm_torque=np.full(7, 5.0), arm_position=HOME, arm_velocity=np.zeros(7), arm_command=HOME,
    )  # fmt: skip


CLEAN = [_sample(time) for time in TIMES]
LEFT = [
    replace(s, object_position=TASK.target.position, grip_force=0.0, touches_table=True) for s in CLEAN
]  # The trunk lifts, and the object stays.


def _from(time: float, trace: list[Sample] = CLEAN, **changes: Any) -> list[Sample]:
    """The record with some values changed from a time on; a change may be a function of the sample."""

    def change(sample: Sample) -> Sample:
        return replace(sample, **{key: v(sample) if callable(v) else v for key, v in changes.items()})

    return [change(sample) if sample.time > time + 1e-9 else sample for sample in trace]


def _moved(*by: float) -> Callable[[Sample], np.ndarray]:
    return lambda sample: sample.object_position + np.array(by)


def _evaluate(trace: list[Sample], moments: Moments = MOMENTS, **changes: Any) -> Verdict:
    given = {"task": TASK, "gave_up": None, "warnings": 0, "limits": PANDA.limits, **changes}
    evaluate = given.pop("evaluate", evaluate_grasp)
    return evaluate(Evidence(trace=trace, moments=moments, **given))


def _on_ground(sample: Sample) -> np.ndarray:
    return np.array([*sample.object_position[:2], TASK.target.position[2]])


def _lean(degrees: float, rate: float) -> Callable[[Sample], np.ndarray]:
    """Axis of an object that tips over from 0.6 s on, at a rate [deg/s], up to an angle."""

    def axis(sample: Sample) -> np.ndarray:
        angle = math.radians(min(degrees, rate * max(0.0, sample.time - 0.6)))
        return np.array([math.sin(angle), 0.0, math.cos(angle)])

    return axis


def _fallen(sample: Sample) -> np.ndarray:
    """Place of an object that falls free from 4 s on, down to the ground."""
    fall = min(4.9 * (sample.time - 4.0) ** 2, 0.20)
    return np.array([*sample.object_position[:2], TASK.target.position[2] + 0.20 - fall])


def _is_down(sample: Sample) -> bool:
    return 4.9 * (sample.time - 4.0) ** 2 >= 0.20


SLIDING = {"slip_velocity": np.array([0.0, 0.0, -0.05])}
DOWN = {"object_position": _on_ground, "grip_force": 0.0, "touches_table": True}
FALL = {"object_position": _fallen, "grip_force": 0.0, "touches_table": _is_down}
LIES = np.array([1.0, 0.0, 0.0])

CAUSES = {
    "missed": (LEFT, Cause.MISSED, 1.0),
    "touched, not borne": (_from(0.5, LEFT, grip_force=0.2), Cause.MISSED, 1.0),
    "pushed away": (_from(0.8, LEFT, object_position=_moved(0.04, 0, 0)), Cause.PUSHED_AWAY, 0.82),
    "pushed, not away": (_from(0.8, LEFT, object_position=_moved(0.02, 0, 0)), Cause.MISSED, 1.0),
    "pushed away as it was lifted": (_from(2.0, LEFT, object_position=_moved(0, 0.04, 0)), Cause.PUSHED_AWAY, 2.02),
    "toppled": (_from(0, LEFT, object_axis=_lean(90.0, 100.0)), Cause.TOPPLED, 0.74),  # arctan(60 / 240) = 14 deg.
    "leaned, not toppled": (_from(0, LEFT, object_axis=_lean(40.0, 100.0)), Cause.MISSED, 1.0),
    "toppled at the release": (_from(11.0, object_axis=LIES, object_position=_moved(0.06, 0, 0)), Cause.TOPPLED, 11.0),
    "slid off as it was lifted": (_from(1.0, LEFT, grip_force=5.0, **SLIDING), Cause.SLIPPED, 1.42),
    "slid out": (_from(4.5, _from(4.0, **SLIDING), **DOWN), Cause.SLIPPED, 4.42),
    "unrolled": (
        _from(4.5, _from(4.0, joint_bend=lambda s: np.full(17, 0.5 * (5.0 - s.time))), **DOWN), Cause.UNROLLED, 4.22,
    ),
    "dropped": (_from(4.0, **FALL), Cause.DROPPED, 4.06),  # 10 mm take 45 ms.
    "came down fast": (_from(9.0, object_position=_moved(0, 0, -0.02)), Cause.DROPPED, 9.02),
    "released elsewhere": (_from(10.5, object_position=_moved(0.06, 0, 0)), Cause.MISPLACED, 12.0),
    "carried too short": (_from(3.0, object_position=_moved(0, -0.1, 0)), Cause.MISPLACED, 12.0),
    "arm's limit": (_from(4.0, arm_velocity=np.full(7, 3.0)), Cause.ARM_LIMIT, 4.02),
    "acceleration": (_from(4.0, arm_command=HOME + 0.1), Cause.ARM_LIMIT, 4.02),
    "touched housing": (_from(4.0, touches_robot=True), Cause.COLLIDED, 4.02),
    "housing touched the ground": (_from(4.0, arm_touches_ground=True), Cause.COLLIDED, 4.02),
    "bent past its stop": (_from(4.0, bend_most=0.7), Cause.OVERLOADED, 4.02),
    "pressed into one another": (_from(4.0, penetration=0.006), Cause.OVERLOADED, 4.02),
    "no number": (_from(4.0, penetration=math.nan), Cause.OVERLOADED, 4.02),
}  # fmt: skip


@pytest.mark.parametrize("name", CAUSES)
def test_a_failed_trial_says_what_went_wrong_and_when(name: str) -> None:
    trace, cause, time = CAUSES[name]
    verdict = _evaluate(trace)
    assert not verdict.success
    assert verdict.failure is not None
    assert verdict.failure.cause is cause
    assert verdict.failure.time == pytest.approx(time, abs=0.021)


def test_a_success_has_no_cause() -> None:
    verdict = _evaluate(CLEAN)
    assert verdict.success
    assert verdict.failure is None


def test_the_first_of_several_events_is_the_cause() -> None:
    """A limit that is passed after the object was dropped is not what failed the trial, and the reverse."""
    dropped = _from(4.0, **FALL)
    for moment, cause in ((5.0, Cause.DROPPED), (3.5, Cause.ARM_LIMIT)):
        verdict = _evaluate(_from(moment, dropped, arm_velocity=np.full(7, 3.0)))
        assert verdict.failure is not None
        assert verdict.failure.cause is cause


def test_what_was_recovered_from_is_no_cause() -> None:
    """An object that slides while the grip closes, before the lift, and is dropped after it."""
    sliding = [replace(s, **SLIDING) if 0.5 < s.time < 0.95 else s for s in CLEAN]
    verdict = _evaluate(_from(4.0, sliding, **FALL))
    assert verdict.failure is not None
    assert verdict.failure.cause is Cause.DROPPED


def test_a_second_try_counts_and_not_the_first() -> None:
    """Missed from 1 s on, then lifted from 2 s on and dropped: the lift is reported from the first try on."""
    trace = _from(4.0, **FALL)
    trace = [lost if s.time < 2.0 else s for s, lost in zip(trace, _from(-1.0, **DOWN), strict=True)]
    verdict = _evaluate(trace)
    assert verdict.failure is not None
    assert verdict.failure.cause is Cause.DROPPED


def test_warnings_leave_nothing_to_trust() -> None:
    verdict = _evaluate(_from(4.0, **FALL), warnings=1)
    assert verdict.failure is not None
    assert verdict.failure.cause is Cause.FAULT


def test_a_strategy_that_gave_up_before_it_lifted_missed() -> None:
    verdict = _evaluate(LEFT, Moments(), gave_up="enough")
    assert verdict.failure is not None
    assert (verdict.failure.cause, verdict.failure.time) == (Cause.MISSED, pytest.approx(12.0))


def _pushed(along: float, aside: float = 0.0, **changes: Any) -> list[Sample]:
    """An object on the ground that is moved from 1 s to 2 s, as the goal's way is along y, and aside along x."""

    def move(sample: Sample) -> Sample:
        part = float(np.interp(sample.time, [1.0, 2.0], [0.0, 1.0]))
        place = PUSH.target.position + np.array([aside * part, along * part, 0.0])
        touched = {"object_position": place, "grip_force": 5.0 if 1.0 < sample.time < 2.0 else 0.0}
        return replace(sample, touches_table=True, **{**touched, **changes})

    return [move(sample) for sample in CLEAN]


KICKS = {
    "missed": (_pushed(0.0, grip_force=0.0), Cause.MISSED, 3.0),
    "short": (_pushed(0.10), Cause.MISPLACED, 2.0),
    "off the way": (_pushed(0.20, 0.20), Cause.PUSHED_AWAY, 1.86),
    "backwards": (_pushed(-0.10), Cause.PUSHED_AWAY, 2.0),
    "knocked over": (_pushed(0.10, object_axis=LIES), Cause.TOPPLED, 0.0),
}


@pytest.mark.parametrize("name", [*KICKS, "sweep"])
def test_a_push_that_failed_says_how(name: str) -> None:
    trace, cause, time = KICKS.get(name, (_pushed(0.17, 0.09), Cause.PUSHED_AWAY, 1.56))
    if cause is Cause.TOPPLED:
        trace = [replace(s, object_axis=UP) if s.time < 1.5 else s for s in trace]
        time = 1.48
    evaluate = evaluate_sweep if name == "sweep" else evaluate_kick
    verdict = _evaluate(trace, Moments(push=(1.0, 3.0)), task=PUSH, evaluate=evaluate, gave_up="too far off")
    assert verdict.failure is not None
    assert verdict.failure.cause is cause
    assert verdict.failure.time == pytest.approx(time, abs=0.021)


def test_a_grasp_that_failed_after_a_sweep_says_how_it_failed() -> None:
    trace = [replace(s, time=s.time + 4.0, object_position=s.object_position + np.array([0, 0.17, 0])) for s in CLEAN]
    start = TASK.target.position - PUSH.target.position
    swept = [replace(s, object_position=s.object_position + start) for s in _pushed(0.17)[:200]]
    late = Moments(push=(1.0, 3.9), lift=(5.0, 7.0), carry=(7.0, 9.0), hold=(9.0, 12.0))
    task = replace(PUSH, target=replace(PUSH.target, position=TASK.target.position), goal=replace(
        PUSH.goal, place=TASK.target.position + np.array([0, 0.17, 0])))  # fmt: skip
    assert _evaluate([*swept, *trace], late, task=task, evaluate=evaluate_sweep).reason == "success"
    lost = [replace(s, grip_force=0.0, touches_table=True, object_position=trace[0].object_position) for s in trace]
    verdict = _evaluate([*swept, *lost], late, task=task, evaluate=evaluate_sweep)
    assert verdict.failure is not None
    assert verdict.failure.cause is Cause.MISSED


def test_what_toppled_in_a_sweep_and_is_not_lifted_afterwards_toppled() -> None:
    """It lies when the grasp begins, and its tilt changes no more."""
    lying = replace(PUSH, goal=replace(PUSH.goal, place=PUSH.target.position + np.array([0, 0.17, 0])))
    trace = [replace(s, object_axis=UP if s.time < 1.5 else LIES) for s in _pushed(0.17)]
    verdict = _evaluate(trace, Moments(push=(1.0, 3.0)), task=lying, evaluate=evaluate_sweep, gave_up="no load")
    assert verdict.failure is not None
    assert (verdict.failure.cause, verdict.failure.time) == (Cause.TOPPLED, pytest.approx(1.48, abs=0.021))


@pytest.mark.parametrize(("bend", "cause"), [(0.5, Cause.SLIPPED), (0.2, Cause.PUSHED_AWAY)])
def test_a_hung_object_that_swings_out_of_the_closed_trunk_slipped(bend: float, cause: Cause) -> None:
    """Out of an open one it was pushed: 17 joints of 0.5 rad are more than a turn, of 0.2 rad less."""
    trace = _from(0.2, LEFT, grip_force=5.0, joint_bend=np.full(17, bend), **SLIDING)
    trace = _from(0.8, trace, grip_force=0.0, object_position=_moved(0.05, 0, 0))
    verdict = _evaluate(trace, task=replace(TASK, goal=replace(TASK.goal, ground=None)))
    assert verdict.failure is not None
    assert (verdict.failure.cause, verdict.failure.time) == (cause, pytest.approx(0.8, abs=0.021))


@pytest.mark.parametrize(("degrees", "is_upright"), [(0, True), (9, True), (11, False), (90, False), (180, False)])
def test_an_object_is_upright_that_stands_at_the_end_as_at_the_begin(degrees: float, is_upright: bool) -> None:
    axis = np.array([0.0, math.sin(math.radians(degrees)), math.cos(math.radians(degrees))])
    verdict = _evaluate(_from(10.2, object_axis=axis))
    assert verdict.is_held
    assert verdict.tilt == pytest.approx(math.radians(degrees), abs=1e-9)
    assert verdict.is_upright is is_upright


def test_what_was_never_held_is_not_set_down_upright() -> None:
    assert _evaluate(LEFT).is_upright is False


def test_a_sphere_has_no_upright() -> None:
    ball = replace(TASK, target=replace(TASK.target, kind="sphere"))
    verdict = _evaluate(_from(10.2, object_axis=LIES), task=ball)
    assert (verdict.is_held, verdict.tilt, verdict.is_upright) == (True, None, None)
