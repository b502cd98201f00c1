"""The front is where the curl ends, and the order of the joints is told as it was."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.model.kinematics.curl_front import compute_front, compute_order, compute_propagation

LIMIT = np.pi / 6
N_JOINT = 17
LENGTH = 0.05 * 0.92 ** np.arange(N_JOINT + 1)
TIME = np.linspace(0.0, 20.0, 401)
SPANS = (("reach", 0.0, 2.0), ("prehension", 2.0, 7.0), ("transport", 7.0, 12.0), ("release", 12.0, 20.0))
JOINTS = np.arange(N_JOINT)


def step(first: int, *, straight: float = 0.0, shut: float = LIMIT) -> np.ndarray:
    """Bends of a trunk that is curled from joint ``first`` on, counted from 0 at the base."""
    return np.where(first <= JOINTS, shut, straight)


def history(delays: np.ndarray, *, bend: float = LIMIT, openings: np.ndarray | None = None) -> np.ndarray:
    """Bends that rise one second from 2 s plus the joint's delay on, and fall from 12 s plus its opening on."""
    openings = delays[::-1] if openings is None else openings
    rise = np.clip(TIME[:, None] - 2.0 - delays, 0.0, 1.0)
    return bend * (rise - np.clip(TIME[:, None] - 12.0 - openings, 0.0, 1.0))


def tell(joint_bend: np.ndarray, spans=SPANS):
    return compute_propagation(TIME, joint_bend, spans, section_length=LENGTH, joint_limit=LIMIT)


FROM_TIP = np.linspace(4.0, 0.0, N_JOINT)
"""Delays with which the tip bends first."""


@pytest.mark.parametrize("first", range(N_JOINT + 1))
def test_a_step_ends_where_it_is(first: int) -> None:
    assert compute_front(step(first), LENGTH, LIMIT) == pytest.approx(LENGTH[first + 1 :].sum(), abs=1e-15)


@pytest.mark.parametrize("straight", [0.0, 0.2, 0.49])
@pytest.mark.parametrize("shut", [0.51, 0.8, 1.1])
def test_half_the_limit_parts_straight_from_curled(straight: float, shut: float) -> None:
    bend = step(9, straight=straight * LIMIT, shut=shut * LIMIT)
    assert compute_front(bend, LENGTH, LIMIT) == pytest.approx(LENGTH[10:].sum())
    assert compute_front(np.full(N_JOINT, LIMIT / 2), LENGTH, LIMIT) == 0.0


@given(st.integers(0, N_JOINT - 1), st.integers(2, N_JOINT - 3))
def test_a_single_joint_does_not_move_it(odd: int, first: int) -> None:
    """One joint that lags in the curl, or bends alone further in, but at the very end of the curl or beside it."""
    bend = step(first)
    bend[odd] = LIMIT - bend[odd]
    if odd not in (first - 1, first, first + 1):
        assert compute_front(bend, LENGTH, LIMIT) == pytest.approx(LENGTH[first + 1 :].sum())


@given(st.lists(st.floats(0.0, LIMIT), min_size=N_JOINT, max_size=N_JOINT), st.floats(0.01, 100.0))
def test_it_is_the_best_step_and_scales(bend: list[float], scale: float) -> None:
    front = float(compute_front(np.array(bend), LENGTH, LIMIT))
    beyond = np.append(LENGTH[::-1].cumsum()[:-1][::-1], 0.0)  # By first curled joint; the last for none.
    chosen = int(np.argmin(np.abs(beyond - front)))
    assert front == pytest.approx(beyond[chosen])
    missed = [np.sum((np.array(bend) / LIMIT - (first <= JOINTS)) ** 2) for first in range(N_JOINT + 1)]
    assert missed[chosen] == pytest.approx(min(missed), abs=1e-9)
    assert compute_front(np.array(bend), scale * LENGTH, LIMIT) == pytest.approx(scale * front)


