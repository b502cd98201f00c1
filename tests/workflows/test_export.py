"""The maker's folder: all of it or none, nothing outside it, the same for the same seed."""

from __future__ import annotations

import json
import re
import time
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.output import make_part
from spiraltrunk.cad.output.catalogue import GROUPS, build_parts
from spiraltrunk.design import design_from_rules, load_design, presets
from spiraltrunk.design.materials import RIGID, SILICONE, TPU
from spiraltrunk.errors import DesignError, OutputError, PartError, UnknownName
from spiraltrunk.workflows.export import export
from spiraltrunk.workflows.export.export import Request, check_robot, export_robot

pytest.importorskip("build123d", reason="solids need the extra cad")

QUICK = ("drums", "horn")

DENSITY = {material.name: material.density for material in (TPU, SILICONE, *RIGID.values())}
"""Density of each material [kg/m^3]."""

SOME = ("trunk", "shells", "housing", "drums", "horn", "adapter")
"""What is worth a picture but the gripper, which takes as long as half of it; the rest is made in the slow tests."""


@pytest.fixture(scope="module")
def short():
    design = design_from_rules(b=0.16, arm_radius=0.026, turns=0.75, name='../<short> & "away"')
    return replace(design, gripper=presets.PAPER.gripper)


@pytest.fixture(scope="module", params=[SOME, pytest.param((*SOME, "gripper"), marks=pytest.mark.slow)], ids=len)
def exported(request, short, tmp_path_factory):
    """Most of the short robot in all formats, by one process."""
    folder = tmp_path_factory.mktemp("made") / "new" / "robot"
    told = []
    result = export_robot(
        short, folder, Request(parts=request.param), progress=lambda what, done, total: told.append(what)
    )
    return folder, result, told


def test_everything_is_there_and_listed(exported, short):
    folder, result, told = exported
    found = {str(path.relative_to(folder)) for path in folder.glob("[!.]*/**/*") if path.is_file()}
    found |= {path.name for path in folder.glob("[!.]*") if path.is_file()}
    assert found == set(result["files"])
    assert result == {**json.loads((folder / "result.json").read_text()), "removed": []}
    for name in result["checks"]:
        assert {f"parts/{name}.{ending}" for ending in ("step", "stl", "3mf", "json")} <= found
        assert name in told
    assert {"models/trunk.xml", "models/hybrid.urdf", "bom.md", "bom.csv", "guide.md", "trunk.toml"} <= found
    assert {"pictures/parts.png", "pictures/exploded.png", "pictures/exploded.svg"} <= found
    assert ("pictures/top_view.svg" in found) == ("housing" in SOME)
    for name in re.findall(r"\]\((pictures/[^)]*)\)", (folder / "guide.md").read_text()):
        assert name in found
    assert load_design(folder / "trunk.toml") == short
    hidden = [path for path in folder.parent.parent.rglob("*") if ".spiraltrunk" in path.parts]
    assert [path.name for path in hidden if path.is_file()] == ["manifest.json"]


def test_every_check_holds(exported, short):
    _, result, _ = exported
    assert result["mass_kg"] == short.total_mass
    for check in result["checks"].values():
        assert check["holds"]
        assert check["watertight"]
        assert check["volume_m3"] == pytest.approx(check["expected_volume_m3"], rel=0.01)
    for name in ("section_length", "gap_angle", "cable_stroke", "mass", "center", "section_center", "inertia", "holes"):
        assert result["agreement"][name]["holds"], name


def test_a_steps_volume_is_the_parts(exported):
    import build123d

    folder, result, _ = exported
    for name in {"trunk_1", "gripper", "shell_02", "housing"} & result["checks"].keys():
        volume = 1e-9 * build123d.import_step(folder / "parts" / f"{name}.step").volume
        assert volume == pytest.approx(result["checks"][name]["volume_m3"], rel=1e-6)


def test_what_stands_beside_a_part_says_what_it_is(exported):
    folder, result, _ = exported
    about = json.loads((folder / "parts" / "drum.json").read_text())
    assert about["checks"] == result["checks"]["drum"]
    assert about["count"] == 3
    assert about["material"] == "PETG"
    assert about["print"]["layer_mm"] == 0.2
    assert about["print"]["infill"] == 1.0
    assert about["design"] == '../<short> & "away"'
    assert about["spiraltrunk"] == result["spiraltrunk"]


