"""The world's options: what no trial could be judged by is refused."""

import pytest

from spiraltrunk.errors import DesignError
from spiraltrunk.sim.scene.options import SceneOptions


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"lift": 0.0}, r"scene\.lift is 0\.0; allowed: a finite number, above 0"),
        ({"lift": -0.1}, r"scene\.lift"),
        ({"aside": 0.0}, r"scene\.aside is 0\.0; allowed: any distance but 0"),
        ({"aside": float("nan")}, r"scene\.aside"),
    ],
)
def test_a_way_that_nothing_can_be_judged_by_is_refused(changes, match):
    with pytest.raises(DesignError, match=match):
        SceneOptions(**changes)


def test_the_carry_may_go_either_way():
    assert SceneOptions(aside=-0.2).aside == -0.2
