"""Where an object stands beside a trunk that curls round it: forces exactly, shapes by their laws."""

import math

import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.errors import ModelError
from spiraltrunk.strategies.wrap.standing_model import cable_pulls, curl_tilt, object_center, shut_pull

PAPER = presets.PAPER
LEVEL = math.radians(100.0)


@pytest.mark.parametrize(("ventral", "aside"), [(10.0, 0.0), (10.0, 4.0), (0.0, 1.25), (5.0, -20.0), (-3.0, 1.0)])
def test_pulls_add_up_to_what_was_asked_for_and_never_push(ventral: float, aside: float) -> None:
    tension = cable_pulls(PAPER, ventral, aside)
    assert (tension >= 0).all()
    np.testing.assert_allclose(tension @ PAPER.cable_direction, [0.0, -ventral, aside], atol=1e-9)


def test_no_cable_pulls_in_vain() -> None:
    assert np.count_nonzero(cable_pulls(PAPER, 10.0, 4.0)) <= 2


def test_a_trunk_of_two_cables_cannot_pull_aside() -> None:
    with pytest.raises(ModelError, match="spirob-15"):
        cable_pulls(presets.get("spirob-15"), 1.0, 1.0)


def test_the_pull_that_shuts_a_joint_shrinks_with_the_square_of_the_scale() -> None:
    pull = shut_pull(PAPER)
    np.testing.assert_allclose(pull[1:] / pull[:-1], PAPER.k_p**2, rtol=1e-9)


def test_a_wider_object_that_is_touched_at_the_same_section_stands_further_away() -> None:
    slack = cable_pulls(PAPER, 0.0, 1.4)
    thin, wide = (object_center(PAPER, width, LEVEL, slack) for width in (0.060, 0.062))
    assert np.linalg.norm(wide - thin) == pytest.approx(0.001, abs=1e-9)


def test_the_object_comes_nearer_to_the_base_as_the_trunk_curls() -> None:
    ahead = [
        object_center(PAPER, 0.06, LEVEL, cable_pulls(PAPER, pull, 0.0))[1] for pull in (0.0, 4.0, 8.0, 16.0, 30.0)
    ]
    assert (np.diff(ahead) < 0).all()
    assert 0 < ahead[-1] < 0.25 * ahead[0]


def test_a_section_nearer_to_the_base_touches_an_object_nearer_to_the_base() -> None:
    slack = cable_pulls(PAPER, 0.0, 1.4)
    ahead = [object_center(PAPER, 0.06, LEVEL, slack, section)[1] for section in (7, 5, 3)]
    assert (np.diff(ahead) < 0).all()


def test_a_tight_curl_turns_with_its_base() -> None:
    tight = cable_pulls(PAPER, 40.0, 0.0)
    level, falling = (curl_tilt(PAPER, 0.06, tight, math.radians(slope)) for slope in (0.0, 20.0))
    assert level == pytest.approx(math.radians(90.0), abs=math.radians(3.0))
    assert level - falling == pytest.approx(math.radians(20.0), abs=math.radians(1.0))
