"""The distal flip: the tip turns as asked, the curl begins there, and the cables' lengths belong to the shape."""

import math
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.design.presets import PAPER, get
from spiraltrunk.errors import ModelError
from spiraltrunk.strategies.fingertip.flip_model import find_flip


@pytest.fixture(scope="module")
def flip():
    return find_flip(PAPER, 0.02, math.radians(200.0))


def test_the_tip_turns_by_what_is_asked(flip):
    assert math.degrees(flip.bend.sum()) == pytest.approx(200.0, abs=1.0)


def test_the_curl_begins_at_the_tip(flip):
    assert (np.diff(flip.bend) > -1e-6).all()
    assert flip.bend[-1] == pytest.approx(PAPER.joint_limit, rel=1e-3)
    assert flip.bend[0] < 0.1 * PAPER.joint_limit


def test_only_ventral_cables_pull_and_the_dorsal_one_pays_out(flip):
    np.testing.assert_allclose(flip.tension, [0.0, flip.tension[1], flip.tension[1]])
    assert flip.pull[1] == pytest.approx(flip.pull[2], abs=1e-6)
    assert flip.pull[1] > 0 > flip.pull[0]


def test_a_heavier_object_takes_more_tension(flip):
    assert find_flip(PAPER, 0.04, math.radians(200.0)).tension[1] > flip.tension[1] + 0.02


def test_what_cannot_be_flipped_is_refused():
    weak = replace(PAPER, cable=replace(PAPER.cable, tension_max=2.0))
    with pytest.raises(ModelError, match=r"turns by .* deg at 2 N"):
        find_flip(weak, 0.02, math.radians(200.0))
    assert get("paper").gripper is not None
