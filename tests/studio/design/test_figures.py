"""Figures, warnings, presets and files of the design's tab."""

from dataclasses import replace

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from spiraltrunk.design import MassDesign, format_design, graspable_range, presets
from spiraltrunk.design.edit import change_field, change_rules
from spiraltrunk.errors import DesignError, StudioError
from spiraltrunk.studio.design.figures import find_gap, format_figures, format_legend, format_warnings, list_figures
from spiraltrunk.studio.design.files import OWN, find_preset, name_file, read_upload, rename
from spiraltrunk.studio.design.make_options import PAGE_OPTIONS
from spiraltrunk.studio.design.parameters import space_cables
from spiraltrunk.studio.design.picture import CABLE
from spiraltrunk.studio.page.buttons import clean_name
from spiraltrunk.workflows.export.faults import find_faults


def test_figures_are_the_designs():
    shown = {name: value for name, value, _ in list_figures(presets.PAPER)}
    assert shown["Graspable"] == "32.6 to 268 mm"
    assert shown["Payload"] == "4.89 kg"
    assert shown["Sections"].startswith("18")
    bare = replace(presets.PAPER, gripper=None)
    assert "none" in format_figures(bare)


def test_a_length_has_no_exponent():
    shown = {name: value for name, value, _ in list_figures(presets.get("spirob-1m"))}
    assert shown["Length"] == "1000 mm"


def test_sizes_that_nothing_takes_are_told():
    assert find_gap(presets.PAPER) == ""
    short = change_field(presets.PAPER, "gripper.finger_length", 0.02)
    smallest = 1e3 * graspable_range(short).minimum
    assert f"to {smallest:.3g} mm fit neither" in find_gap(short)


def test_warnings_are_text_and_never_html():
    assert "&lt;script&gt;" in format_warnings(["<script>"], False)
    assert "No warnings" in format_warnings([], False)
    assert "Checking" in format_warnings([], True)


@pytest.mark.parametrize(
    ("rules", "words"),
    [
        ({"turns": 2.5}, "'Gripper at the tip' switched off"), ({"m": 0.6}, "a finer nozzle"),
        ({"arm_radius": 0.2}, "a larger bed (set by the command export)"),
    ],
)  # fmt: skip
def test_warnings_name_the_controls_of_the_page(rules, words):
    design = change_rules(presets.PAPER, **rules)
    told, typed = " ".join(find_faults(design, PAGE_OPTIONS)), " ".join(find_faults(design))
    assert words in told
    assert "--" not in told
    assert "[gripper]" not in told
    assert "--" in typed, "the command line's own words stay"


def test_the_legend_names_the_cables_and_the_construction_where_it_is_shown():
    for with_construction in (True, False):
        legend = format_legend(with_construction)
        assert f"background:rgb{CABLE}" in legend
        assert "cables" in legend
        assert ("backbone" in legend) == with_construction


def test_a_changed_preset_has_another_name():
    assert find_preset(presets.PAPER) == "paper"
    changed = rename(change_field(presets.PAPER, "cable.friction", 0.1))
    assert changed.name == "my-paper"
    assert rename(changed) == changed
    assert find_preset(changed) == OWN
    assert rename(presets.PAPER) == presets.PAPER


def test_names_of_files_are_no_paths():
    assert clean_name("../../etc/passwd") == "passwd"
    assert clean_name("..\\up\\a b.toml") == "a_b.toml"
    assert clean_name("...") == "file"
    assert name_file(replace(presets.PAPER, name="../a b/c"), ".zip") == "a-b-c.zip"
    assert name_file(replace(presets.PAPER, name="../"), ".zip") == "trunk.zip"


def test_files_that_are_no_design_are_one_line():
    assert read_upload("mine.toml", format_design(presets.PAPER).encode()) == presets.PAPER
    with pytest.raises(DesignError, match=r"'mine\.toml'") as refusal:
        read_upload("mine.toml", b"\xff\xfe\x00")
    assert "\n" not in str(refusal.value)
    named = format_design(change_field(presets.PAPER, "arm.model", "/etc/passwd"))
    with pytest.raises(StudioError, match=r"arm\.model is a path"):
        read_upload("mine.toml", named.encode())


def test_cables_are_spaced_evenly():
    four = space_cables(presets.PAPER, 4)
    assert four.n_cable == 4
    assert four.cable_direction.sum(axis=0) == pytest.approx(0.0, abs=1e-12)


def test_a_trunk_too_short_to_wrap_is_told():
    short = replace(presets.PAPER, n_section=2, mass=MassDesign())
    shown = {name: value for name, value, _ in list_figures(short)}
    assert (shown["Graspable"], shown["Payload"]) == ("nothing, too short", "none")
    assert "too short to wrap anything" in find_gap(short)
