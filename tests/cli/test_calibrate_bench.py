"""``spiraltrunk calibrate --bench``: records of single joints in, laws with intervals out; bad records are one line."""

import json
import math

import numpy as np
import pytest

from spiraltrunk.cli import main

ARM, STIFFNESS, AT, FACES = 0.05, 0.3, math.radians(24.0), 2.0
HEAD = "joint,lever_arm_m,mass_g,angle_deg\n"


def _write_loads(path, joints=(1, 4)):
    draw, text = np.random.default_rng(3), HEAD
    for joint in joints:
        for degrees in (0, 5, 10, 15, 20, 22, 24, 26, 28, 30):
            bend = math.radians(degrees)
            moment = STIFFNESS * bend + FACES * max(0.0, bend - AT) + 5e-4 * draw.standard_normal() * (degrees > 0)
            text += f"{joint},{ARM},{1e3 * moment / 9.81 / ARM},{degrees}\n"
    path.write_text(text)
    return str(path)


def _write_ring(path, hertz=36.3, ratio=0.13):
    time, omega = np.arange(0, 0.4, 1 / 800), 2 * math.pi * hertz
    decay = np.exp(-ratio / math.sqrt(1 - ratio**2) * omega * time)
    signal = 20 * decay * np.cos(omega * time + 0.4) + 0.2 * np.random.default_rng(1).standard_normal(time.size)
    path.write_text("time_s,acceleration\n" + "".join(f"{t},{a}\n" for t, a in zip(time, signal, strict=True)))
    return str(path)


def test_joints_get_their_laws_with_intervals(tmp_path, capsys):
    loads, ring, out = _write_loads(tmp_path / "loads.csv"), _write_ring(tmp_path / "ring.csv"), tmp_path / "out"
    assert main(["calibrate", "--bench", loads, "--ring-down", f"4={ring}", "--inertia-kg-m2", "4=1.58e-5", "--json",
                 "--out", str(out)]) == 0  # fmt: skip
    result = json.loads(capsys.readouterr().out)
    assert result == json.loads((out / "result.json").read_text())
    assert sorted(result["files"]) == sorted(path.name for path in out.glob("[!.]*")) == ["bench.png", "result.json"]
    assert [row["joint"] for row in result["static"]] == [1, 4]
    for row in result["static"]:
        parts = (("stiffness_nm_per_rad", STIFFNESS), ("faces_nm_per_rad", FACES), ("faces_from_deg", 24.0))
        for name, truth in parts:
            assert row[name]["low_95"] < row[name]["value"] < row[name]["high_95"]
            assert row[name]["value"] == pytest.approx(truth, rel=0.1)
    (swung,) = result["ring_down"]
    natural = 2 * math.pi * 36.3 / math.sqrt(1 - 0.13**2)
    assert swung["stiffness_nm_per_rad"]["value"] == pytest.approx(1.58e-5 * natural**2, rel=0.02)
    damping = swung["damping_nms_per_rad"]
    assert damping["low_95"] < 2 * 0.13 * natural * 1.58e-5 < damping["high_95"]


def test_the_inertias_own_doubt_is_in_the_intervals(tmp_path, capsys):
    ring, widths = _write_ring(tmp_path / "ring.csv"), []
    for percent in ("0", "20"):
        swung = ["--ring-down", f"2={ring}", "--inertia-kg-m2", "2=1e-5", "--inertia-sd-percent", percent]
        assert main(["calibrate", *swung, "--json"]) == 0
        interval = json.loads(capsys.readouterr().out)["ring_down"][0]["stiffness_nm_per_rad"]
        widths.append((interval["high_95"] - interval["low_95"]) / interval["value"])
    assert widths[0] < 0.05
    assert widths[1] == pytest.approx(2 * 1.97 * 0.2, rel=0.05)