def test_the_bill_counts_and_weighs(exported):
    import csv

    folder, result, _ = exported
    rows = list(csv.DictReader((folder / "bom.csv").read_text().splitlines()))
    by_item = {row["item"]: row for row in rows}
    assert by_item["drum"]["count"] == "3"
    for name, mass in result["print_mass_kg"].items():
        assert float(by_item[name]["mass_each_g"]) == pytest.approx(1e3 * mass, abs=6e-3)
        solid = 1e3 * DENSITY[by_item[name]["material"]] * result["checks"][name]["volume_m3"]
        assert 0 < 1e3 * mass <= solid * 1.001
    assert by_item["motor RoboMaster GM6020"]["count"] == "3"
    assert {"kind", "item", "count", "size", "material", "place", "note"} <= set(rows[0])


def test_the_picture_is_a_picture(exported):
    folder, _, _ = exported
    root = ET.parse(folder / "pictures" / "exploded.svg").getroot()
    assert root.tag.endswith("svg")
    from PIL import Image

    picture = np.asarray(Image.open(folder / "pictures" / "exploded.png").convert("L"))
    assert picture.min() < 60
    assert 0.05 < (picture < 240).mean() < 0.6


@pytest.mark.slow
def test_the_same_seed_makes_the_same_meshes(tmp_path, short, monkeypatch):
    """Of one shell, and without pictures, which take as long."""
    monkeypatch.setattr(export, "write_pictures", lambda *_, **__: None)
    monkeypatch.setattr(
        export, "build_parts", lambda *given: tuple(part for part in build_parts(*given) if part.name == "shell_03")
    )
    request = Request(parts=("shells",), formats=("stl", "3mf"))
    shells = ("shell_03.stl", "shell_03.3mf")

    def make(folder, seed):
        export_robot(short, folder, replace(request, options=MakeOptions(seed=seed)))
        return [(folder / "parts" / name).read_bytes() for name in shells]

    first = make(tmp_path / "a", 5)
    assert make(tmp_path / "b", 5) == first
    assert make(tmp_path / "c", 6) != first


@pytest.mark.slow
def test_a_part_that_fails_leaves_nothing(tmp_path):
    """The tip of this trunk is thinner than two lines; what was in the folder stays as it was."""
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "mine.txt").write_text("kept")
    request = Request(parts=("trunk",), formats=("stl", "mjcf"))
    with pytest.raises(
        PartError, match=r"part trunk_1: joint 21 and section 22, at z = .* too thin; .*finer --nozzle-mm"
    ):
        export_robot(presets.get("spirob-15"), folder, request)
    assert [path.name for path in folder.iterdir()] == ["mine.txt"]
    small = Request(parts=("adapter",), formats=("stl",), options=MakeOptions(bed=(80.0, 80.0, 80.0)))
    with pytest.raises(PartError, match=r"part adapter: it measures .* the bed"):
        export_robot(presets.get("spirob-15"), tmp_path / "fresh" / "deep", small)
    assert not (tmp_path / "fresh").exists()


def test_an_earlier_export_goes_and_strangers_stay(tmp_path, short):
    folder = tmp_path / "out"
    export_robot(short, folder, Request(parts=("horn",), formats=("stl", "step")))
    (folder / "parts" / "mine.stl").write_text("kept")
    (folder / "parts" / "horn.step").write_text("with my notes")
    result = export_robot(short, folder, Request(parts=("horn",), formats=("3mf",)))
    assert result["removed"] == ["parts/horn.stl"]
    parts = sorted(path.name for path in (folder / "parts").iterdir())
    assert parts == ["horn.3mf", "horn.json", "horn.step", "mine.stl"]
    assert (folder / "parts" / "horn.step").read_text() == "with my notes"


@pytest.mark.parametrize("name", ["trunk.toml", "bom.md", "parts/horn.stl", "pictures/parts.png"])
def test_what_another_wrote_is_not_replaced(name, tmp_path, short, monkeypatch):
    """It is told before a part is made."""
    monkeypatch.setattr(make_part, "make_part", None)
    path = tmp_path / "out" / name
    path.parent.mkdir(parents=True)
    path.write_text("mine")
    with pytest.raises(OutputError, match=rf"{name}' is not replaced: no run of 'export' wrote it; allowed: another"):
        export_robot(short, tmp_path / "out", Request(parts=("horn",), formats=("stl",)))
    assert [path.read_text() for path in tmp_path.rglob("*") if path.is_file()] == ["mine"]


