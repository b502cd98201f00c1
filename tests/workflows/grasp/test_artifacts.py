"""Moments and JSON are what they say."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np

from spiraltrunk.control.strategy import Milestone, Status
from spiraltrunk.files.results import format_json
from spiraltrunk.workflows.grasp.film_moments import find_moments
from spiraltrunk.workflows.grasp.verdict.cause import Cause, Failure


def test_json_has_no_nan() -> None:
    value = {"a": np.float64("nan"), "b": [np.inf, np.int64(3), np.bool_(True)], "c": np.arange(2.0)}
    assert json.loads(format_json(value)) == {"a": None, "b": [None, 3, True], "c": [0.0, 1.0]}


GRASP = (
    ("reach", "sidle up", None),
    ("reach", "snuggle up", Milestone.TOUCHED),
    ("prehension", "hook", None),
    ("prehension", "cling", None),
    ("transport", "hoist", Milestone.LIFTED),
    ("transport", "swing over", Milestone.CARRIED),
    ("transport", "show", Milestone.HELD),
    ("release", "put down", Milestone.SET_DOWN),
    ("release", "unhook", Milestone.RELEASED),
)


def _captions(steps: tuple[tuple[str, str, Milestone | None], ...]) -> list[str]:
    return [caption for caption, _ in _moments(steps)]


def _moments(
    steps: tuple[tuple[str, str, Milestone | None], ...], failure: Failure | None = None
) -> list[tuple[str, bool]]:
    """Captions of the film strip of a trial with 1 s for each step, at 10 Hz, and which of them is the failure."""
    statuses = [Status(phase=p, action=a, milestone=m) for p, a, m in steps for _ in range(10)]
    trace = [SimpleNamespace(time=0.1 * i) for i in range(len(statuses) + 1)]
    trial = SimpleNamespace(
        plant=SimpleNamespace(trace=trace), log=SimpleNamespace(statuses=statuses),
        verdict=SimpleNamespace(failure=failure),
    )  # fmt: skip
    return [(moment.caption, moment.is_failure) for moment in find_moments(trial)]  # type: ignore[arg-type]


def test_a_film_strip_shows_the_milestones_whatever_the_actions_are_called() -> None:
    assert _captions(GRASP) == [
        "reach: sidle up, 1.0 s",
        "reach: touched, 2.0 s",
        "prehension: cling, 3.1 s",
        "prehension: cling, 4.0 s",
        "transport: lifted, 5.0 s",
        "transport: held, 6.5 s",
        "release: set down, 8.0 s",
        "release: released, 9.0 s",
    ]


def test_a_film_strip_marks_the_failure_and_believes_no_milestone_after_it() -> None:
    moments = _moments(GRASP, Failure(cause=Cause.DROPPED, time=5.4))
    assert [caption for caption, is_failure in moments if is_failure] == ["transport: dropped, 5.4 s"]
    captions = [caption for caption, _ in moments]
    assert "transport: lifted, 5.0 s" in captions
    assert "transport: show, 6.5 s" in captions
    assert len(captions) == 8


def _pushed(time: float) -> SimpleNamespace:
    """An object that the trunk meets at 2.0 s, that is fastest at 2.5 s and at rest from 3.0 s on."""
    way = float(np.interp(time, [2.0, 2.4, 2.6, 3.0], [0.0, 0.02, 0.06, 0.08]))
    return SimpleNamespace(
        time=time, object_position=np.array([way, 0, 0]), grip_force=1.0 if 1.95 < time < 2.65 else 0.0
    )


def test_a_push_is_shown_where_it_begins_meets_the_object_is_fastest_and_rests() -> None:
    statuses = [Status(phase="reach", action="down") for _ in range(10)]
    statuses += [Status(phase="transport", action="kick", milestone=Milestone.PUSHED) for _ in range(40)]
    trial = SimpleNamespace(
        plant=SimpleNamespace(trace=[_pushed(0.1 * i) for i in range(51)]), log=SimpleNamespace(statuses=statuses),
        verdict=SimpleNamespace(failure=None),
    )  # fmt: skip
    moments = find_moments(trial)  # type: ignore[arg-type]
    assert [moment.caption for moment in moments][-4:] == [
        "transport: push begins, 1.1 s",
        "transport: push meets the object, 2.0 s",
        "transport: object fastest, 0.20 m/s, 2.5 s",
        "transport: object at rest, 3.1 s",
    ]
    assert [moment.is_push for moment in moments][-4:] == [True, True, True, False]


def test_a_film_strip_without_milestones_shows_the_ends_of_actions() -> None:
    bare = tuple((phase, action, None) for phase, action, _ in GRASP)
    captions = _captions(bare)
    assert len(captions) == 8
    assert captions[-1] == "release: unhook, 9.0 s"


def test_a_trial_that_ended_at_once_shows_its_start() -> None:
    assert _captions(()) == ["start, 0.0 s"]
