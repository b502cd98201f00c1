"""Faults of a design that an export would refuse, and an export as one file."""

import zipfile
from dataclasses import replace
from io import BytesIO

import pytest

from spiraltrunk.design import presets
from spiraltrunk.design.edit import change_field, change_rules
from spiraltrunk.design.toml import parse_design
from spiraltrunk.errors import DesignError
from spiraltrunk.workflows.export.archive import export_archive
from spiraltrunk.workflows.export.export import Request, check_robot
from spiraltrunk.workflows.export.faults import find_faults


def test_preset_has_no_fault():
    assert find_faults(presets.PAPER) == ()


def test_each_reason_is_told():
    wide = change_field(change_field(presets.PAPER, "k", 0.8), "cable.tension_max", 500.0)
    faults = find_faults(wide)
    assert any("overlap of sections" in fault for fault in faults)
    assert any("part drum: tension" in fault for fault in faults)
    assert len(faults) == len(set(faults))
    housed = find_faults(change_field(presets.PAPER, "housing.radius", 0.05))
    assert housed == (
        "part housing: housing.radius_mm is 50.0 mm; allowed: at least 74.69 mm: 3 motors of 66.7 mm side by side",
    )


def test_an_export_refuses_for_a_reason_that_was_found():
    pytest.importorskip("build123d", reason="solids need the extra cad")
    thin = change_rules(presets.PAPER, arm_radius=0.02)
    with pytest.raises(DesignError) as refusal:
        check_robot(thin, Request(parts=("gripper",), formats=("stl",)))
    assert str(refusal.value) in find_faults(thin)


@pytest.mark.slow
def test_archive_holds_what_an_export_writes(tmp_path):
    pytest.importorskip("build123d", reason="solids need the extra cad")
    told = []
    request = Request(parts=("drums", "horn"), formats=("stl",))
    content = export_archive(
        replace(presets.PAPER, name="../up"), request, folder=tmp_path, progress=lambda *step: told.append(step[0])
    )
    with zipfile.ZipFile(BytesIO(content)) as archive:
        names = archive.namelist()
        assert archive.testzip() is None
        assert parse_design(archive.read("trunk.toml"), "trunk.toml") == replace(presets.PAPER, name="../up")
    found = {str(path.relative_to(tmp_path)) for path in tmp_path.glob("[!.]*/**/*") if path.is_file()}
    found |= {path.name for path in tmp_path.glob("[!.]*") if path.is_file()}
    assert set(names) == found
    assert {"parts/drum.stl", "parts/horn.stl", "bom.md", "guide.md", "result.json"} <= set(names)
    assert told[-1] == "archive"
    assert not any(name.startswith("/") or ".." in name for name in names)