def test_without_json_there_are_tables(tmp_path, capsys):
    assert main(["calibrate", "--bench", _write_loads(tmp_path / "loads.csv", (7,))]) == 0
    said = capsys.readouterr().out
    assert "Static loads" in said
    assert "Ring" not in said
    assert said.splitlines()[-1].split()[0] == "7"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [(["--bench", "none.csv"], "none.csv"), (["--bench", "."], "folder"), (["--bench", "wrong.csv"], "columns"),
     (["--bench", "few.csv"], "joint 2: 2 readings"),
     (["--bench", "idle.csv"], "joint 1: 0 readings"), (["--bench", "lever.csv"], "joint 1: 0 readings"),
     (["--ring-down", "1=ring.csv"], "no inertia"),
     (["--ring-down", "ring.csv"], "JOINT=FILE"), (["--ring-down", "0=ring.csv"], "JOINT=FILE"),
     (["--ring-down", "1=flat.csv", "--inertia-kg-m2", "1=1e-5"], "joint 1: "),
     (["--ring-down", "1=ring.csv", "--inertia-kg-m2", "1=nan"], "above 0"),
     (["--ring-down", "1=ring.csv", "--inertia-kg-m2", "1=0"], "above 0"),
     (["--ring-down", "1=ring.csv", "--inertia-kg-m2", "1=-2", "--inertia-sd-percent", "-5"], "'1=-2'; allowed: above"),
     (["--ring-down", "1=ring.csv", "--inertia-kg-m2", "1=2", "--inertia-sd-percent", "-5"], "is -5; allowed: 0 or"),
     (["--ring-down", "99=ring.csv", "--inertia-kg-m2", "99=1"], "joint 99; allowed: 1 to 17, as the design"),
     (["--bench", "far.csv"], "joint 18; allowed: 1 to 17, as the design"),
     (["--bench", "nan.csv"], "angle_deg is 'nan'; allowed: 0 to 180"),
     (["--ring-down", "1=ring.csv", "--inertia-kg-m2", "1=1", "--inertia-kg-m2", "1=2"], "twice"),
     (["--ring-down", "1=ring.csv", "--inertia-kg-m2", "1=1", "--inertia-kg-m2", "2=2"], "joint 2 without"),
     (["--bench", "few.csv", "--inertia-kg-m2", "1=1"], "without --ring-down"),
     (["--bench", "few.csv", "--inertia-sd-percent", "3"], "without --ring-down"),
     (["--bench", "few.csv", "--hold-out", "rest-000=a.csv"], "without takes"),
     (["--bench", "few.csv", "--mass-g", "200"], "without takes"),
     (["--bench", "few.csv", "--virtual", "x"], "with --virtual"), (["--bench", ""], "not empty"),
     (["--bench", "good.csv", "--out", "few.csv"], "is a file")],
)  # fmt: skip
def test_bad_records_and_options_are_one_line(arguments, words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "wrong.csv").write_text("a,b\n1,2\n")
    (tmp_path / "few.csv").write_text(HEAD + "2,0.05,10,1\n2,0.05,20,2\n")
    (tmp_path / "idle.csv").write_text(HEAD + "1,0.05,0,4\n" * 4)
    (tmp_path / "lever.csv").write_text(HEAD + "1,0,10,4\n" * 4)
    (tmp_path / "nan.csv").write_text(HEAD + "1,0.05,10,nan\n")
    _write_loads(tmp_path / "good.csv")
    _write_loads(tmp_path / "far.csv", (18,))
    _write_ring(tmp_path / "ring.csv")
    (tmp_path / "flat.csv").write_text("time_s,acceleration\n" + "".join(f"{i},0\n" for i in range(40)))
    before = sorted(tmp_path.iterdir())
    assert main(["calibrate", *arguments]) == 2
    said = capsys.readouterr()
    assert words in said.err
    assert said.err.count("\n") == 1
    assert said.out == ""
    assert sorted(tmp_path.iterdir()) == before
