"""The unwrapped angle of an encoder is the true one, and an angle that may be wrong says so."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.hardware.motors.turn_count import TurnCount

MODULI = {8192: 0.09375, 4096: 0.5}
"""Modulus, and time of half a turn at full speed [s]."""


@given(st.sampled_from(sorted(MODULI)), st.integers(0, 8191), st.lists(st.floats(-1, 1), min_size=1, max_size=30))
def test_the_position_is_the_true_one_over_many_turns(modulus, start, speeds):
    """At every speed that the motor has, read each millisecond, through any number of wraps."""
    step = modulus / 2 / MODULI[modulus] * 0.001
    turns, true = TurnCount(modulus, MODULI[modulus]), float(start % modulus)
    turns.update(int(true) % modulus, 0.0)
    for i, speed in enumerate(np.repeat(speeds, 20), start=1):
        true += speed * step
        moved = turns.update(int(np.floor(true)) % modulus, 0.001 * i)
        assert moved == int(np.floor(true)) - start % modulus
    assert not turns.is_lost


@pytest.mark.parametrize("modulus", MODULI)
def test_a_wrap_in_either_sense_is_one_step(modulus):
    turns = TurnCount(modulus, MODULI[modulus])
    assert [turns.update(raw, 0.01 * i) for i, raw in enumerate((modulus - 1, 0, modulus - 1))] == [0, 1, 0]
    assert not turns.is_lost


def test_recorded_positions_of_a_feetech_servo():
    """One turn below zero: the raw position 2600 after 10 is -1496 steps from zero (a public recording)."""
    turns = TurnCount(4096, 0.5)
    turns.update(10, 0.0)
    assert 10 + turns.update(2600, 0.4) == -1496


@pytest.mark.parametrize(("silence", "is_lost"), [(0.0937, False), (0.0938, True), (10.0, True)])
def test_the_count_is_lost_after_the_time_of_half_a_turn(silence, is_lost):
    turns = TurnCount(8192, 0.09375)
    turns.update(100, 1.0)
    turns.update(100, 1.0 + silence)
    assert turns.is_lost == is_lost


@pytest.mark.parametrize(("jump", "is_lost"), [(250, False), (-250, False), (300, True), (-300, True), (4096, True)])
def test_a_step_that_no_speed_explains_loses_the_count(jump, is_lost):
    """In 1 ms a GM6020 turns 44 steps; 5 ms more are granted to the arrival, which makes 262."""
    turns = TurnCount(8192, 0.09375)
    turns.update(1000, 0.0)
    turns.update((1000 + jump) % 8192, 0.001)
    assert turns.is_lost == is_lost


def test_a_lost_count_stays_lost_until_it_is_restarted_and_the_position_does_not_jump():
    turns = TurnCount(8192, 0.09375)
    turns.update(0, 0.0)
    turns.update(20, 5.0)
    assert turns.update(25, 5.001) == 25
    assert turns.is_lost
    turns.restart()
    assert not turns.is_lost
    assert turns.update(30, 5.002) == 30
    assert not turns.is_lost
