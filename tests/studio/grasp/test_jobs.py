"""The work of the tab, without a page."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from spiraltrunk.design import presets
from spiraltrunk.errors import DesignError, ModelError, SpiralTrunkError
from spiraltrunk.sim.body_meshes import ModelMeshes
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.studio.grasp.jobs import build_scene, read_upload, run_grasp
from spiraltrunk.studio.grasp.object_picker import name_upload
from spiraltrunk.studio.grasp.request import GraspRequest
from spiraltrunk.studio.grasp.tab import list_strategies
from spiraltrunk.studio.grasp.texts import describe_choice, describe_result, format_ranking
from spiraltrunk.workflows.grasp.choice.candidates import Candidate
from spiraltrunk.workflows.grasp.recording import RATE, join_frames
from spiraltrunk.workflows.grasp.trial import run_trial

from .conftest import RESULT


def ask(strategy="wrap-vertical", name="cylinder-60", stage="hung", seed=0):
    shape = parse_object(name)
    return GraspRequest(
        design=presets.PAPER, shape=shape, name=name, option=name, strategy=strategy, stage=stage, seed=seed
    )


@pytest.mark.parametrize(
    ("design", "told"),
    [
        (presets.PAPER, ""),
        (presets.get("spirob-15"), " --design spirob-15"),
        (replace(presets.PAPER, gripper=None), " --design FILE.toml"),
    ],
)
def test_a_grasp_has_the_command_of_its_own_request(design, told):
    design = replace(design, cable=replace(design.cable, friction=0.33))
    request = replace(ask(strategy="auto", seed=4), design=design, name="mine", option="stl:path=FILE,mass_g=90")
    assert request.command == (
        f"spiraltrunk grasp auto --object stl:path=FILE,mass_g=90 --stage hung{told} --friction 0.33 --seed 4"
    )


def test_what_cannot_be_taken_is_refused_in_words_before_anything_runs():
    said = []
    with pytest.raises(ModelError, match="'rod-10' is 10 mm wide; allowed:"):
        run_grasp(said.append, ask(name="rod-10"))
    assert said == []


def test_the_scene_shows_the_object_where_the_seed_puts_it():
    one, other = build_scene(ask(seed=1)), build_scene(ask(seed=2))
    assert len(one.frames) == 1
    assert not np.array_equal(one.frames.pose[0, -1], other.frames.pose[0, -1])
    assert one.frames.string.shape == (1, 2, 2, 3)


def test_an_uploaded_file_is_read_and_told_about():
    content = trimesh.creation.box((40.0, 50.0, 120.0)).export(file_type="stl")
    shape = read_upload(print, content, "stl", 0.2, {"axis": "longest", "collide": "hull"})
    assert shape.mass == 0.2
    assert any("the unit is guessed" in note for note in shape.warnings)
    with pytest.raises(DesignError, match=r"'object\.obj'"):
        read_upload(print, b"\0\1", "obj", 0.2, {})


def test_strategies_by_stage():
    assert list_strategies("hung") == ("auto", "wrap-vertical")
    assert {"auto", "pinch", "kick", "sweep"} <= set(list_strategies("ground"))


def test_choices_and_results_are_told_in_words():
    able = Candidate(strategy="pinch", feasible=True, score=0.9, reason="fits")
    push = Candidate(strategy="kick", feasible=True, score=0.0, reason="pushes")
    unable = Candidate(strategy="tip-grip", feasible=False, score=0.0, reason="too wide by 20 mm")
    assert describe_choice("pinch", (able, unable)) == "**pinch** can take it, predicted chance 90%: fits."
    both = tuple(replace(able, reason=f"fits; rate 0.98{told}") for told in ("", ", times 0.92 for reach"))
    assert describe_choice("pinch", both[:1]) == (
        "**pinch** can take it, predicted chance 90% (the rate of success in simulation): fits."
    )
    assert describe_choice("pinch", both[1:]) == (
        "**pinch** can take it, predicted chance 90% (rate of success in simulation 98%, times 0.92 for reach): fits."
    )
    assert format_ranking(both).splitlines()[-2:] == [
        "- **pinch** ✓ 90%: fits",
        "- **pinch** ✓ 90% (rate of success in simulation 98%, times 0.92 for reach): fits",
    ]
    assert describe_choice("kick", (able, push)) == "**kick** can take it: pushes."
    assert "cannot take it: too wide by 20 mm. Best: **pinch**." in describe_choice("tip-grip", (able, unable))
    assert describe_choice("auto", (unable,)) == "No strategy of this stage can take it; try the other stage."
    assert format_ranking((able, unable)).splitlines()[-1] == "- **tip-grip** ✗ no: too wide by 20 mm"
    assert describe_result(RESULT).startswith("**Success.** Held by the trunk alone for 3.0 s, set down 4 mm")
    kick = {**RESULT, "strategy": "kick", "hold_s": 0.0, "carry_m": 0.1734}
    assert describe_result(kick) == "**Success.** Moved along the ground by 173 mm."
    failed = {**RESULT, "success": False, "reason": "the object fell", "cause": "dropped", "cause_time_s": 12.34}
    assert describe_result(failed) == "**Failed:** the object fell. Cause: **dropped** at 12.3 s."


@pytest.mark.slow
def test_a_run_reports_every_frame_once_and_ends_as_the_trial_does():
    said = []
    result = run_grasp(said.append, ask("kick", "cylinder-60", "ground"))
    assert isinstance(said[0], ModelMeshes)
    frames = join_frames(said[1:])
    assert frames.time == pytest.approx(np.arange(len(frames)) / RATE)
    trial = run_trial(presets.PAPER, parse_object("cylinder-60"), strategy="kick")
    assert result["reason"] == trial.verdict.reason
    assert frames.time[-1] == pytest.approx(trial.plant.trace[-1].time, abs=1 / RATE)


@pytest.mark.parametrize("content", [b"", b"hello, no mesh", b"x" * 80 + b"\xff" * 4, b"solid a\nendsolid a\n"])
def test_a_refused_file_is_told_by_the_name_that_the_person_knows(content):
    with pytest.raises(SpiralTrunkError) as told:
        read_upload(lambda _: None, content, "stl", 0.25, {})
    text = name_upload(str(told.value), "mine.stl")
    assert "mine.stl" in text
    assert "object.stl" not in text
    assert "/" not in text
