"""``spiraltrunk calibrate``: takes in, a design with its provenance out; what cannot be is one line and exit 2."""

import json
import math

import pytest

from spiraltrunk.cli import main
from spiraltrunk.design import load_design
from spiraltrunk.design.presets import PAPER
from spiraltrunk.mocap.protocol.protocol import Protocol, Run
from spiraltrunk.workflows.virtual_session.printed_trunk import draw_printed_trunk
from spiraltrunk.workflows.virtual_session.session import simulate_session, write_session

SHORT = Protocol(
    name="short",
    runs=(
        Run(name="rest-045", kind="rest", theta_0=math.pi / 4),
        Run(name="bend-dorsal", kind="bend-dorsal", steps=6, step=0.02),
    ),
)


@pytest.fixture(scope="module")
def takes(tmp_path_factory):
    folder = tmp_path_factory.mktemp("takes")
    write_session(PAPER, simulate_session(PAPER, draw_printed_trunk(PAPER, 2), SHORT, is_simulated=False), 2, folder)
    return folder


def test_takes_become_a_design_that_says_where_it_comes_from(takes, tmp_path, capsys):
    files = [str(takes / f"{run}_{i}.csv") for run in ("rest-045", "bend-dorsal") for i in (1, 2)]
    out, bench, true = (
        tmp_path / "out",
        tmp_path / "bench.csv",
        float(draw_printed_trunk(PAPER, 2).design.joint_stiffness[2]),
    )
    rows = "".join(f"3,0.05,{1e3 * true * math.radians(a) / 9.81 / 0.05},{a}\n" for a in range(0, 25, 4))
    bench.write_text("joint,lever_arm_m,mass_g,angle_deg\n" + rows)
    code = main(["calibrate", *files, "--protocol", str(takes / "protocol.toml"), "--mass-g", "190", "--json",
                 "--bench", str(bench), "--out", str(out)])  # fmt: skip
    said = capsys.readouterr()
    assert code == 0
    result = json.loads(said.out)
    assert sorted(result["files"]) == sorted(path.name for path in out.glob("[!.]*"))
    assert result == json.loads((out / "result.json").read_text())
    assert "not a measurement" in said.err
    assert any("frame numbers missing" in note for note in result["odd_in_recordings"])
    assert all(f"note: {note}" in said.err for note in result["odd_in_recordings"])
    assert "bench.png" in result["files"]
    joint = result["bench"]["static"][0]["stiffness_nm_per_rad"]["value"]
    assert joint == pytest.approx(true)
    # The bench is known before the takes, within a tenth.
    assert result["parameters"]["stiffness_03"]["before"] == pytest.approx(true, rel=0.1)
    assert result["parameters"]["stiffness_03"]["value"] == pytest.approx(true, rel=0.2)
    held = result["held_out"]["all"]
    assert held["shapes"] == 8
    assert held["calibrated_mean_rmse_m"] < 0.3 * held["reference_mean_rmse_m"]
    text = (out / "trunk.toml").read_text()
    assert "not a measurement" in text
    assert "never for these takes" in text
    assert "frame numbers" not in text
    design = load_design(out / "trunk.toml")
    assert design.cable.friction == pytest.approx(result["parameters"]["friction"]["value"])
    assert design.joint_stiffness[0] == pytest.approx(result["parameters"]["stiffness_01"]["value"])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [([], "no take given"), (["--virtual", "x", "take.csv"], "takes given with --virtual"),
     (["--virtual", "x", "--out", "y"], "--out given with --virtual"),
     (["--virtual", "x", "--mass-g", "200"], "without takes"),
     (["rest-000=a.csv", "--mass-sd-g", "1"], "--mass-g"),
     (["rest-000=a.csv", "--mass-g", "-5"], "--mass-g is -5.0; allowed: a finite number, above 0"),
     *((["rest-000=a.csv", "--mass-g", "200", "--mass-sd-g", given],
        f"--mass-sd-g is {float(given)}; allowed: a finite number, at least 0.002, below 1e+06")
       for given in ("0", "2e6", "1e-7", "-1")),
     ([".", "--mass-g", "200"], "'.' is a folder; allowed: RUN=FILE"),
     (["rest-000=a.csv", "--hold-out", "rest-000=a.csv"], "every take is held out"),
     (["rest-000=a.csv", "--seed", "3"], "--seed given without --virtual"),
     (["other.csv"], "belongs to no run"), (["rest-000=missing.csv", "--axes", "y-up"], "missing.csv"),
     (["rest-000=missing.csv", "--protocol", "none.toml"], "none.toml")],
)  # fmt: skip
def test_bad_arguments_are_one_line(arguments, words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["calibrate", *arguments]) == 2
    said = capsys.readouterr()
    assert words in said.err
    assert said.err.strip().splitlines()[-1].startswith("spiraltrunk: error:")
    assert said.out == ""
    assert list(tmp_path.iterdir()) == []


