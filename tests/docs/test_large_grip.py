"""The table of finger scales states the sizes that the code computes."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from spiraltrunk import cli
from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.housing.winder import find_arm
from spiraltrunk.design import load_design, presets
from spiraltrunk.design.gripper import STRAND_LEVER, GripperDesign

PAGE = (Path(__file__).parents[2] / "docs/howto/large_grip.md").read_text()
SCALES = (1.0, 1.5, 1.75, 2.0)


def compute_rows(scale):
    gripper = GripperDesign().enlarged(scale)
    design = replace(presets.PAPER, gripper=gripper)
    tip = gripper.tension_max * STRAND_LEVER * gripper.finger_width / gripper.finger_length
    return {
        "encloses [mm]": 1e3 * gripper.grasp_width,
        "finger length [mm]": 1e3 * gripper.finger_length,
        "largest tension of a cable group [N]": gripper.tension_max,
        "force of a straight finger's tip [N]": tip,
        "mass of the gripper [g]": 1e3 * gripper.mass,
        "torque of the servo [N m]": gripper.tension_max * find_arm(design, MakeOptions()) / 1e3,
    }


def test_the_table_of_scales_is_computed():
    lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in PAGE.splitlines() if line[:1] == "|"]
    table = {name: [float(cell) for cell in cells] for name, *cells in lines[2:] if name in compute_rows(1.0)}
    assert len(table) == 6
    for i, scale in enumerate(SCALES):
        for name, value in compute_rows(scale).items():
            assert table[name][i] == pytest.approx(value, rel=0.07 if value < 1 else 0.01), (name, scale)


def test_the_preset_has_the_scale_that_the_page_says():
    assert f"s = {presets.LARGE_GRIP:g}" in PAGE
    assert presets.get("paper-large-grip").gripper == GripperDesign().enlarged(presets.LARGE_GRIP)


def test_a_written_design_takes_the_scale_as_the_page_adds_it(tmp_path):
    shown = re.search(r"```toml\n(\[gripper\]\n.*?)```", PAGE, flags=re.S)
    assert shown
    file = tmp_path / "trunk.toml"
    assert cli.main(["design", "--out", str(file)]) == 0
    file.write_text(file.read_text().replace("[gripper]\n", shown.group(1)))
    gripper = load_design(file).gripper
    assert gripper is not None
    assert f"up to {1e3 * gripper.grasp_width:.0f} mm wide" in PAGE
