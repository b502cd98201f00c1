"""A trial, run and told."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from typing import Any

import pytest

import spiraltrunk.workflows.grasp.trial as trial
import spiraltrunk.workflows.survey.run_entry as work
from spiraltrunk import cli
from spiraltrunk.control.strategy import Status
from spiraltrunk.design import presets
from spiraltrunk.errors import ModelError
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.workflows.grasp.world import draw_scene
from spiraltrunk.workflows.survey.plan import Entry
from spiraltrunk.workflows.survey.row import build_empty_row
from spiraltrunk.workflows.survey.run_entry import compute_row, count_retries

ENTRY = Entry(strategy="wrap-vertical", object="cylinder-60", index=3, seed=5)


def fail_with(error: Exception, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    def refuse(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(work, "run_scene", refuse)
    return compute_row(ENTRY)


@pytest.mark.parametrize("error", [ModelError("out of\nreach"), ZeroDivisionError("a bug")])
def test_what_is_raised_is_a_failure_in_a_known_world(error: Exception, monkeypatch: pytest.MonkeyPatch) -> None:
    row = fail_with(error, monkeypatch)
    assert not row["success"]
    assert row["reason"] == f"{type(error).__name__}: {' '.join(str(error).split())}"
    assert set(row) == set(build_empty_row(ENTRY))
    assert 0.054 <= row["width_m"] <= 0.066
    assert 0.5 <= row["friction"] <= 1.2
    assert row["lift_m"] is None
    json.dumps(row, allow_nan=False)


def test_the_scene_is_drawn_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """The row and the trial share one scene, the one that ``spiraltrunk grasp`` draws from the same seed."""
    drawn: list[SceneOptions] = []
    built: list[SceneOptions] = []

    def count_draw(*arguments: Any, **keywords: Any) -> SceneOptions:
        drawn.append(draw_scene(*arguments, **keywords))
        return drawn[-1]

    def stop_at_plant(design: object, options: SceneOptions) -> None:
        built.append(options)
        raise ModelError("far enough")

    monkeypatch.setattr(work, "draw_scene", count_draw)
    monkeypatch.setattr(trial, "draw_scene", count_draw)
    monkeypatch.setattr(trial, "SimPlant", stop_at_plant)
    row = compute_row(ENTRY)
    assert row["reason"] == "ModelError: far enough"
    assert len(drawn) == 1
    with pytest.raises(ModelError, match="far enough"):
        trial.run_trial(presets.PAPER, parse_object(ENTRY.object), strategy=ENTRY.strategy, seed=ENTRY.seed)
    assert built[0] == built[1] == drawn[0]
    assert row["mass_kg"] == built[1].shape.mass


def test_an_unknown_object_is_a_failure() -> None:
    row = compute_row(replace(ENTRY, object="banana"))
    assert "unknown object 'banana'" in row["reason"]
    assert row["width_m"] is None


def test_steps_that_begin_again_are_retries() -> None:
    def told(*steps: str) -> list[Status]:
        return [Status(phase=phase, action=action) for phase, action in (step.split("/") for step in steps)]

    assert count_retries([]) == 0
    assert count_retries(told("reach/go", "prehension/curl", "prehension/curl", "transport/lift")) == 0
    assert count_retries(told("prehension/curl", "prehension/open", "prehension/curl", "transport/lift")) == 1
    assert count_retries(told("prehension/curl", "transport/lift", "prehension/open", "prehension/curl")) == 1
    assert count_retries(told("release/lower", "release/raise", "release/lower")) == 0


@pytest.mark.slow
def test_grasp_plays_a_trial_again(capsys: pytest.CaptureFixture[str]) -> None:
    row = compute_row(ENTRY)
    cli.main(["grasp", "wrap-vertical", "--object", "cylinder-60", "--seed", "5", "--json"])
    result = json.loads(capsys.readouterr().out)
    same = ("strategy", "object", "seed", "success", "reason", "lift_m", "hold_s", "place_error_m")
    assert [row[key] for key in same] == [result[key] for key in same]
    assert row["friction"] == result["world"]["friction"]
    assert math.isclose(row["simulated_s"], result["phases"][-1]["end_s"], abs_tol=1e-9)


def test_a_package_that_is_missing_ends_the_trial(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*arguments: object, **options: object) -> None:
        raise ModuleNotFoundError(name="mink")

    monkeypatch.setattr(work, "run_scene", fail)
    with pytest.raises(ModuleNotFoundError):
        compute_row(ENTRY)
