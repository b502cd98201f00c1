"""Mean and differences of the cables' pulls."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.design import presets
from spiraltrunk.errors import DesignError, ModelError
from spiraltrunk.model.kinematics import cables
from spiraltrunk.model.kinematics.cable_modes import build_cable_modes

LENGTHS = st.floats(-0.1, 0.1)


def test_modes_of_the_paper_s_three_cables():
    modes = build_cable_modes(presets.PAPER)
    assert modes.names == ("mean", "dorsal - ventral", "side")
    assert modes.read([0.08, -0.03, -0.05]) == pytest.approx([0.0, 0.12, 0.02])


def test_two_opposed_cables_have_no_side():
    modes = build_cable_modes(presets.get("spirob-15"))
    assert modes.names == ("mean", "dorsal - ventral")
    assert modes.read([0.02, -0.01]) == pytest.approx([0.005, 0.03])


@given(pull=st.tuples(LENGTHS, LENGTHS, LENGTHS), mode=st.integers(0, 2), value=LENGTHS)
def test_a_changed_mode_leaves_the_others(pull, mode, value):
    modes = build_cable_modes(presets.PAPER)
    expected = modes.read(pull)
    expected[mode] = value
    assert modes.read(modes.change(pull, mode, value)) == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize(("mode", "axis"), [(1, 1), (2, 0)])
def test_a_difference_is_what_a_small_bend_pulls(mode, axis):
    design = presets.PAPER
    bend = np.zeros((design.n_joint, 2))
    bend[:, axis] = 1e-4
    change = cables.lengths(design, bend).change
    read = build_cable_modes(design).read(change)
    assert abs(read[mode]) > 1e-6
    assert np.delete(read, mode) == pytest.approx([0, 0], abs=1e-3 * abs(read[mode]))


def test_what_is_no_pull_is_refused():
    modes = build_cable_modes(presets.PAPER)
    with pytest.raises(ModelError, match="pull"):
        modes.read([0.0, np.nan, 0.0])
    with pytest.raises(ModelError, match="pull"):
        modes.read([0.0, 0.0])
    with pytest.raises(DesignError, match="mode is 3; allowed"):
        modes.change([0.0, 0.0, 0.0], 3, 0.0)
