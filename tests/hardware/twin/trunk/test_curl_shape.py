"""Pictures of the twin's trunk agree with the lengths of cable that its curl takes up."""

import math

import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.hardware.twin.trunk.curl_shape import CurlShape
from spiraltrunk.hardware.twin.trunk.trunk_curl import compute_curl
from spiraltrunk.model.kinematics.cables import lengths_from_rotations
from spiraltrunk.model.kinematics.frames import section_ends

DESIGN = presets.PAPER


def test_the_straight_trunk_is_straight():
    frames = CurlShape(DESIGN).compute_frames((0.0, 0.0))
    assert section_ends(DESIGN, frames)[-1] == pytest.approx([DESIGN.length, 0.0, 0.0])


@pytest.mark.parametrize("angle", [0.0, 1.0, 2.0, -2.5])
def test_a_curl_bends_in_its_own_direction_as_far_as_another(angle):
    shape, size = CurlShape(DESIGN), 0.5 * DESIGN.cable_stroke
    x, y, z = section_ends(DESIGN, shape.compute_frames((size * math.cos(angle), size * math.sin(angle))))[-1]
    alone = section_ends(DESIGN, shape.compute_frames((size, 0.0)))[-1]
    assert [x, math.hypot(y, z)] == pytest.approx([alone[0], abs(alone[1])])
    assert np.sign(alone[1]) * np.array([y, z]) / math.hypot(y, z) == pytest.approx([math.cos(angle), math.sin(angle)])


@pytest.mark.parametrize("part", [0.2, 0.5, 0.9])
@pytest.mark.parametrize("angle", [0.0, 0.7, 2.0, -2.5])
def test_its_cables_are_as_short_as_the_twin_has_them(part, angle):
    """In the plane of the bend exactly, elsewhere as far as `trunk_curl` neglects the lean of a gap's faces."""
    size = part * DESIGN.cable_stroke
    curl = size * np.array([math.cos(angle), math.sin(angle)])
    turn = CurlShape(DESIGN).compute_frames(tuple(curl))[:, :3, :3]
    lengths = lengths_from_rotations(DESIGN, np.swapaxes(turn[:-1], -1, -2) @ turn[1:])
    table, index = compute_curl(DESIGN), size / compute_curl(DESIGN).step
    common, lever = (np.interp(index, range(len(row)), row) for row in (table.common, table.lever))
    taken = common + lever * DESIGN.cable_direction[:, 1:] @ curl
    assert lengths.change[0] == pytest.approx(taken[0], abs=1e-5 if angle == 0.0 else 0.03 * size)
    assert lengths.change == pytest.approx(taken, abs=0.03 * size)
