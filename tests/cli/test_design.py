"""``spiraltrunk design`` against the design package, and its file against itself."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

from spiraltrunk import cli
from spiraltrunk.cli.verbs.design import _format_table, compute_figures
from spiraltrunk.design import MassDesign, design_from_rules, graspable_range, load_design, payload, presets

KEYS = {
    "a_m", "b", "k", "k_p", "n_section", "n_joint", "section_length_m", "section_radius_m", "length_m", "tip_width_m",
    "base_width_m", "graspable_min_m", "graspable_max_m", "cable_stroke_m", "mass_kg",
}  # fmt: skip


def read(argv: list[str], capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    assert cli.main([*argv, "--json"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    return json.loads(printed.out)


def test_keys_and_figures(capsys: pytest.CaptureFixture[str]) -> None:
    figures = read(["design", "--b", "0.16"], capsys)
    design = design_from_rules(b=0.16)
    assert set(figures) >= KEYS
    assert figures["n_section"] == len(figures["section_length_m"]) == 18
    assert figures["n_joint"] == len(figures["joint_stiffness_nm_per_rad"]) == 17
    assert figures["length_m"] == pytest.approx(sum(figures["section_length_m"]))
    assert (figures["graspable_min_m"], figures["graspable_max_m"]) == tuple(graspable_range(design))
    assert figures["payload_kg"] == payload(design)


def test_base_matches_the_arm(capsys: pytest.CaptureFixture[str]) -> None:
    assert read(["design", "--arm-radius-mm", "30"], capsys)["base_width_m"] == pytest.approx(0.060)


@pytest.mark.parametrize("name", presets.NAMES)
def test_presets(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert read(["design", "--preset", name], capsys)["a_m"] == presets.get(name).spiral.a


def test_written_design_reads_back_the_same(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "trunk.toml"
    figures = read(["design", "--m", "1.2", "--delta-theta-deg", "36", "--turns", "1.6", "--out", str(path)], capsys)
    design = load_design(path)
    assert compute_figures(design) == figures
    assert [file.name for file in tmp_path.iterdir()] == ["trunk.toml"]


def test_table_is_for_people(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["design", "--preset", "paper"]) == 0
    table = capsys.readouterr().out
    assert "Trunk paper" in table
    assert "88 mm at the base" in table


def test_help_and_version_succeed(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["--help"]) == cli.main(["grasp", "--help"]) == cli.main(["--version"]) == 0
    assert "spiraltrunk" in capsys.readouterr().out


@pytest.mark.parametrize(("argv", "heavy"), [(["--help"], "numpy"), (["design"], "mujoco"), (["design"], "matplotlib")])
def test_start_is_light(argv: list[str], heavy: str) -> None:
    start = f"import sys; from spiraltrunk.cli import main; main({argv!r})"
    program = f"{start}; print({heavy!r} in sys.modules, file=sys.stderr)"
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ran.stderr.strip() == "False"


def test_reader_that_leaves_is_no_error() -> None:
    program = "import sys; from spiraltrunk.cli import main; sys.exit(main(['design']))"
    reading, writing = os.pipe()
    os.close(reading)
    ran = subprocess.run(
        [sys.executable, "-c", program], stdout=writing, stderr=subprocess.PIPE, text=True, check=False
    )
    os.close(writing)
    assert (ran.returncode, ran.stderr) == (0, "")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_full_disc_is_one_line() -> None:
    program = "import sys; from spiraltrunk.cli import main; sys.exit(main(['design']))"
    with Path("/dev/full").open("w") as full:
        ran = subprocess.run(
            [sys.executable, "-c", program], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert ran.returncode == 2
    assert ran.stderr == "spiraltrunk: error: cannot write: No space left on device\n"


def test_help_comes_at_once() -> None:
    began = time.perf_counter()
    subprocess.run([sys.executable, "-m", "spiraltrunk", "--help"], capture_output=True, check=True)
    assert time.perf_counter() - began < 2.0


def test_figures_of_a_trunk_too_short_to_wrap():
    short = replace(presets.PAPER, n_section=2, mass=MassDesign())
    figures = compute_figures(short)
    assert figures["graspable_min_m"] is figures["graspable_max_m"] is figures["payload_kg"] is None
    assert "nothing: the trunk is too short to wrap" in _format_table(short, figures)
