"""``spiraltrunk grasp --replay``: one file, refused before anything runs where it cannot be written."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("viser", reason="viser is not installed")

import spiraltrunk.studio.grasp.replay
import spiraltrunk.workflows.grasp.artifacts
import spiraltrunk.workflows.grasp.recording
import spiraltrunk.workflows.grasp.trial
from spiraltrunk import cli
from spiraltrunk.cli.missing_package import describe_missing

RESULT: dict[str, Any] = {
    "strategy": "wrap-vertical", "object": "cylinder-60", "seed": 4, "success": True, "reason": "success",
    "lift_m": 0.2, "carry_m": 0.2, "hold_s": 3.0, "place_error_m": 0.004, "max_penetration_m": 1e-3,
    "max_joint_deg": 30.0, "real_time_factor": 5.0, "files": [],
}  # fmt: skip


@pytest.fixture
def titles(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Replaces trial and viewer; the titles of the replays that were written."""
    told: list[str] = []
    trial = SimpleNamespace(strategy="wrap-vertical", seed=4, verdict=SimpleNamespace(reason="success"))

    def show(recording: tuple[Any, str]) -> str:
        told.append(recording[1])
        return f"<html>{recording[1]}</html>\n"

    monkeypatch.setattr(spiraltrunk.workflows.grasp.trial, "run_trial", lambda *args, **options: trial)
    monkeypatch.setattr(spiraltrunk.workflows.grasp.artifacts, "compute_result", lambda *args: RESULT)
    monkeypatch.setattr(spiraltrunk.workflows.grasp.recording, "record", lambda *args: args)
    monkeypatch.setattr(spiraltrunk.studio.grasp.replay, "format_replay", show)
    return told


def test_it_is_written_and_replaced_while_it_is_ours(titles: list[str], tmp_path: Path) -> None:
    file = tmp_path / "new" / "grasp.html"
    command = ["grasp", "--seed", "4", "--replay", str(file)]
    assert cli.main(command) == 0
    assert titles == ["wrap-vertical, cylinder-60, seed 4: success"]
    assert file.read_text().startswith("<html>wrap-vertical, cylinder-60, seed 4: success</html>\n<!-- ")
    assert cli.main(command) == 0
    file.write_text("mine")
    assert cli.main(command) == 2
    assert file.read_text() == "mine"
    assert len(titles) == 2


def test_another_ending_is_refused_before_anything_runs(
    titles: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["grasp", "--replay", str(tmp_path / "grasp.mp4")]) == 2
    assert "allowed: a file that ends in .html" in capsys.readouterr().err
    assert cli.main(["grasp", "--replay", str(tmp_path)]) == 2
    assert titles == []


def test_a_place_that_cannot_be_written_is_refused_before_anything_runs(
    titles: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(place: Path) -> int:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS), str(place))

    monkeypatch.setattr("spiraltrunk.files.atomic.acquire_lock", refuse)
    monkeypatch.setattr(spiraltrunk.workflows.grasp.trial, "run_trial", lambda *_, **__: pytest.fail("a trial ran"))
    assert cli.main(["grasp", "--replay", str(tmp_path / "grasp.html")]) == 2
    error = capsys.readouterr().err
    assert "--replay: " in error
    assert "cannot be written: Read-only file system; allowed" in error
    assert error.count("\n") == 1


@pytest.mark.slow
def test_without_the_extra_one_line_tells_how_to_install_it(tmp_path: Path) -> None:
    """A process of its own: here the package is loaded."""
    code = "import sys; sys.modules['viser'] = None; from spiraltrunk.cli import main; sys.exit(main(sys.argv[1:]))"
    command = [sys.executable, "-c", code, "grasp", "kick", "--no-video", "--replay", "kick.html"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 2
    error = done.stderr.splitlines()[-1]
    assert error == f"spiraltrunk: error: {describe_missing('viser')}"
    assert list(tmp_path.iterdir()) == []
