"""Design files are written whole or not at all."""

import os
from pathlib import Path

import pytest

from spiraltrunk.design import load_design, write_design
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DesignError


@pytest.mark.parametrize("step", [(Path, "replace"), (os, "fsync")])
@pytest.mark.parametrize("failure", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_a_failed_write_leaves_everything_as_it_was(tmp_path, monkeypatch, step, failure):
    path = tmp_path / "trunk.toml"
    path.write_text("precious")

    def fail(*_, **__):
        raise failure

    monkeypatch.setattr(*step, fail)
    expected = DesignError if isinstance(failure, OSError) else KeyboardInterrupt
    with pytest.raises(expected, match="No space left" if expected is DesignError else None):
        write_design(PAPER, path)
    assert path.read_text() == "precious"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_is_replaced_and_nothing_else_left(tmp_path):
    path = tmp_path / ("x" * 250 + ".toml")
    path.write_text("old")
    assert write_design(PAPER, path) == path
    assert load_design(path) == PAPER
    assert list(tmp_path.iterdir()) == [path]


def test_a_new_file_has_the_usual_permissions(tmp_path):
    (tmp_path / "usual").touch()
    path = write_design(PAPER, tmp_path / "trunk.toml")
    assert path.stat().st_mode == (tmp_path / "usual").stat().st_mode


def test_a_place_that_cannot_be_written_is_refused(tmp_path):
    (tmp_path / "file").touch()
    for path in (
        tmp_path,
        tmp_path / "file" / "trunk.toml",
        tmp_path / "a\0b",
        "y" * 300,
    ):
        with pytest.raises(DesignError, match="allowed: a file, new or replaced") as caught:
            write_design(PAPER, path)
        assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == [tmp_path / "file"]


def test_missing_folders_are_made_and_go_again_when_the_write_fails(tmp_path, monkeypatch):
    path = tmp_path / "deep" / "down" / "trunk.toml"
    assert load_design(write_design(PAPER, path)) == PAPER

    def fail(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(KeyboardInterrupt):
        write_design(PAPER, tmp_path / "deep" / "other" / "way" / "trunk.toml")
    assert sorted(tmp_path.rglob("*")) == [tmp_path / "deep", tmp_path / "deep" / "down", path]


@pytest.mark.parametrize("other", [None, "paper", PAPER.spiral])
def test_only_a_design_is_written(tmp_path, other):
    with pytest.raises(DesignError, match="allowed: TrunkDesign"):
        write_design(other, tmp_path / "trunk.toml")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("mark", ["\x07", "\x00", "\x7f", "\x1b[31m", "\u202e", "\udcff"])
def test_a_note_with_characters_that_toml_has_not_is_written_with_their_codes(tmp_path, mark):
    path = write_design(PAPER, tmp_path / "trunk.toml", [f"fitted to a{mark}b.csv, größer"])
    assert load_design(path) == PAPER
    assert f"# fitted to a{ascii(mark)[1:-1]}b.csv, größer\n" in path.read_text(encoding="utf-8")
