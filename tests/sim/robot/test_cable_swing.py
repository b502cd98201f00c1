"""How fast the cables of a curled trunk swing, against what the integrator bears."""

from __future__ import annotations

import math

import pytest

from spiraltrunk.design import presets
from spiraltrunk.design.rules import design_from_rules
from spiraltrunk.sim.robot.cable_swing import compute_cable_swing
from spiraltrunk.sim.scene.options import TIMESTEP


@pytest.mark.parametrize("sections", [21, 22, 24, 27, 36])
def test_cables_held_by_length_swing_no_faster_in_fine_sections_than_in_coarse_ones(sections):
    design = design_from_rules(delta_theta=math.radians(540.0 / sections))
    assert compute_cable_swing(design, TIMESTEP) < compute_cable_swing(design_from_rules(), TIMESTEP)


@pytest.mark.parametrize("name", ["paper", "spirob-15", "spirob-1m"])
def test_steps_of_1_ms_are_stable(name):
    assert 1.0 < compute_cable_swing(presets.get(name), 1e-3) < 2.0
