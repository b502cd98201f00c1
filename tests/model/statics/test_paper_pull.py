"""The paper's model beside an equilibrium."""

import math
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.model import reference
from spiraltrunk.model.statics.paper_pull import compute_paper_shape
from spiraltrunk.model.statics.pull_sequences import pull_ventral, rest, wind_cables

DESIGN, HANGING = presets.PAPER, math.pi / 2
SLACK = -0.12


def compare(*pull, theta_0=HANGING, roll=0.0, design=DESIGN):
    at_rest = wind_cables(design, np.full(design.n_cable, SLACK), theta_0, roll)
    return compute_paper_shape(design, wind_cables(design, pull, theta_0, roll), at_rest, theta_0, roll)


def test_slack_cables_are_rest():
    found = compare(SLACK, SLACK, SLACK, theta_0=1.0)
    assert found.pull == "rest"
    assert np.array_equal(found.shape.points, reference.rest(DESIGN, 1.0).points)


def test_cable_1_alone_is_the_dorsal_bend_from_rest():
    found = compare(0.08, SLACK, SLACK, theta_0=1.0)
    pull = 0.08 - float(rest(DESIGN, 1.0).cable_change[0])
    assert found.pull == f"cable 1 in by {1e3 * pull:.1f} mm"
    assert found.shape.points == pytest.approx(reference.bend_dorsal(DESIGN, pull, 1.0).points, abs=1e-12)


def test_ventral_cables_pulled_equally_lengthen_cable_1_alike():
    found = compare(SLACK, 0.05, 0.05)
    shape = wind_cables(DESIGN, [SLACK, 0.05, 0.05])
    assert found.shape.cable_change[0] == pytest.approx(shape.cable_change[0], abs=2e-3)
    assert "until cable 1 is" in found.pull


@pytest.mark.parametrize("n_cable", [2, 4, 6])
def test_the_ventral_cables_of_other_trunks_are_known_too(n_cable):
    """Of six cables the two beside the middle one are taut: that one comes in farther."""
    angles = tuple(2 * math.pi * i / n_cable for i in range(n_cable))
    design = replace(DESIGN, cable=replace(DESIGN.cable, angles=angles))
    found = compute_paper_shape(design, pull_ventral(design, 0.04), rest(design), HANGING)
    assert found.pull == "ventral cables in until cable 1 is 40.0 mm longer"
    assert found.shape.cable_change[0] - reference.rest(design, HANGING).cable_change[0] == pytest.approx(
        -0.04, abs=1e-5
    )


def test_a_twist_ends_at_the_same_lengths_of_cables_1_and_2():
    found = compare(0.08, -0.02, SLACK)
    assert found.shape.cable_change[:2] == pytest.approx([0.08, -0.02], abs=2e-3)
    assert "then cable 2 by" in found.pull


@pytest.mark.parametrize(
    ("pull", "roll", "reason"),
    [
        ((0.08, SLACK, SLACK), 0.3, "no roll"),
        ((0.08, SLACK, -0.02), 0.0, "no shape"),
        ((SLACK, 0.05, 0.02), 0.0, "no shape"),
    ],
)
def test_other_pulls_have_no_shape_and_say_why(pull, roll, reason):
    found = compare(*pull, roll=roll)
    assert found.shape is None
    assert reason in found.pull


def test_a_design_that_the_paper_does_not_know_says_why():
    cable = replace(DESIGN.cable, angles=(0.5, 2.5, 4.5))
    found = compare(SLACK, SLACK, SLACK, design=replace(DESIGN, cable=cable))
    assert found.shape is None
    assert "cable 1 dorsal" in found.pull
