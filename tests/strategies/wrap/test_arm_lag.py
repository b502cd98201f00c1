"""While the trunk curls, its tensions wait for the arm by its lag, and by nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.strategies.wrap.arm_lag import LAG, Tensions, delay_tension

LATE = round(LAG / CONTROL_PERIOD)


@pytest.mark.parametrize("action", ["curl", "tighten"])
def test_tensions_come_late_by_the_lag(action: str) -> None:
    recent: Tensions = ()
    planned = [np.array([float(i), 0.0]) for i in range(3 * LATE)]
    given = []
    for tension in planned:
        recent, now = delay_tension(recent, action, tension)
        given.append(now[0])
    assert given == [max(0.0, i - LATE) for i in range(3 * LATE)]
    assert len(recent) == LATE + 1


def test_other_moves_have_their_own_tensions_and_forget_the_earlier_ones() -> None:
    recent, _ = delay_tension((), "curl", np.array([1.0]))
    for action in ("near", "try", "let go", "lift", "uncurl"):
        forgotten, tension = delay_tension(recent, action, np.array([2.0]))
        assert forgotten == ()
        assert tension.tolist() == [2.0]