def test_a_design_that_was_changed_since_is_not_replaced(tmp_path, short):
    """The guide asks to put weighed masses into the exported file; with its comments it is not made again."""
    export_robot(short, tmp_path / "out", Request(formats=("urdf",)))
    changed = (tmp_path / "out" / "trunk.toml").read_text().replace("b = 0.16", "b = 0.161  # Measured.")
    (tmp_path / "out" / "trunk.toml").write_text(changed)
    for design in (short, load_design(tmp_path / "out" / "trunk.toml")):
        with pytest.raises(OutputError, match=r"trunk\.toml' is not replaced: it was changed since 'export' wrote it"):
            export_robot(design, tmp_path / "out", Request(formats=("mjcf",)))
    assert (tmp_path / "out" / "trunk.toml").read_text() == changed


def test_what_goes_is_told(tmp_path, short):
    export_robot(short, tmp_path / "out", Request(formats=("urdf",)))
    result = export_robot(short, tmp_path / "out", Request(parts=("horn",), formats=("stl",)))
    assert "models/hybrid.urdf" in result["removed"]
    assert not (tmp_path / "out" / "models").exists()


@pytest.mark.slow
def test_stopping_two_processes_ends_them_at_once(tmp_path, short):
    """A piece of the trunk takes many seconds; who stops does not wait for it."""

    def stop(what, done, total):
        raise KeyboardInterrupt

    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        export_robot(short, tmp_path / "out", Request(parts=("trunk", "gripper"), workers=2), progress=stop)
    assert list(tmp_path.iterdir()) == []
    assert not any(task.read_text() for task in Path("/proc/self/task").glob("*/children"))
    assert time.monotonic() - began < 60


@pytest.mark.slow
def test_the_default_design_has_a_gripper(tmp_path):
    """Its seams once touched in a point, and the kernel left a face of no area there."""
    result = check_robot(design_from_rules(name="trunk"), Request(parts=("gripper",), formats=("stl",)))
    assert result["checks"]["gripper"]["holds"]


def test_stopping_leaves_nothing(tmp_path, short):
    def stop(what, done, total):
        if what == "horn":
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        export_robot(short, tmp_path / "out", Request(parts=QUICK, formats=("stl",)), progress=stop)
    assert list(tmp_path.iterdir()) == []


def test_models_alone_need_no_solids(tmp_path, short, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "build123d", None)
    result = export_robot(short, tmp_path, Request(formats=("urdf",)))
    assert result["checks"] == {}
    assert "models/hybrid.urdf" in result["files"]


def test_a_check_of_models_alone_refuses_no_part():
    small = MakeOptions(bed=(99.0, 99.0, 99.0))
    with pytest.raises(DesignError, match="wide at section 1"):
        check_robot(presets.get("spirob-1m"), Request(options=small))
    assert check_robot(presets.get("spirob-1m"), Request(formats=("mjcf",), options=small))["checks"] == {}


def test_a_missing_kernel_is_named(tmp_path, short, monkeypatch):
    from spiraltrunk.errors import MissingPackage

    monkeypatch.setitem(__import__("sys").modules, "build123d", None)
    with pytest.raises(MissingPackage, match=r"pip install 'spiraltrunk\[cad\]'"):
        export_robot(short, tmp_path / "out", Request(formats=("stl",)))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["paper", "spirob-15", "spirob-1m"])
def test_every_part_of_a_preset_holds(name):
    """With the nozzle that the two SpiRobs' tips need."""
    options = MakeOptions(nozzle=0.4 if name == "paper" else 0.2)
    result = check_robot(presets.get(name), Request(options=options, workers=2))
    assert all(check["holds"] for check in result["checks"].values())
    assert {part.group for part in build_parts(presets.get(name), ["all"], options)} >= set(GROUPS) - {
        "gripper",
        "horn",
    }


@pytest.mark.slow
def test_the_designs_housing_weighs_what_its_print_is_estimated_to():
    """What of the housing's mass follows from the filament."""
    from spiraltrunk.design.mount import PRINTED_MASS

    groups = ("housing", "drums", "horn", "adapter")
    result = check_robot(presets.PAPER, Request(parts=groups, formats=("stl",)))
    count = {"drum": 3, "neck": 0}
    printed = sum(count.get(name, 1) * mass for name, mass in result["print_mass_kg"].items())
    assert printed == pytest.approx(PRINTED_MASS, rel=0.05)


@pytest.mark.slow
def test_two_processes_make_the_same(short):
    request = Request(parts=(*QUICK, "moulds", "markers"), formats=("stl",))
    assert check_robot(short, replace(request, workers=2)) == check_robot(short, request)


def test_unknown_names_are_refused():
    with pytest.raises(UnknownName, match="unknown format 'obj'; known: step, stl"):
        Request(formats=("obj",))
    with pytest.raises(UnknownName, match="unknown part 'nose'"):
        Request(parts=("nose",))
