"""``spiraltrunk export`` as it is typed."""

from __future__ import annotations

import json

import pytest

from spiraltrunk.cli import main
from spiraltrunk.design import presets

pytest.importorskip("build123d", reason="solids need the extra cad")


@pytest.mark.slow
def test_json_alone_on_standard_output(capsys, tmp_path):
    out = str(tmp_path / "made")
    code = main(["export", "--parts", "horn", "drums", "--formats", "stl", "--out", out, "--json"])
    said = capsys.readouterr()
    assert code == 0, said.err
    result = json.loads(said.out)
    assert set(result["checks"]) == {"horn", "drum"}
    assert set(result["checks"]["horn"]) >= {"watertight", "volume_m3", "min_wall_m", "holds"}
    assert "parts/horn.stl" in result["files"]
    assert result["mass_kg"] == presets.PAPER.total_mass
    assert "spiraltrunk: horn" in said.err


def test_without_out_nothing_is_written(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["export", "--parts", "horn"]) == 0
    assert "horn" in capsys.readouterr().out
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--parts", "nose"], "unknown part 'nose'; known: all, trunk"),
        (["--formats", "obj"], "unknown format 'obj'; known: step"),
        (["--nozzle-mm", "0"], "--nozzle-mm is 0.0; allowed: a finite number, at least 0.05"),
        (["--tolerance-mm", "nan"], "'nan' given; allowed: a finite number"),
        (["--bed-mm", "1", "2"], "--bed-mm"),
        (["--bed-mm", "1", "2", "3"], "--bed-mm X is 1.0; allowed"),
        (["--seed", "-1"], "--seed"),
        (["nothing.toml"], "nothing.toml"),
        (
            ["--parts", "trunk", "--formats", "mjcf"],
            "--parts trunk given with --formats mjcf; allowed: with --parts one of step, stl, 3mf, or these formats",
        ),
        (["--parts", "horn", "paper"], "'paper' stands behind --parts or --formats; allowed: the design before these"),
        (
            ["spirob-1m", "--parts", "gripper", "trunk", "--bed-mm", "99", "99", "99"],
            "trunk is 120.0 mm wide at section 1",
        ),
    ],
)
def test_bad_input_is_one_line(capsys, tmp_path, arguments, line):
    out = tmp_path / "made"
    assert main(["export", *arguments, "--out", str(out)]) == 2
    said = [text for text in capsys.readouterr().err.splitlines() if "error" in text]
    assert len(said) == 1
    assert line in said[0]
    assert not out.exists()
