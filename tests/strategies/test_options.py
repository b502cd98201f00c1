"""What strategies may be told to do otherwise is checked when it is told."""

import math
from dataclasses import fields, replace

import pytest

from spiraltrunk import strategies
from spiraltrunk.errors import DesignError
from spiraltrunk.strategies.push.sweep import SweepOptions

USUAL = {name: strategies.get(name).options for name in strategies.NAMES}
USUAL["steering"] = SweepOptions().steering


@pytest.mark.parametrize("name", USUAL)
def test_a_choice_that_is_no_number_of_its_kind_is_refused(name):
    usual = USUAL[name]
    for field in fields(usual):
        for wrong in (math.nan, math.inf, -math.inf, "1", None, -1e9, 1e9, 1j, True):
            with pytest.raises(DesignError, match=rf"{type(usual).__name__}\.{field.name}.* is .*; allowed: "):
                replace(usual, **{field.name: wrong})


@pytest.mark.parametrize("name", USUAL)
def test_usual_choices_are_allowed_and_so_is_half_as_much(name):
    usual = USUAL[name]
    for field in fields(usual):
        value = getattr(usual, field.name)
        if isinstance(value, float):
            assert getattr(replace(usual, **{field.name: value / 2}), field.name) == value / 2


@pytest.mark.parametrize("name", strategies.NAMES)
def test_options_of_another_kind_are_refused(name):
    kind = type(strategies.get(name))
    other = USUAL["kick" if name != "kick" else "sweep"]
    for wrong in ("fast", {}, other, type(USUAL[name])):
        with pytest.raises(DesignError, match=rf"options is .*; allowed: {type(USUAL[name]).__name__}"):
            kind(wrong)
    assert kind(USUAL[name]).options is USUAL[name]


@pytest.mark.parametrize(
    ("name", "field"),
    [("wrap-vertical", "curl_time"), ("wrap-horizontal", "open_time"), ("kick", "speed"), ("sweep", "unroll")],
)
def test_what_is_divided_by_is_not_zero(name, field):
    with pytest.raises(DesignError, match=rf"\.{field} is 0\.0; allowed: a finite number, above 0, below 100"):
        replace(USUAL[name], **{field: 0.0})


def test_the_plane_turns_from_the_smaller_pull_to_the_larger():
    with pytest.raises(
        DesignError, match=r"StandingOptions\.turning is \(0\.7, 0\.3\); allowed: the smaller pull first"
    ):
        replace(USUAL["wrap-oblique"], turning=(0.7, 0.3))
