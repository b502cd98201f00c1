"""``spiraltrunk grasp`` and ``bench``: one real trial twice, and what comes of failures and interruptions."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import spiraltrunk.cli.verbs.grasp
import spiraltrunk.workflows.bench
import spiraltrunk.workflows.grasp.artifacts
import spiraltrunk.workflows.grasp.pictures
import spiraltrunk.workflows.grasp.trial
from spiraltrunk import cli
from spiraltrunk.control.arm_limits import find_missing_limits
from spiraltrunk.design import ArmDesign, load_design, presets, write_design
from spiraltrunk.errors import MissingPackage, RunError
from spiraltrunk.report import Series
from spiraltrunk.report.trial.figures import FIGURES
from spiraltrunk.sim.objects.catalogue import DEFAULT_OBJECT, parse_object
from spiraltrunk.sim.robot.arm import arm_limits
from spiraltrunk.workflows.bench import Claim
from spiraltrunk.workflows.grasp.trial import Trial, run_trial

KEYS = {
    "strategy", "object", "success", "reason", "phases", "lift_m", "hold_s", "max_penetration_m", "max_joint_deg",
    "real_time_factor", "seed", "cause", "cause_time_s", "held", "upright", "tilt_deg",
    "versions", "world", "place_error_m", "files",
    "front", "limits_judged", "limits_not_judged",
}  # fmt: skip
PLAIN = {
    "result.json", "trunk.toml", "overview.png", "cables.png", "joints.png", "curvature.png", "object.png", "force.png",
}  # fmt: skip


@pytest.fixture(scope="module")
def trial() -> Trial:
    return run_trial(presets.PAPER, parse_object(DEFAULT_OBJECT))


@pytest.fixture
def played(trial: Trial, monkeypatch: pytest.MonkeyPatch) -> Trial:
    """The command line gets this trial without running it again."""
    monkeypatch.setattr(spiraltrunk.workflows.grasp.trial, "run_trial", lambda *args, **options: trial)
    return trial


@pytest.fixture
def unplotted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Plots take seconds: here each is a file with its name in it."""

    def write(series: Series, folder: Path) -> None:
        for name in FIGURES:
            (folder / name).write_text(name)

    monkeypatch.setattr(spiraltrunk.workflows.grasp.artifacts, "write_plots", write)


def strict(text: str) -> dict[str, Any]:
    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is no JSON")

    return json.loads(text, parse_constant=refuse)


