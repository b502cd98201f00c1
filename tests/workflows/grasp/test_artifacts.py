"""Folders of a record are there whole or not at all; moments and JSON are what they say."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from spiraltrunk.files.results import format_json
from spiraltrunk.workflows.grasp.artifacts import open_record


def test_files_move_in_at_the_end(tmp_path: Path) -> None:
    out = tmp_path / "a" / "b"
    with open_record(out) as draft:
        (draft / "result.json").write_text("{}")
        assert not (out / "result.json").exists()
    assert [path.name for path in out.iterdir()] == ["result.json"]


def test_failure_leaves_what_was_there(tmp_path: Path) -> None:
    (tmp_path / "result.json").write_text("old")

    def fail() -> None:
        with open_record(tmp_path) as draft:
            (draft / "result.json").write_text("new")
            raise OSError

    with pytest.raises(OSError):  # noqa: PT011
        fail()
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"result.json": "old"}


def test_failure_removes_only_folders_that_it_made(tmp_path: Path) -> None:
    def fail() -> None:
        with open_record(tmp_path / "kept" / "made" / "too"):
            raise KeyboardInterrupt

    (tmp_path / "kept").mkdir()
    with pytest.raises(KeyboardInterrupt):
        fail()
    assert list(tmp_path.rglob("*")) == [tmp_path / "kept"]


def test_json_has_no_nan() -> None:
    value = {"a": np.float64("nan"), "b": [np.inf, np.int64(3), np.bool_(True)], "c": np.arange(2.0)}
    assert json.loads(format_json(value)) == {"a": None, "b": [None, 3, True], "c": [0.0, 1.0]}
