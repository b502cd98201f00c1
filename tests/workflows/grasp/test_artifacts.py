"""Moments and JSON are what they say."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np

from spiraltrunk.control.strategy import Milestone, Status
from spiraltrunk.files.results import format_json
from spiraltrunk.workflows.grasp.film_moments import find_moments


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
    """Captions of the film strip of a trial with 1 s for each step, at 10 Hz."""
    statuses = [Status(phase=p, action=a, milestone=m) for p, a, m in steps for _ in range(10)]
    trace = [SimpleNamespace(time=0.1 * i) for i in range(len(statuses) + 1)]
    trial = SimpleNamespace(plant=SimpleNamespace(trace=trace), log=SimpleNamespace(statuses=statuses))
    return [caption for caption, _ in find_moments(trial)]  # type: ignore[arg-type]


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


def test_a_film_strip_without_milestones_shows_the_ends_of_actions() -> None:
    bare = tuple((phase, action, None) for phase, action, _ in GRASP)
    captions = _captions(bare)
    assert len(captions) == 8
    assert captions[-1] == "release: unhook, 9.0 s"


def test_a_trial_that_ended_at_once_shows_its_start() -> None:
    assert _captions(()) == ["start, 0.0 s"]
