"""The cables of a curled trunk swing within what the integrator bears."""

from __future__ import annotations

import math

import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.rules import design_from_rules
from spiraltrunk.sim.robot.cable_swing import compute_cable_swing
from spiraltrunk.sim.scene.options import TIMESTEP


@pytest.mark.parametrize("sections", [21, 22, 24, 27, 36])
def test_cables_held_by_length_are_as_stable_in_fine_sections_as_in_coarse_ones(sections):
    design = design_from_rules(delta_theta=math.radians(540.0 / sections))
    assert compute_cable_swing(design, TIMESTEP) < compute_cable_swing(design_from_rules(), TIMESTEP)


def test_the_papers_trunk_is_stable_at_the_default_step():
    assert 1.9 < compute_cable_swing(PAPER, TIMESTEP) < 2.0
