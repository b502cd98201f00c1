"""Capstan law: one kernel, which statics, calibration and simulation share."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.model.statics.kernels.laws.capstan_law import ratio, slip_forces, tension_ratio

COEFFICIENT = st.floats(0.0, 1.0)
TURN = st.floats(0.0, 2 * math.pi)


@given(mu=COEFFICIENT, turn=TURN)
def test_the_ratio_is_eulers_whether_of_numbers_or_of_arrays(mu, turn):
    assert ratio(mu, turn) == math.exp(-mu * turn)
    assert tension_ratio(np.array([mu]), np.array([turn]))[0] == pytest.approx(math.exp(-mu * turn), rel=1e-15)


@given(tension=st.floats(0.0, 100.0), mu=COEFFICIENT, turn=TURN)
def test_slip_takes_the_tension_to_the_ratio_on_either_side(tension, mu, turn):
    towards, away = slip_forces(tension, ratio(mu, turn), ratio(-mu, turn))
    assert tension - towards == pytest.approx(tension * math.exp(-mu * turn), rel=1e-12, abs=1e-300)
    assert tension + away == pytest.approx(tension * math.exp(mu * turn), rel=1e-12, abs=1e-300)
    assert 0.0 <= towards <= away + 2.0**-52 * tension  # Each ratio, near 1, is rounded.


@given(mu=COEFFICIENT, turns=st.lists(TURN, min_size=2, max_size=6))
def test_holes_one_after_the_other_are_one_hole_of_the_whole_turn(mu, turns):
    assert math.prod(ratio(mu, turn) for turn in turns) == pytest.approx(ratio(mu, sum(turns)), rel=1e-12)
