"""Sections as they are drawn."""

import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.model.statics.pull_sequences import wind_cables
from spiraltrunk.studio.drawing.half_sections import build_halves
from spiraltrunk.studio.drawing.trunk_view import color_by_joint, linear_color, place_sections

DESIGN = presets.PAPER


def compute_volume(surfaces):
    """Volume that surfaces of one orientation enclose."""
    corners = np.concatenate([points[faces] for points, faces in surfaces])
    return np.einsum("ni,ni->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6


def test_both_halves_enclose_the_section():
    volume = compute_volume(build_halves(DESIGN.solid))
    assert volume == pytest.approx(DESIGN.solid.volume, rel=0.01)


@pytest.mark.parametrize("base", [(np.pi / 2, 0.0), (0.4, 1.1)])
def test_sections_are_drawn_where_the_model_has_them(base):
    shape = wind_cables(DESIGN, [0.08, -0.03, -0.12], *base)
    poses = place_sections(DESIGN, shape.joint_rotation, *base)
    ends = poses.position + DESIGN.section_length[:, None] * poses.rotation[:, :, 0]
    assert ends == pytest.approx(shape.points, abs=1e-9)


def test_a_joint_colours_what_lies_beside_it():
    colors = np.zeros((DESIGN.n_joint, 3))
    colors[4] = 255
    proximal, distal = color_by_joint(colors, (9, 9, 9))
    assert [i for i in range(DESIGN.n_section) if proximal[i, 0] == 255] == [5]
    assert [i for i in range(DESIGN.n_section) if distal[i, 0] == 255] == [4]


def test_colours_of_lines_are_linear_light():
    assert linear_color((255, 0, 128)) == (255, 0, 56)
