"""A loading path takes each cable once at most, in any order; what it does is tested with the inverse."""

from __future__ import annotations

import re
from itertools import permutations

import numpy as np
import pytest

from spiraltrunk.errors import ModelError
from spiraltrunk.model.statics import LoadingPath


def build_path(order: tuple[int, ...]) -> LoadingPath:
    return LoadingPath(
        order=np.array(order), pull=np.array([0.01, 0.02, 0.0]), tension=np.array([60.0, 60.0, 5.0]),
        by_tension=np.array([False, False, True]),
    )  # fmt: skip


@pytest.mark.parametrize("turns", [0, 1, 2, 3])
def test_a_path_is_told_in_its_order(turns: int) -> None:
    for chosen in permutations(range(3), turns):
        told = repr(build_path((*chosen, *[-1] * (3 - turns))))
        assert [int(cable) for cable in re.findall(r"cable (\d)", told)] == list(chosen)
        assert ("rest" in told) == (turns == 0)


@pytest.mark.parametrize("order", [(0, 1, 3), (-2, 0, 1), (7, -1, -1)])
def test_a_cable_that_the_trunk_does_not_have_is_refused(order: tuple[int, ...]) -> None:
    with pytest.raises(ModelError, match="out of range; allowed: -1 to 2"):
        build_path(order)