def test_histories_are_taken_at_once() -> None:
    bends = np.array([[step(first)] for first in (17, 9, 3)])
    front = compute_front(bends, LENGTH, LIMIT)
    assert front.shape == (3, 1)
    np.testing.assert_allclose(front[:, 0], [0.0, LENGTH[10:].sum(), LENGTH[4:].sum()])


def test_order_is_one_zero_or_half() -> None:
    rising = np.clip(TIME[:, None] - FROM_TIP, 0.0, 1.0) * LIMIT
    assert compute_order(rising, LIMIT, opens=False) == 1.0
    assert compute_order(rising[:, ::-1], LIMIT, opens=False) == 0.0
    assert compute_order(np.repeat(rising[:, :1], 5, axis=1), LIMIT, opens=False) == 0.5
    assert compute_order(rising, LIMIT, opens=True) is None
    assert compute_order(LIMIT - rising, LIMIT, opens=True) == 0.0
    assert compute_order(LIMIT - rising[:, ::-1], LIMIT, opens=True) == 1.0


def test_order_counts_pairs() -> None:
    """Joints 1 and 2 changed over: one pair of 136."""
    delays = FROM_TIP.copy()
    delays[:2] = delays[1::-1]
    rising = np.clip(TIME[:, None] - delays, 0.0, 1.0) * LIMIT
    assert compute_order(rising, LIMIT, opens=False) == pytest.approx(135 / 136)


def test_order_is_of_the_last_crossing_and_of_joints_that_move() -> None:
    """A first attempt from the base that is let go does not count, nor do joints that hardly move."""
    attempt = np.clip(TIME[:, None] - 8.0 + FROM_TIP, 0.0, 1.0) - np.clip(TIME[:, None] - 10.0, 0.0, 1.0)
    bend = LIMIT * np.maximum(attempt, np.clip(TIME[:, None] - 12.0 - FROM_TIP, 0.0, 1.0))
    assert compute_order(bend, LIMIT, opens=False) == 1.0
    bend[:, 0] *= 0.24
    bend[:, 0] = bend[::-1, 0].max() - bend[::-1, 0]
    assert compute_order(bend, LIMIT, opens=False) == 1.0
    assert compute_order(bend[:, :2], LIMIT, opens=False) is None


@pytest.mark.parametrize("size", [0.3, 1.0])
def test_a_curl_from_the_tip_that_opens_from_the_base_is_both(size: float) -> None:
    found = tell(history(FROM_TIP, bend=size * LIMIT))
    assert (found.tip_first, found.base_first) == (1.0, 1.0)
    assert found.prehension_start == found.release_end == 0.0
    if size == 1.0:
        assert found.transport_max == pytest.approx(1 - LENGTH[0] / LENGTH.sum())
    else:
        assert found.transport_max == 0.0
    assert found.is_inward == found.is_outward == (size == 1.0)


def test_the_reverse_is_neither() -> None:
    found = tell(history(FROM_TIP[::-1]))
    assert (found.tip_first, found.base_first) == (0.0, 0.0)
    assert found.transport_max > 0.85
    assert not found.is_inward
    assert not found.is_outward
    mixed = tell(history(FROM_TIP, openings=FROM_TIP))
    assert mixed.is_inward
    assert not mixed.is_outward


def test_noise_does_not_undo_it() -> None:
    noise = np.random.default_rng(3).normal(0.0, 0.02, (len(TIME), N_JOINT))
    found = tell(history(FROM_TIP) + noise)
    assert found.tip_first > 0.97
    assert found.is_inward
    assert found.is_outward


def test_what_did_not_come_is_not_claimed() -> None:
    found = tell(history(FROM_TIP), SPANS[:2])
    assert (found.prehension_start, found.transport_max, found.release_end) == (None, None, None)
    assert not found.is_inward
    assert not found.is_outward
    still = tell(np.zeros((len(TIME), N_JOINT)))
    assert (still.transport_max, still.tip_first, still.base_first) == (0.0, None, None)
    assert not still.is_inward
    assert not still.is_outward
