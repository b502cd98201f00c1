"""Fields of a design as controls show them."""

import math
import re

import pytest

from spiraltrunk.cli import main
from spiraltrunk.design import presets
from spiraltrunk.design.edit import change_field, change_rules, list_fields, read_field
from spiraltrunk.design.rules import M_MEANING
from spiraltrunk.design.schema import TABLES, Kind
from spiraltrunk.errors import DesignError
from spiraltrunk.studio.design.fields import as_labelled, describe_lost, divide, list_shown

PAPER = presets.PAPER
SHOWN = {field.name: field for table in TABLES for field in list_shown(table)}


def test_every_field_has_a_control_with_unit_and_words():
    assert set(SHOWN) == set(list_fields())
    assert SHOWN["joint.radius"].text == "Joint radius [mm]"
    assert SHOWN["joint.youngs_modulus"].unit == "MPa"
    assert all(len(field.hint) > 10 for field in SHOWN.values())


def test_no_two_fields_have_one_label():
    labels = [field.label for field in SHOWN.values()]
    assert len(set(labels)) == len(labels)


def test_hints_have_no_unit_in_si_and_no_word_of_code():
    for field in SHOWN.values():
        assert not re.search(r"\[|\]|None|\bours\b", field.hint), field.hint
        assert field.hint.endswith(".")
    assert SHOWN["housing.mass"].otherwise == "it follows from the material"
    assert SHOWN["spiral.a"].otherwise == ""


def test_errors_have_label_and_unit_of_the_control():
    with pytest.raises(DesignError) as caught:
        change_field(presets.PAPER, "arm.home", (1e6,) * 7)
    told = str(as_labelled(caught.value))
    assert told.startswith("Initial joints [deg], number 1 is")
    with pytest.raises(DesignError) as caught:
        change_field(presets.PAPER, "joint.radius", -0.002)
    assert str(as_labelled(caught.value)).startswith("Joint radius [mm] is -2")


def test_measured_values_that_another_shape_leaves_out_are_told():
    assert "Section masses: they follow from the density" in describe_lost(PAPER, change_rules(PAPER, m=1.6))
    assert describe_lost(PAPER, change_field(PAPER, "mass.sections", None)) == ""
    assert describe_lost(PAPER, change_field(PAPER, "cable.friction", 0.2)) == ""


@pytest.mark.parametrize("name", presets.NAMES)
def test_what_is_shown_is_read_back_as_it_was(name):
    design = presets.get(name)
    for field in SHOWN.values():
        value = read_field(design, field.name)
        if value is None:
            continue
        if field.key.kind in (Kind.NUMBER, Kind.COUNT):
            assert field.from_shown(field.to_shown(value)) == value
            assert change_field(design, field.name, field.from_shown(field.to_shown(value))) == design
        else:
            assert field.parse(field.format(value)) == value


def test_lists_are_texts_and_empty_ones_follow():
    angles = SHOWN["cable.angles"]
    assert angles.parse("0, 180") == (0.0, math.pi)
    assert SHOWN["mass.sections"].parse("  ") is None
    for text in ("0, x", "", "0,,1", "inf", "nan, 1"):
        with pytest.raises(DesignError, match="Directions"):
            angles.parse(text)


@pytest.mark.parametrize("text", ["\u0660, 120, 240", "0, 1_20, 240", "0;120;240", "0, 1e, 2"])
def test_numbers_are_of_ascii_digits_with_commas_between(text):
    with pytest.raises(DesignError, match="allowed: numbers, separated by commas"):
        SHOWN["cable.angles"].parse(text)


def test_ratio_m_is_told_as_by_the_command(capsys):
    assert main(["design", "--help"]) == 0
    assert M_MEANING in " ".join(capsys.readouterr().out.split())


def test_steps_are_round():
    assert divide(9.5) == (0.02, 3)
    assert divide(0.57) == (0.002, 4)
    assert divide(200.0) == (1.0, 1)
    for field in SHOWN.values():
        if field.key.usual is not None:
            assert 0 < field.scale.step <= (field.scale.most - field.scale.least)
