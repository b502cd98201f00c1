"""Slack compensation of the paper: more cable is wound in, in proportion to the pull.

The paper measures the residual slack L_slack of a cable on the fully wrapped trunk and spreads it over the steps of
tightening: C = L_slack / N_steps and dL'_i = dL_i + C i (Methods, "Material Elasticity"). N equal steps up to the full
stroke are i / N = dL_i / stroke, which needs no steps: dL' = dL (1 + L_slack / stroke). A cable that is paid out is not
compensated, nor is more than all of the slack.

``slack`` is that of `spiraltrunk.calibration` (``slack_1``, ...) and of ``slack_mm`` of a protocol, in metres. A
calibration fits it as cable that is taken in before the winder pulls; both agree at the full stroke.
"""

from __future__ import annotations

import math

from spiraltrunk.checks import check_number
from spiraltrunk.errors import DriveError


def compensate_slack(pull: float, slack: float, stroke: float) -> float:
    """Cable for the winder to pull in so that the trunk moves as by ``pull`` without slack [m].

    Args:
        pull: cable to pull in since the straight trunk, by the model; infinity stays infinity [m].
        slack: the cable's slack [m].
        stroke: pull that closes every gap, `spiraltrunk.design.TrunkDesign.cable_stroke` [m].

    Raises:
        DriveError: where the pull is not a number.
        DesignError: where slack or stroke is out of its range.
    """
    return pull + _share(pull, slack, stroke) * slack


def remove_slack(pull: float, slack: float, stroke: float) -> float:
    """Cable that the trunk's model sees pulled in where a winder has pulled in ``pull`` [m]; see `compensate_slack`."""
    return pull - _share(pull, slack, stroke + slack) * slack


def _share(pull: float, slack: float, full: float) -> float:
    """Share of the slack that is compensated, from 0 to 1 at the ``full`` pull [-]."""
    check_number("winder.slack", slack, above=-0.1, below=0.1)
    check_number("winder.stroke", full, above=max(slack, 0.0, -slack) * 1e-3)
    if math.isnan(pull):
        raise DriveError("pull of a winder is nan; allowed: metres, or infinity for no limit")
    return min(max(pull / full, 0.0), 1.0)
