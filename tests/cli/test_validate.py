"""``spiraltrunk validate``: from files to figures, report and plan; what is wrong is one line and leaves nothing."""

from __future__ import annotations

import csv
import json
import re
import shutil
import sys
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from spiraltrunk import cli
from spiraltrunk.design import load_design, write_design
from spiraltrunk.design.presets import PAPER
from spiraltrunk.mocap import load_protocol, load_shapes
from spiraltrunk.mocap.protocol.schedule import build_schedule
from spiraltrunk.mocap.recordings.motive_write import write_motive
from spiraltrunk.mocap.session.prediction import predict
from spiraltrunk.workflows.virtual_session.synthetic_take import CameraOptions, build_synthetic_take

PROTOCOL = """
name = "short"
axes = "y-up"
alignment = "base"
[[run]]
name = "rest-045"
kind = "rest"
tilt_deg = 45
[[run]]
name = "bend"
kind = "bend-dorsal"
tilt_deg = 0
steps = 3
step_mm = 20
takes = 2
"""
SHIFT = np.array([0.0, 0.0, 5e-3])
KEYS = {"shapes", "sections", "rmse_per_shape_m", "rmse_per_section_m", "mean_rmse_m", "max_rmse_m", "max_deviation_m"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A protocol and recordings of the paper's model, 5 mm beside it."""
    folder = tmp_path_factory.mktemp("takes")
    (folder / "protocol.toml").write_text(PROTOCOL)
    protocol = load_protocol(folder / "protocol.toml")
    for run in protocol.runs:
        found = predict(PAPER, build_schedule(PAPER, protocol, run))
        for take in range(run.takes):
            rehearsal = CameraOptions(rate=60.0, hold=0.8, move=0.4, noise=5e-5, sections=(2, 5, 8, 11), seed=take)
            recorded = build_synthetic_take(PAPER, found.points + SHIFT, found.rotation, run.theta_0, rehearsal)
            write_motive(recorded, folder / f"{run.name}_{take + 1}.csv")
    return folder


def validate(folder: Path, *more: str) -> list[str]:
    return ["validate", *map(str, sorted(folder.glob("*.csv"))), "--protocol", str(folder / "protocol.toml"), *more]


def refuse(argv: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    assert cli.main(argv) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    errors = [line for line in printed.err.splitlines() if line.startswith("spiraltrunk: error: ")]
    assert len(errors) == 1
    return errors[0]


def test_json_tells_the_errors_that_were_put_in(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*validate(folder), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["model"], told["alignment"], told["axes"], told["files"]) == ("reference", "base", "y-up", [])
    assert set(told["runs"]) == {"rest-045", "bend"}
    for run in told["runs"].values():
        assert set(run) >= KEYS
        assert run["sections"] == [2, 5, 8, 11]
        np.testing.assert_allclose(run["rmse_per_shape_m"], 5e-3, atol=2e-4)
        np.testing.assert_allclose(run["rmse_per_section_m"], 5e-3, atol=3e-4)
        assert run["mean_rmse_m"] == pytest.approx(5e-3, abs=2e-4)
    assert (told["runs"]["bend"]["shapes"], len(told["runs"]["bend"]["takes"])) == (4, 2)
    assert told["runs"]["rest-045"]["tilt_deg"] == 45
    assert told["mean_rmse_by_alignment_m"]["run"]["bend"] < 3e-4
    assert told["paper"]["bend_dorsal"] == {"mean_rmse_m": 0.01041, "max_deviation_m": 0.03214}
    assert [told["paper"]["rest"][tilt]["rmse_m"] for tilt in ("0", "45", "90", "135")] == [
        0.00548, 0.01057, 0.01045, 0.01986,
    ]  # fmt: skip
    assert told["notes"][0].startswith("not a measurement: 3 recordings are synthetic")


class Page(HTMLParser):
    """Texts and pictures of a page, and the tags that are open."""

    def __init__(self) -> None:
        super().__init__()
        self.text, self.pictures, self.tags = "", 0, set()

    def handle_starttag(self, tag: str, attrs: list) -> None:
        self.tags.add(tag)
        if tag == "img":
            self.pictures += dict(attrs)["src"].startswith("data:image/png;base64,") and bool(dict(attrs)["alt"])

    def handle_data(self, data: str) -> None:
        self.text += data


def test_a_report_is_written_whole(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "made" / "out"
    assert cli.main([*validate(folder), "--alignment", "shape", "--out", str(out)]) == 0
    printed = capsys.readouterr()
    assert re.search(r"bend +4 +2 +4 +0\.0\d +0\.0\d +0\.\d\d +0\.0\d", printed.out)
    assert "bending, hanging: mean RMSE" in printed.out
    assert "10.41" in printed.out
    result = json.loads((out / "result.json").read_text())
    assert sorted(path.name for path in out.glob("[!.]*")) == result["files"]
    assert {"report.html", "shapes.json", "deviations.csv", "trunk.toml", "boxes-rest.png"} <= set(result["files"])
    shapes = load_shapes(out / "shapes.json")
    assert shapes.kind == ("rest", *["bend-dorsal"] * 4)
    rows = list(csv.DictReader((out / "deviations.csv").open()))
    assert len(rows) == 5 * 4
    bend = np.array([float(row["distance_m"]) for row in rows if row["run"] == "bend"])
    rmse = np.sqrt((bend.reshape(4, 4) ** 2).mean(axis=1))
    np.testing.assert_allclose(rmse, result["runs"]["bend"]["rmse_per_shape_m"], atol=1e-6)
    page = Page()
    page.feed((out / "report.html").read_text())
    assert page.pictures == 4
    assert not page.tags & {"script", "link", "iframe"}
    for told in ("10.41", "32.14", "5.48", "10.57", "10.45", "19.86", "alignment shape", "not a measurement"):
        assert told in page.text.lower()
    assert all((out / name).read_bytes()[:4] == b"\x89PNG" for name in result["files"] if name.endswith(".png"))


def test_statics_is_another_model(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    argv = [*validate(folder)[:2], *validate(folder)[4:], "--model", "statics", "--friction", "0", "--json"]
    assert cli.main(argv) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["model"], told["friction"]) == ("statics", 0.0)
    assert told["runs"]["bend"]["mean_rmse_m"] > 6e-3


def test_a_plan_is_printed_and_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["validate", "--plan", "--out", str(tmp_path / "plan")]) == 0
    text, told = capsys.readouterr()
    assert f"plan.md, protocol.toml, schedule.csv, trunk.toml written to {tmp_path / 'plan'}" in told
    assert "make 100 mm come out as 100.01." in text
    assert "takes 129.86 mm of cable 1" in text
    assert "## bend-dorsal: bend-dorsal, tilt 0 deg" in text
    assert (tmp_path / "plan" / "plan.md").read_text().rstrip("\n") == text.rstrip("\n")
    trunk = tmp_path / "plan" / "trunk.toml"
    assert load_protocol(tmp_path / "plan" / "protocol.toml") == replace(load_protocol("paper"), design=str(trunk))
    assert load_design(trunk) == PAPER
    assert cli.main(["validate", "--plan", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert np.shape(told["runs"]["bend-dorsal"]["cable_m"]) == (27, 3)
    assert told["runs"]["rest-090"]["cable_m"] == [None]
    rows = list(csv.DictReader((tmp_path / "plan" / "schedule.csv").open()))
    table = [float(row["cable_2_m"]) for row in rows if row["run"] == "bend-dorsal"]
    np.testing.assert_allclose(table, np.array(told["runs"]["bend-dorsal"]["cable_m"])[:, 1], atol=6e-7)


@pytest.mark.parametrize("key", ["", 'design = "sub/mine.toml"\n', "\ufeff 'design'='sub/mine.toml' # ours\r\n"])
@pytest.mark.parametrize("given", [None, "other"])
def test_a_plans_protocol_has_the_design_beside_it(
    key: str, given: str | None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mine = replace(PAPER, name="mine")
    write_design(mine, tmp_path / "sub" / "mine.toml")
    other = write_design(replace(PAPER, name="other"), tmp_path / "other.toml")
    (tmp_path / "a.toml").write_text(key + PROTOCOL.lstrip(), encoding="utf-8")
    argv = ["validate", "--plan", "--protocol", str(tmp_path / "a.toml"), "--out", str(tmp_path / "plan")]
    assert cli.main([*argv, *([] if given is None else ["--design", str(other)])]) == 0
    copy = load_protocol(tmp_path / "plan" / "protocol.toml")
    assert load_design(copy.design) == (load_design(other) if given else mine if key else PAPER)
    assert copy.runs == load_protocol(tmp_path / "a.toml").runs
    assert Path(copy.design).parent == tmp_path / "plan"


BAD = {
    "nothing": ([], "no take given"),
    "a plan and a take": (["--plan", "a.csv"], "takes given with --plan"),
    "no such run": (["kick=a.csv"], "'kick=a.csv' belongs to no run; allowed: RUN=FILE, or a file"),
    "no file's name": (["bend="], "belongs to no run"),
    "a file of no run": (["take.csv"], "belongs to no run"),
    "no file": (["bend=missing.csv"], "'missing.csv': No such file"),
    "a folder": (["bend=."], "this is a folder"),
    "another protocol": (
        ["bend=a.csv", "--protocol", "missing.toml"],
        "'missing.toml': No such file or directory; allowed: paper, or a protocol in TOML",
    ),
    "a plan of no protocol": (["--plan", "--protocol", "none"], "allowed: paper, or a protocol in TOML"),
    "axes": (["bend=a.csv", "--axes", "up"], "axes are 'up'"),
    "an alignment": (["bend=a.csv", "--alignment", "tip"], "alignment is tip"),
    "friction": (["bend=a.csv", "--friction", "0.1"], "reference has none"),
    "too much friction": (["bend=a.csv", "--model", "statics", "--friction", "2"], "below 2"),
    "friction of nan": (["bend=a.csv", "--model", "statics", "--friction", "nan"], "a finite number"),
    "a model": (["bend=a.csv", "--model", "magic"], "magic"),
    "a design": (["bend=a.csv", "--design", "elephant"], "elephant"),
    "one twice": (["bend=a.csv", "bend=a.csv"], "given twice"),
    "one twice, spelled differently": (["bend=a.csv", "bend=./a.csv"], "'./a.csv' is given twice"),
    "a section 0": (["bend=a.csv", "--alignment", "run:0-5"], "'run:0-5'; allowed: base, run or shape; the last two"),
    "a section beyond the last": (
        ["bend=a.csv", "--alignment", "run:99"],
        "'run:99', with section 99; allowed: sections 1 to 18, as the design",
    ),
    "sections backwards": (["bend=a.csv", "--alignment", "run:5-1"], "the lower end of a range first"),
}


@pytest.mark.parametrize("bad", BAD)
def test_bad_input_is_one_line(
    bad: str, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    more, told = BAD[bad]
    protocol = [] if "--protocol" in more or "--plan" in more else ["--protocol", str(folder / "protocol.toml")]
    assert told in refuse(["validate", *more, *protocol, "--out", "out"], capsys)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_made_is_refused_before_the_work(capsys: pytest.CaptureFixture[str]) -> None:
    assert "--out: '/proc/x' cannot be written: " in refuse(
        ["validate", "bend-dorsal=missing.csv", "--out", "/proc/x"], capsys
    )


def test_sections_that_the_design_does_not_have_are_named(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told = refuse([*validate(folder), "--alignment", "run:1-99"], capsys)
    assert "--alignment is 'run:1-99', with section 99; allowed: sections 1 to 18, as the design has" in told


def test_a_broken_recording_leaves_the_last_report(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, bad = tmp_path / "out", tmp_path / "bend_1.csv"
    assert cli.main([*validate(folder), "--out", str(out)]) == 0
    capsys.readouterr()
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    bad.write_bytes((folder / "bend_1.csv").read_bytes().replace(b"Quaternion", b"XYZ").replace(b",W,", b",,"))
    argv = ["validate", str(bad), "--protocol", str(folder / "protocol.toml"), "--out", str(out)]
    assert "export with Rotation: Quaternion" in refuse(argv, capsys)
    assert {path: path.read_bytes() for path in out.rglob("*") if path.is_file()} == before
    assert cli.main([*argv[:-2], "--rotations", "ignore", "--alignment", "run", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["runs"]["bend"]["mean_rmse_m"] < 5e-4


def test_shapes_that_do_not_fit_are_told_with_times(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    argv = ["validate", f"bend={folder / 'rest-045_1.csv'}", "--protocol", str(folder / "protocol.toml")]
    told = refuse(argv, capsys)
    assert "1 static shapes found (0.0-0.8 s); allowed: 4, as run 'bend' has" in told


def test_a_chosen_alignment_is_compared_with_the_plain_ones(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*validate(folder), "--alignment", "run:2,5,8", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert list(told["mean_rmse_by_alignment_m"]) == ["base", "run", "shape", "run:2,5,8"]
    chosen = told["mean_rmse_by_alignment_m"]["run:2,5,8"]
    assert chosen["bend"] == pytest.approx(told["runs"]["bend"]["mean_rmse_m"])


@pytest.mark.slow
def test_a_path_that_is_no_utf_8_is_written(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    there = Path(shutil.copytree(folder, tmp_path / "a\udcff"))
    assert cli.main([*validate(there), "--out", str(tmp_path / "out")]) == 0
    assert "a\\udcff" in (tmp_path / "out" / "report.html").read_text()
    assert "files in" in capsys.readouterr().out


def test_closed_standard_error_loses_no_result(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stderr", None)
    assert cli.main([*validate(folder), "--json"]) == 0
    assert "runs" in json.loads(capsys.readouterr().out)