def test_what_is_fitted_does_not_judge_under_another_name(takes, tmp_path, capsys):
    first = takes / "rest-045_1.csv"
    copy = tmp_path / "copy.csv"
    copy.write_bytes(first.read_bytes())
    arguments = [str(first), "--hold-out", f"rest-045={copy}", "--protocol", str(takes / "protocol.toml")]
    assert main(["calibrate", *arguments]) == 2
    assert "the same file as" in capsys.readouterr().err


def test_of_all_takes_those_held_out_are_not_fitted(takes, capsys):
    """As anybody types it: every file, and one of them held out, be it under another path."""
    files = sorted(str(path) for path in takes.glob("rest-045_*.csv"))
    arguments = [*files, "--hold-out", f"{takes}/./rest-045_2.csv", "--protocol", str(takes / "protocol.toml")]
    assert main(["calibrate", *arguments, "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert [path.rsplit("/")[-1] for path in result["takes"]["fitted"]] == ["rest-045_1.csv"]
    assert [path.rsplit("/")[-1] for path in result["takes"]["held_out"]] == ["rest-045_2.csv"]
    assert result["held_out"]["all"]["shapes"] == 1
    (misfit,) = result["misfit_by_run"]
    assert misfit["take"] == "rest-045_1.csv"
    assert 0 < misfit["registered_rms_m"] <= misfit["rms_m"] < 5e-3
    assert not misfit["is_out_of_proportion"]
    # Both takes that the protocol asks for were given.
    assert not any("the protocol asks for" in note for note in result["odd_in_recordings"])
    assert main(["calibrate", files[0], "--protocol", str(takes / "protocol.toml"), "--json"]) == 0
    notes = json.loads(capsys.readouterr().out)["odd_in_recordings"]
    assert "takes of run 'rest-045': 1; the protocol asks for 2" in notes


def test_a_folder_that_cannot_be_written_is_told_before_the_fit(takes, capsys):
    protocol = str(takes / "protocol.toml")
    assert main(["calibrate", str(takes / "rest-045_1.csv"), "--protocol", protocol, "--out", "/proc/a/b"]) == 2
    said = capsys.readouterr().err
    assert "cannot be written" in said
    assert "reading" not in said


@pytest.mark.slow
@pytest.mark.timeout(1500)
@pytest.mark.parametrize("seed", [2000, 2003, 2005])
def test_more_recordings_do_not_make_a_calibration_worse(seed, tmp_path, capsys):
    """All first takes of a simulated session, through files; with the twist friction used to be told as 0.23 to 0.3."""
    assert main(["calibrate", "--virtual", str(tmp_path), "--seed", str(seed), "--json"]) == 0
    truth = json.loads(capsys.readouterr().out)
    first = sorted(str(path) for path in tmp_path.glob("*_1.csv"))
    held = ["--hold-out", str(tmp_path / "bend-dorsal_2.csv")]
    weighed = ["--mass-g", f"{truth['mass_g']:.6f}", "--protocol", str(tmp_path / "protocol.toml")]
    assert main(["calibrate", *first, *held, *weighed, "--json"]) == 0
    said = capsys.readouterr()
    result = json.loads(said.out)
    true = {
        "friction": truth["friction"],
        "give": 1e-3 * truth["give_mm_per_n"],
        "slack_1": 1e-3 * truth["slack_mm"][0],
    }
    for name, value in true.items():
        parameter = result["parameters"][name]
        assert parameter["low_95"] <= value <= parameter["high_95"], name
        assert parameter["is_told"] or name == "give", name
    assert abs(result["parameters"]["friction"]["value"] - truth["friction"]) < 0.01
    assert result["held_out"]["all"]["calibrated_mean_rmse_m"] < 0.5e-3
    assert [row["take"] for row in result["misfit_by_run"] if row["is_out_of_proportion"]] == ["twist_1.csv"]
    assert "twist_1.csv is misfitted" in said.err
