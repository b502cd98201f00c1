"""Where the tip can be."""

from __future__ import annotations

import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.errors import ModelError
from spiraltrunk.model import statics
from spiraltrunk.model.inverse import workspace


def test_a_map_holds_equilibria_within_the_trunks_length() -> None:
    design = presets.PAPER
    found = workspace.map(design, levels=5)
    assert len(found.tip) == 5**3
    assert np.linalg.norm(found.tip, axis=-1).max() <= design.length + 1e-9
    assert found.tension.max() == design.cable.tension_max
    again = statics.solve(design, tension=found.tension[[7, 60]])
    np.testing.assert_array_equal(again.points[:, -1], found.tip[[7, 60]])


def test_a_hanging_trunks_map_mirrors_at_its_plane() -> None:
    found = workspace.map(presets.PAPER, levels=4)
    swapped = [np.flatnonzero((found.tension == row[[0, 2, 1]]).all(axis=1))[0] for row in found.tension]
    lean = (found.tension > 0).sum(axis=1) < 3  # With all cables taut the trunk may buckle to either side.
    mirrored = found.tip[swapped] * [1, 1, -1]
    np.testing.assert_allclose(mirrored[lean], found.tip[lean], atol=1e-5)


def test_a_planar_trunks_tips_lie_in_its_plane() -> None:
    found = workspace.map(presets.get("spirob-15"), levels=8)
    assert found.in_plane(1e-4).all()


def test_two_levels_are_slack_and_the_largest_tension() -> None:
    found = workspace.map(presets.get("spirob-15"), levels=2)
    assert np.unique(found.tension).tolist() == [0.0, presets.get("spirob-15").cable.tension_max]


def test_too_many_levels_and_batches_are_refused() -> None:
    with pytest.raises(ModelError, match="levels"):
        workspace.map(presets.PAPER, levels=1000)
    with pytest.raises(ModelError, match="batch"):
        workspace.map(presets.PAPER, levels=3, theta_0=np.ones(4))