def test_real_grasp_leaves_a_record_and_is_the_same_again(
    trial: Trial, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "new" / "grasp"
    code = cli.main(["grasp", "--no-video", "--json", "--out", str(out)])
    printed = capsys.readouterr()
    result = strict(printed.out)
    assert code == (0 if result["success"] else 1)
    assert set(result) >= KEYS
    assert strict((out / "result.json").read_text()) == result
    assert {path.name for path in out.glob("[!.]*")} == set(result["files"]) == PLAIN
    assert load_design(out / "trunk.toml") == presets.PAPER
    assert printed.err.splitlines() == [
        f"spiraltrunk: {what}" for what in ("reach", "prehension", "transport", "release", "plots")
    ]
    expected = spiraltrunk.workflows.grasp.artifacts.compute_result(trial, DEFAULT_OBJECT)
    for key in KEYS - {"real_time_factor", "files"}:
        assert result[key] == expected[key], key


def test_default_grasp_succeeds(trial: Trial) -> None:
    assert trial.verdict.reason == "success"


def test_the_curl_spreads_from_the_tip_and_back(trial: Trial) -> None:
    front = spiraltrunk.workflows.grasp.artifacts.compute_result(trial, DEFAULT_OBJECT)["front"]
    assert (front["is_inward"], front["is_outward"]) == (True, True)
    assert front["prehension_start"] == front["release_end"] == 0.0
    assert 0.5 < front["transport_max"] < 0.9
    assert min(front["tip_first"], front["base_first"]) >= 0.75


def test_phases_follow_one_another(trial: Trial) -> None:
    phases = spiraltrunk.workflows.grasp.artifacts.compute_result(trial, DEFAULT_OBJECT)["phases"]
    assert [phase["name"] for phase in phases] == ["reach", "prehension", "transport", "release"]
    assert all(first["end_s"] == then["start_s"] for first, then in pairwise(phases))
    assert phases[-1]["end_s"] == trial.plant.trace[-1].time


def test_without_out_nothing_is_written(
    played: Trial, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cli.main(["grasp"]) == 0
    assert "wrap-vertical, cylinder-60, seed 0: success" in capsys.readouterr().out
    assert list(tmp_path.iterdir()) == []


def test_failed_grasp_exits_1_with_its_reason(
    trial: Trial, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    lost = replace(trial, verdict=replace(trial.verdict, success=False, reason="lifted 0 cm", hold=math.nan))
    monkeypatch.setattr(spiraltrunk.workflows.grasp.trial, "run_trial", lambda *args, **options: lost)
    assert cli.main(["grasp", "--json"]) == 1
    result = strict(capsys.readouterr().out)
    assert (result["success"], result["reason"], result["hold_s"]) == (False, "lifted 0 cm", None)
    assert cli.main(["grasp"]) == 1
    assert "failed: lifted 0 cm" in capsys.readouterr().out


def test_an_arm_that_states_no_limits_is_not_passed_in_silence(
    trial: Trial, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """One warning line, and what was not judged in the result; the described arms have neither."""
    (tmp_path / "slide.xml").write_text("""
      <mujoco>
        <worldbody>
          <body><joint name="up" type="slide" range="-1 1"/><geom size=".1" mass="1"/><site name="tool"/></body>
        </worldbody>
        <actuator><position joint="up" kp="1000" forcerange="-500 500"/></actuator>
      </mujoco>""")
    design = replace(presets.PAPER, arm=ArmDesign(model="slide.xml", mount_site="tool"))
    write_design(design, tmp_path / "trunk.toml")
    unjudged = find_missing_limits(arm_limits(load_design(tmp_path / "trunk.toml").arm))
    told = replace(trial, verdict=replace(trial.verdict, unjudged=unjudged))
    monkeypatch.setattr(spiraltrunk.workflows.grasp.trial, "run_trial", lambda *args, **options: told)
    cli.main(["grasp", "--json", "--design", str(tmp_path / "trunk.toml")])
    printed = capsys.readouterr()
    result = strict(printed.out)
    assert (result["limits_judged"], result["limits_not_judged"]) == (False, ["velocity", "acceleration", "jerk"])
    (line,) = printed.err.splitlines()
    assert line.endswith("slide.xml' states no limit of velocity, acceleration, jerk: not judged")
    monkeypatch.setattr(spiraltrunk.workflows.grasp.trial, "run_trial", lambda *args, **options: trial)
    cli.main(["grasp", "--json"])
    printed = capsys.readouterr()
    result = strict(printed.out)
    assert (result["limits_judged"], result["limits_not_judged"], printed.err) == (True, [], "")


@pytest.mark.usefixtures("unplotted")
def test_without_graphics_the_rest_is_written(
    played: Trial, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(*args: object, **options: object) -> None:
        raise MissingPackage("no OpenGL for pictures: install libegl1")

    monkeypatch.setattr(spiraltrunk.workflows.grasp.pictures, "render_frames", refuse)
    assert cli.main(["grasp", "--out", str(tmp_path)]) == 0
    assert {path.name for path in tmp_path.glob("[!.]*")} == PLAIN
    assert [line for line in capsys.readouterr().err.splitlines() if "libegl1" in line] == [
        "spiraltrunk: no film strip and no video: no OpenGL for pictures: install libegl1"
    ]


@pytest.mark.usefixtures("unplotted")
def test_old_pictures_do_not_outlive_their_trial(
    played: Trial, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def draw(trial: Trial, path: Path, *_: object, **__: object) -> None:
        path.write_text("of an earlier trial")

    monkeypatch.setattr(spiraltrunk.workflows.grasp.artifacts, "write_strip", draw)
    monkeypatch.setattr(spiraltrunk.workflows.grasp.artifacts, "write_film", draw)
    assert cli.main(["grasp", "--out", str(tmp_path)]) == 0
    assert (tmp_path / "grasp.mp4").exists()
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "filmstrip.png").write_text("with my notes")
    assert cli.main(["grasp", "--no-video", "--out", str(tmp_path)]) == 0
    assert {path.name for path in tmp_path.glob("[!.]*")} == PLAIN | {"notes.txt", "filmstrip.png"}


CUTS = {
    "interrupted": (KeyboardInterrupt(), 130),
    "diverged": (RunError("diverged"), 1),
    "full": (OSError(28, "full"), 2),
}


@pytest.mark.parametrize("cut", CUTS)
@pytest.mark.parametrize(
    "where",
    [(spiraltrunk.workflows.grasp.trial, "run_trial"), (spiraltrunk.workflows.grasp.artifacts, "compute_result")],
)
@pytest.mark.usefixtures("played", "unplotted")
def test_what_is_cut_short_leaves_nothing(
    cut: str,
    where: tuple[Any, str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    error, code = CUTS[cut]

    def fail(*args: object, **options: object) -> None:
        raise error

    monkeypatch.setattr(*where, fail)
    assert cli.main(["grasp", "--no-video", "--out", str(tmp_path / "deep" / "out")]) == code
    printed = capsys.readouterr()
    assert printed.out == ""
    assert len([line for line in printed.err.splitlines() if line != "spiraltrunk: plots"]) == 1
    assert list(tmp_path.iterdir()) == []


def test_bench(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    claims = {"fast": lambda: Claim(ours=1.0, other=12.0, bar=10.0)}
    monkeypatch.setattr(spiraltrunk.workflows.bench, "CLAIMS", claims)
    assert cli.main(["bench", "--json", "--out", str(tmp_path)]) == 0
    result = strict(capsys.readouterr().out)
    fast = {"ours": 1.0, "other": 12.0, "ratio": 12.0, "bar": 10.0, "holds": True}
    assert result == {"claims": {"fast": fast}, "complete": True}
    assert strict((tmp_path / "result.json").read_text()) == result
    claims["slow"] = lambda: Claim(ours=1.0, other=9.9, bar=10.0)
    assert cli.main(["bench"]) == 1
    assert "missed" in capsys.readouterr().out


def test_an_interrupted_bench_keeps_the_claims_that_were_measured(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupt() -> Claim:
        raise KeyboardInterrupt

    claims = {"fast": lambda: Claim(ours=1.0, other=12.0, bar=10.0), "never": interrupt}
    monkeypatch.setattr(spiraltrunk.workflows.bench, "CLAIMS", claims)
    assert cli.main(["bench", "--out", str(tmp_path)]) == 130
    result = strict((tmp_path / "result.json").read_text())
    assert (set(result["claims"]), result["complete"]) == ({"fast"}, False)
    claims["never"] = claims["fast"]
    assert cli.main(["bench", "--out", str(tmp_path)]) == 0
    assert strict((tmp_path / "result.json").read_text())["complete"]


def test_bench_against_peers(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Without their packages one line says how to get them, and nothing is measured."""
    monkeypatch.setattr(spiraltrunk.workflows.bench, "CLAIMS", {"fast": lambda: Claim(ours=1.0, other=12.0, bar=10.0)})
    monkeypatch.setattr(spiraltrunk.workflows.bench, "PEERS", {"peer": lambda: Claim(ours=1.0, other=2.0, bar=1.0)})
    monkeypatch.setitem(sys.modules, "elastica", None)
    assert cli.main(["bench", "--peers"]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.splitlines() == [
        "spiraltrunk: error: PyElastica is not installed; the extra peers has it: pip install 'spiraltrunk[peers]'"
    ]
    monkeypatch.setitem(sys.modules, "elastica", sys)
    assert cli.main(["bench", "--peers", "--json"]) == 0
    assert set(strict(capsys.readouterr().out)["claims"]) == {"fast", "peer"}


DRAWN = """
import sys
from spiraltrunk import cli
cli.main(["--version"])  # Sets up the environment, as OpenGL is chosen when MuJoCo is imported.
import spiraltrunk.workflows.grasp.pictures
spiraltrunk.workflows.grasp.pictures.FPS = 1
sys.exit(cli.main(["grasp", "kick", "--out", sys.argv[1]]))
"""


@pytest.mark.slow
@pytest.mark.gl
@pytest.mark.usefixtures("played", "unplotted")
def test_pictures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Film strip and video of one frame a second, drawn by this process."""
    monkeypatch.setattr(spiraltrunk.workflows.grasp.pictures, "FPS", 1)
    monkeypatch.setattr(spiraltrunk.cli.verbs.grasp, "_WORKERS", 1)
    assert cli.main(["grasp", "--out", str(tmp_path)]) == 0
    check_pictures(tmp_path)


@pytest.mark.slow
@pytest.mark.gl
def test_pictures_of_a_fresh_process(tmp_path: Path) -> None:
    """The whole verb, with the processes that draw the video."""
    command = [sys.executable, "-c", DRAWN, str(tmp_path)]
    ran = subprocess.run(command, env=os.environ, capture_output=True, text=True, check=False)
    if "no OpenGL" in ran.stderr:
        pytest.skip(ran.stderr.splitlines()[-1])
    assert ran.returncode == 0, ran.stderr
    check_pictures(tmp_path)


def check_pictures(folder: Path) -> None:
    av = pytest.importorskip("av")
    assert {path.name for path in folder.glob("[!.]*")} == PLAIN | {"grasp.mp4", "filmstrip.png"}
    duration = strict((folder / "result.json").read_text())["phases"][-1]["end_s"]
    with av.open(str(folder / "grasp.mp4")) as video:
        frames = [frame.to_ndarray(format="rgb24") for frame in video.decode(video=0)]
    assert len(frames) == pytest.approx(duration, abs=1.0)
    assert frames[0].shape == (480, 640, 3)
    assert all(np.ptp(frame) > 150 for frame in frames)
    assert np.abs(frames[0].astype(float) - frames[len(frames) // 2]).max() > 100
