"""Starts of the search: in turns by rank and apart from each other, and apart in proportion to the trunk."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.model.identity_cache import IdentityKey
from spiraltrunk.model.inverse.kernels.multistart import pick
from spiraltrunk.model.inverse.multistart import InverseOptions, _keep_start_table
from spiraltrunk.model.inverse.start_table import LoadCase


def test_every_other_start_is_apart_from_those_before_and_the_rest_go_by_rank() -> None:
    random = np.random.default_rng(1)
    points, order = random.uniform(-0.5, 0.5, (200, 18, 3)), random.permutation(200)
    starts = [int(pick(order, attempt, 0.3, points, np.zeros(200, bool))) for attempt in range(1, 12)]
    assert starts[1::2] == order[1:6].tolist()
    tips = points[[order[0], *starts[::2]], -1]
    apart = np.linalg.norm(tips[:, None] - tips, axis=-1)[np.triu_indices(len(tips), k=1)]
    assert apart.min() > 0.3
    place = [order.tolist().index(start) for start in starts[::2]]
    assert all(one < other for one, other in pairwise(place))


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_what_is_apart_and_what_is_close_grow_with_the_trunk(factor: float) -> None:
    large = replace(PAPER, spiral=replace(PAPER.spiral, a=factor * PAPER.spiral.a))
    case, options = LoadCase(np.pi / 2, 0.0, 0.0, -1, None, -1), InverseOptions(samples=4)
    one, other = (_keep_start_table(IdentityKey(design), case, options)[1] for design in (PAPER, large))
    assert other.apart == pytest.approx(factor * one.apart)
    assert other.close == pytest.approx(factor * one.close)
    assert 0.0 < one.close < one.apart < 0.5 * PAPER.length
    assert other.enough == one.enough == options.tolerance
