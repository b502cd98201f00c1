"""Slack compensation: the paper's steps, between the steps, and back."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.design import presets
from spiraltrunk.errors import DesignError, DriveError
from spiraltrunk.hardware.winder.slack import compensate_slack, remove_slack
from spiraltrunk.mocap.protocol.protocol import Protocol

STROKE = presets.PAPER.cable_stroke
PULLS = st.floats(-0.2, 0.2)
SLACKS = st.floats(-0.02, 0.03)


@pytest.mark.parametrize("n_step", [1, 13, 26])
def test_the_papers_steps(n_step):
    """dL'_i = dL_i + C i, C = L_slack / N_steps, of equal steps up to the full stroke."""
    slack, steps = 5e-3, np.arange(n_step + 1)
    pulls = steps * STROKE / n_step
    paper = pulls + slack / n_step * steps
    np.testing.assert_allclose([compensate_slack(p, slack, STROKE) for p in pulls.tolist()], paper, rtol=1e-13)


def test_slack_is_named_and_measured_as_in_a_protocol():
    """Metres on the fully wrapped trunk, as of `Protocol.slack`."""
    protocol = Protocol.__dataclass_fields__["slack"].default
    assert compensate_slack(STROKE, protocol[0], STROKE) == STROKE


@given(PULLS, SLACKS)
def test_removing_is_the_inverse(pull, slack):
    there = compensate_slack(pull, slack, STROKE)
    assert remove_slack(there, slack, STROKE) == pytest.approx(pull, abs=1e-12)


@given(PULLS, PULLS, SLACKS)
def test_more_pull_is_more_cable(a, b, slack):
    low, high = sorted((a, b))
    assert compensate_slack(low, slack, STROKE) <= compensate_slack(high, slack, STROKE)


@given(PULLS, SLACKS)
def test_never_more_than_the_slack_and_nothing_of_a_cable_paid_out(pull, slack):
    more = compensate_slack(pull, slack, STROKE) - pull
    assert abs(more) <= abs(slack) + 1e-12
    assert pull > 0 or more == 0


def test_no_limit_stays_no_limit():
    assert compensate_slack(math.inf, 5e-3, STROKE) == math.inf
    assert remove_slack(math.inf, 5e-3, STROKE) == math.inf


def test_what_is_no_length_is_refused():
    with pytest.raises(DriveError, match="pull of a winder is nan"):
        compensate_slack(math.nan, 5e-3, STROKE)
    with pytest.raises(DesignError, match=r"winder.slack is nan"):
        compensate_slack(0.01, math.nan, STROKE)
    with pytest.raises(DesignError, match=r"winder.stroke is 0.0"):
        compensate_slack(0.01, 5e-3, 0.0)
