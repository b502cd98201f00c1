"""``spiraltrunk grasp auto`` where no strategy can take the object: reasons and a hint, no figures of a motion."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import spiraltrunk.workflows.grasp.choice.ranking
from spiraltrunk import cli
from spiraltrunk.cli.verbs.grasp import _format_choice, format_verdict

HEAVY = "cylinder:diameter_mm=300,height_mm=200,mass_g=900"


@pytest.mark.filterwarnings("error")
def test_a_refusal_of_all_is_no_trial(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(
        spiraltrunk.workflows.grasp.choice.ranking, "find_alternatives", lambda *_: {"--stage hung": "wrap-vertical"}
    )
    out = tmp_path / "out"
    assert cli.main(["grasp", "auto", "--object", HEAVY, "--no-video", "--json", "--out", str(out)]) == 1
    printed = capsys.readouterr()
    result = json.loads(printed.out, parse_constant=pytest.fail)
    assert "spiraltrunk: wrap-vertical can take it with --stage hung" in printed.err.splitlines()
    assert "Warning" not in printed.err
    assert {path.name for path in out.glob("[!.]*")} == {"result.json"}
    assert (result["cause"], result["attempts"], result["phases"]) == ("refused", [], [])
    assert [result[key] for key in ("front", "lift_m", "place_error_m", "max_joint_deg", "upright")] == [None] * 5
    text = format_verdict(result)
    assert text.splitlines()[0] == f"auto, {HEAVY}, seed 0: no strategy can take it"
    assert text.count("too wide for the fingers by") == 3  # Once for each strategy with fingers.
    assert "set down" not in text
    assert text.endswith("kick and sweep push an object along the ground; they do not lift it and are not ranked")


def test_a_thing_that_would_hardly_stand_is_told_as_laid_down(capsys: pytest.CaptureFixture[str]) -> None:
    from spiraltrunk.cli.object_check import warn_laid
    from spiraltrunk.design.presets import PAPER
    from spiraltrunk.sim.objects.catalogue import parse_object
    from spiraltrunk.workflows.grasp.choice.auto import get_strategy

    for given, told in (
        ("cylinder:diameter_mm=15,height_mm=200,mass_g=50", "standing it would topple at 4.2 deg, 5 deg needed: laid"),
        ("cylinder:diameter_mm=60,height_mm=200,mass_g=50", ""),
    ):
        shape = parse_object(given)
        warn_laid(get_strategy("auto", PAPER, shape), shape)
        err = capsys.readouterr().err
        assert told in err
        assert bool(told) == bool(err)


def test_a_try_that_aims_beside_the_place_says_so() -> None:
    tries = [
        {"strategy": "wrap-oblique-low", "start_s": 0.0, "outcome": "set down askew", "place_correction_m": [0.0] * 3},
        {"strategy": "wrap-oblique", "start_s": 30.0, "outcome": "lifted", "place_correction_m": [0.03, -0.04, 0.0]},
    ]
    text = _format_choice({"attempts": tries, "candidates": [], "world": {"ground_m": None}})
    rows = dict(line.split(maxsplit=1) for line in text.splitlines() if line.strip().startswith("wrap"))
    assert rows["wrap-oblique-low"] == "set down askew"
    assert rows["wrap-oblique"] == "lifted; aimed 5 cm beside the place, against the error before"


def test_a_kick_is_told_as_a_push() -> None:
    figures = dict.fromkeys(("lift_m", "hold_s", "place_error_m", "max_penetration_m", "max_joint_deg"), 0.0)
    result = figures | {"object": "box-80", "seed": 0, "success": True, "carry_m": 0.311, "real_time_factor": 3.0}
    assert "pushed               311 mm" in format_verdict(result | {"strategy": "kick"})
    assert "lifted" not in format_verdict(result | {"strategy": "kick"})
    assert "lifted" in format_verdict(result | {"strategy": "pinch"})
