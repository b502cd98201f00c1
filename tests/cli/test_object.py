"""``spiraltrunk object``: figures, table, plot and refusals."""

import json

import numpy as np
import pytest
import trimesh

from spiraltrunk import cli
from spiraltrunk.sim.objects.catalogue import CATALOGUE


def run(capsys, *argv):
    assert cli.main(["object", *argv]) == 0, capsys.readouterr().err
    return capsys.readouterr()


def test_the_figures_of_a_box_that_stands(capsys):
    told = json.loads(run(capsys, "box:x_mm=62,y_mm=62,z_mm=190,mass_g=300", "--json").out)
    assert told["extents_m"] == pytest.approx([0.062, 0.062, 0.19])
    assert told["volume_m3"] == pytest.approx(0.062**2 * 0.19)
    assert told["center_of_mass_m"] == pytest.approx([0, 0, 0.095], abs=1e-9)
    assert told["topple_deg"] == pytest.approx(np.degrees(np.arctan(62 / 190)), abs=0.5)
    assert (told["grip_width_m"], told["grip_height_m"]) == pytest.approx((0.062, 0.095))
    assert told["warnings"] == []
    profile = told["profile"]
    assert set(profile) == {"height_m", "girth_m", "width_least_m", "width_most_m"}
    assert profile["height_m"][-1] == pytest.approx(0.19)
    assert profile["girth_m"] == pytest.approx([4 * 0.062] * len(profile["height_m"]))
    assert sum(pose["probability"] for pose in told["stable_poses"]) > 0.98
    assert set(told["stable_poses"][0]) >= {"probability", "height_m", "topple_deg", "rotation_wxyz"}
    resting = told["stable_poses"][told["pose"]]
    assert resting["height_m"] == pytest.approx(0.19)


def test_without_an_object_the_catalogue_is_listed(capsys):
    listed = {each["name"]: each["spec"] for each in json.loads(run(capsys, "--json").out)["objects"]}
    assert listed == CATALOGUE
    lines = run(capsys).out.splitlines()
    assert all(any(line.split() == [name, spec] for line in lines) for name, spec in CATALOGUE.items())


@pytest.mark.parametrize(("option", "value"), [("--plot", "a.png"), ("--design", "paper")])
def test_an_option_about_an_object_without_one_is_refused(tmp_path, monkeypatch, capsys, option, value):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["object", option, value]) == 2
    assert f"SPEC is missing; allowed: an object, which {option} is about" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "name",
    [
        "cylinder-60",
        "ball-60",
        pytest.param("ring-90", marks=pytest.mark.slow),
        "cone-35",
        "bottle-70",
        "everyday:seed=7",
    ],
)
def test_the_object_rests_in_one_of_its_stable_poses(capsys, name):
    told = json.loads(run(capsys, name, "--json").out)
    pose = told["stable_poses"][told["pose"]]
    assert pose["height_m"] == pytest.approx(told["profile"]["height_m"][-1], rel=0.01)
    assert pose["topple_deg"] == pytest.approx(told["topple_deg"], abs=1.0)


def test_warnings_of_a_file_are_told_on_standard_error_and_in_the_figures(capsys, tmp_path):
    mesh = trimesh.creation.box(extents=(40, 60, 90))
    mesh.update_faces(np.arange(12) != 3)
    mesh.export(tmp_path / "cut.obj")
    said = run(capsys, f"obj:path={tmp_path}/cut.obj,mass_g=100", "--json")
    told = json.loads(said.out)
    assert len(told["warnings"]) == 2
    assert "the unit is guessed from the size: mm" in said.err
    assert "open or cut at 3 edges: its convex hull is taken, 0.0 % larger" in said.err


def test_the_table_tells_what_a_trunk_takes(capsys):
    said = run(capsys, "cylinder:diameter_mm=60,height_mm=160,mass_g=200", "--design", "paper").out
    trunk = ("paper goes round     33 to 268 mm", "paper holds          28 to 153 mm", "fingers of paper")
    for text in ("60 x 60 x 160 mm", "200 g", "stable pose 0", *trunk, "girth [mm]"):
        assert text in said


def test_the_plot_is_a_picture_and_never_replaces_another_file(capsys, tmp_path):
    for form in ("png", "svg"):
        file = tmp_path / f"bottle.{form}"
        run(capsys, "bottle-70", "--plot", str(file))
        assert file.stat().st_size > 10_000
    other = tmp_path / "mine.png"
    other.write_bytes(b"mine")
    assert cli.main(["object", "bottle-70", "--plot", str(other)]) == 2
    assert other.read_bytes() == b"mine"


@pytest.mark.parametrize(
    ("argv", "match"),
    [(["teapot"], "unknown object"), (["bottle-70", "--plot", "a.jpg"], "ends in .png, .svg, .pdf"),
     (["bottle-70", "--design", "none"], "error"),
     (["stl:path=none.stl,mass_g=3"], "a file that exists")],
)  # fmt: skip
def test_bad_input_is_one_line(capsys, argv, match):
    assert cli.main(["object", *argv]) == 2
    said = capsys.readouterr()
    assert match in said.err
    assert said.err.count("\n") == 1
    assert said.out == ""


def test_a_trunk_too_short_to_wrap_goes_round_nothing(capsys, tmp_path):
    path = tmp_path / "two.toml"
    path.write_text('name = "two"\n[spiral]\na_mm = 26\nb = 0.16\nn_section = 2\n[gripper]\n')
    text = run(capsys, "cylinder-60", "--design", str(path)).out
    assert len([line for line in text.splitlines() if "nothing: the trunk is too short to wrap" in line]) == 2
    told = json.loads(run(capsys, "cylinder-60", "--design", str(path), "--json").out)["design"]
    assert told["wrap_widths_m"] is told["held_widths_m"] is told["payload_kg"] is told["held_mass_kg"] is None


def test_large_numbers_are_written_out(capsys):
    assert cli.main(["object", "box:x_mm=60,y_mm=60,z_mm=60,mass_g=12345"]) == 0
    text = capsys.readouterr().out
    assert "12345 g" in text
    assert "57153 kg/m3" in text


def test_a_comma_in_a_path_is_told(capsys):
    assert cli.main(["object", "stl:path=a,b.stl,mass_g=250"]) == 2
    assert capsys.readouterr().err.endswith("; a path has no comma\n")
