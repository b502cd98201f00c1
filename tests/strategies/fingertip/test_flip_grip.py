"""The distal flip: the tip turns as asked, the curl begins there, and the cables' lengths belong to the shape."""

import math
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.design.presets import PAPER, get
from spiraltrunk.errors import ModelError
from spiraltrunk.strategies.fingertip.flip_grip import find_flip


@pytest.fixture(scope="module")
def flip():
    return find_flip(PAPER, 0.02, math.radians(200.0))


def test_the_tip_turns_by_what_is_asked(flip):
    assert math.degrees(flip[1].joint_angle.sum()) == pytest.approx(200.0, abs=1.0)


def test_the_curl_begins_at_the_tip(flip):
    bend = flip[1].joint_angle
    assert (np.diff(bend) > -1e-6).all()
    assert bend[-1] == pytest.approx(PAPER.joint_limit, rel=1e-3)
    assert bend[0] < 0.1 * PAPER.joint_limit


def test_only_ventral_cables_pull_and_the_dorsal_one_pays_out(flip):
    tension, pull = flip[0], flip[1].cable_change
    np.testing.assert_allclose(tension, [0.0, tension[1], tension[1]])
    assert pull[1] == pytest.approx(pull[2], abs=1e-6)
    assert pull[1] > 0 > pull[0]


def test_a_heavier_object_takes_more_tension(flip):
    assert find_flip(PAPER, 0.04, math.radians(200.0))[0][1] > flip[0][1] + 0.02


def test_what_cannot_be_flipped_is_refused():
    weak = replace(PAPER, cable=replace(PAPER.cable, tension_max=2.0))
    with pytest.raises(ModelError, match=r"turns by .* deg at 2 N"):
        find_flip(weak, 0.02, math.radians(200.0))
    assert get("paper").gripper is not None
