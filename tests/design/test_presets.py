"""Named designs are found by what they are."""

from dataclasses import replace

from spiraltrunk.design import presets


def test_a_design_has_the_name_of_the_preset_that_it_equals():
    assert [presets.find_name(presets.get(name)) for name in presets.NAMES] == list(presets.NAMES)
    assert presets.find_name(replace(presets.PAPER, cable=replace(presets.PAPER.cable, friction=0.1))) is None
