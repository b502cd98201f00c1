"""Variants of a design."""

import math
from dataclasses import replace

import pytest

from spiraltrunk.design import design_from_rules, presets
from spiraltrunk.design.edit import (
    MEASURED,
    change_field,
    change_rules,
    fit_delta_theta,
    list_fields,
    read_field,
    read_rules,
)
from spiraltrunk.design.schema import TABLES, Kind
from spiraltrunk.errors import DesignError, UnknownName


def test_rules_that_were_read_give_the_design_again():
    ruled = design_from_rules(m=2.0, delta_theta=math.radians(20), arm_radius=0.04)
    assert read_rules(ruled) == pytest.approx((2.0, math.radians(20), 0.04, 1.5), rel=1e-12)
    again = change_rules(ruled, m=read_rules(ruled).m)
    for name in list_fields():
        value, expected = read_field(again, name), read_field(ruled, name)
        assert value == (pytest.approx(expected, rel=1e-12) if isinstance(expected, float) else expected), name


@pytest.mark.parametrize(
    ("wish", "value"), [("m", 2.0), ("arm_radius", 0.06), ("turns", 2.0), ("delta_theta", math.radians(20))]
)
def test_a_changed_rule_gives_the_sections_of_the_rules(wish, value):
    changed = change_rules(design_from_rules(), **{wish: value})
    expected = design_from_rules(**{wish: value})
    assert changed.n_section == expected.n_section
    assert changed.section_length == pytest.approx(expected.section_length)
    assert changed.section_radius == pytest.approx(expected.section_radius)
    assert changed.joint.radius == pytest.approx(expected.joint.radius)
    assert changed.gripper.finger_length == pytest.approx(expected.gripper.finger_length)


def test_what_was_measured_is_left_out_with_the_sections_it_was_measured_on():
    assert presets.PAPER.mass.sections is not None
    for changed in (change_rules(presets.PAPER, arm_radius=0.05), change_field(presets.PAPER, "n_section", 19)):
        assert all(read_field(changed, name) is None for name in MEASURED)
    kept = change_field(presets.PAPER, "cable.friction", 0.1)
    assert kept.mass == presets.PAPER.mass
    assert change_field(presets.PAPER, "n_section", 18) == presets.PAPER


def test_other_fields_stay_with_the_rules():
    rubbing = replace(presets.PAPER, cable=replace(presets.PAPER.cable, friction=0.15))
    assert change_rules(rubbing, m=2.0).cable == rubbing.cable


def test_angle_and_turns_move_to_whole_sections():
    assert fit_delta_theta(math.radians(29), 1.5) == pytest.approx(math.radians(540 / 19))
    assert change_rules(presets.PAPER, delta_theta=math.radians(29)).n_section == 19
    assert change_rules(presets.PAPER, turns=1.3).n_section == 16
    assert change_rules(presets.PAPER, turns=0.75).n_section == 9
    assert fit_delta_theta(math.radians(89.9), 1.5) < math.pi / 2


@pytest.mark.parametrize(
    ("wish", "value"),
    [
        ("m", 11.0),
        ("arm_radius", math.nan),
        ("turns", 6.0),
        ("delta_theta", 2.0),
        ("delta_theta", -0.1),
        ("turns", math.inf),
    ],
)
def test_requirements_out_of_range_are_refused(wish, value):
    with pytest.raises(DesignError, match=wish):
        change_rules(presets.PAPER, **{wish: value})


def test_every_key_of_a_file_is_a_field():
    assert len(list_fields()) == sum(len(keys) for keys in TABLES.values())
    for name in list_fields():
        assert change_field(presets.PAPER, name, read_field(presets.PAPER, name)) == presets.PAPER


def test_unknown_fields_and_absent_parts_are_refused():
    with pytest.raises(UnknownName, match=r"cable\.friction"):
        change_field(presets.PAPER, "cable.frction", 0.1)
    bare = replace(presets.PAPER, gripper=None)
    assert read_field(bare, "gripper.mass") is None
    with pytest.raises(DesignError, match="gripper"):
        change_field(bare, "gripper.mass", 0.1)
    with pytest.raises(DesignError, match=r"cable\.friction"):
        change_field(presets.PAPER, "cable.friction", -1.0)


def test_usual_ranges_are_ranges_that_presets_lie_in():
    for table, keys in TABLES.items():
        for key in keys:
            if key.kind not in (Kind.NUMBER, Kind.COUNT):
                assert key.usual is None, key.name
                continue
            least, most = key.usual
            assert least < most
            value = read_field(
                presets.PAPER,
                key.field
                if table in ("", "spiral") and key.owner.__name__ == "TrunkDesign"
                else f"{table}.{key.field}",
            )
            assert value is None or least <= value / float(key.unit) <= most, key.name
