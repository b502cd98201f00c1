"""Moves in sequence: continuous in place, speed and tension, whenever a move is cut short."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.control.messages import Command
from spiraltrunk.strategies.moves import (
    Move,
    MoveSequence,
    advance,
    command_at,
    fraction,
    insert_next,
    raise_tension,
    shift_later,
)

ENDS = ([0.3, 0.0, 1.2], [0.4, 0.1, 1.0], [0.4, 0.3, 1.3])
TENSIONS = ([0.0, 0.0, 0.0], [0.0, 20.0, 20.0], [0.0, 5.0, 5.0])


def _sequence():
    moves = tuple(
        Move(phase="reach", action=f"move {i}", duration=1.0 + i, position=np.array(end), tension=np.array(tension))
        for i, (end, tension) in enumerate(zip(ENDS, TENSIONS, strict=True))
    )
    T = np.eye(4)
    T[:3, 3] = [0.2, 0.0, 1.1]
    start = Command(T_world_base=T, cable_tension=np.zeros(3))
    return MoveSequence(moves=moves, index=0, since=0.0, start=start, velocity=np.zeros(3))


def _place(sequence, time):
    return command_at(sequence, time).T_world_base[:3, 3]


def _velocity(sequence, time, step=1e-5):
    """One-sided, forwards: the start of a move has no past."""
    return (-3 * _place(sequence, time) + 4 * _place(sequence, time + step) - _place(sequence, time + 2 * step)) / (
        2 * step
    )


def _velocity_before(sequence, time, step=1e-5):
    return (3 * _place(sequence, time) - 4 * _place(sequence, time - step) + _place(sequence, time - 2 * step)) / (
        2 * step
    )


@given(st.floats(0.05, 1.0), st.floats(0.05, 2.0))
def test_place_speed_and_tension_are_continuous_wherever_moves_are_cut(first, second):
    sequence, time = _sequence(), 0.0
    for duration in (first, second):
        time += duration
        later = advance(sequence, time)
        np.testing.assert_allclose(_place(later, time), _place(sequence, time), atol=1e-12)
        np.testing.assert_allclose(_velocity(later, time), _velocity_before(sequence, time), atol=1e-4)
        before, after = command_at(sequence, time), command_at(later, time)
        np.testing.assert_allclose(after.cable_tension, before.cable_tension, atol=1e-12)
        np.testing.assert_array_equal(after.T_world_base[:3, :3], before.T_world_base[:3, :3])
        sequence = later


@given(st.floats(0.05, 1.0))
def test_a_move_ends_at_rest_in_its_place_with_its_tension(cut):
    later = advance(_sequence(), cut)
    end = cut + later.move.duration
    for time in (end, end + 0.5):
        np.testing.assert_allclose(_place(later, time), ENDS[1], atol=1e-12)
        np.testing.assert_allclose(command_at(later, time).cable_tension, TENSIONS[1], atol=1e-12)
    np.testing.assert_allclose(_velocity_before(later, end), 0.0, atol=1e-6)


def test_a_move_from_rest_is_the_path_of_least_jerk():
    """Halfway at half time, at 15/8 of the mean speed, without acceleration."""
    sequence = _sequence()
    way = np.array(ENDS[0]) - [0.2, 0.0, 1.1]
    np.testing.assert_allclose(_place(sequence, 0.5), np.array([0.2, 0.0, 1.1]) + way / 2, atol=1e-12)
    np.testing.assert_allclose(_velocity(sequence, 0.5), 15 / 8 * way, atol=1e-6)


@pytest.mark.parametrize(("time", "part"), [(-1.0, 0.0), (0.0, 0.0), (0.25, 0.25), (1.0, 1.0), (9.0, 1.0)])
def test_the_fraction_stays_within_its_bounds(time, part):
    assert fraction(_sequence(), time) == part


def test_raised_tension_stops_at_the_ceiling_and_spares_what_is_done():
    sequence = advance(_sequence(), 1.0)
    raised = raise_tension(sequence, 2.0, 30.0)
    np.testing.assert_array_equal(raised.moves[0].tension, 0.0)
    np.testing.assert_array_equal(raised.moves[1].tension, [0, 30, 30])
    np.testing.assert_array_equal(raised.moves[2].tension, [0, 10, 10])
    np.testing.assert_array_equal(sequence.moves[1].tension, TENSIONS[1])


def test_shifting_what_follows_spares_what_is_under_way():
    sequence, way = advance(_sequence(), 1.0), np.array([0.0, 0.03, 0.0])
    shifted = shift_later(sequence, way)
    for i in (0, 1):
        np.testing.assert_array_equal(shifted.moves[i].position, ENDS[i])
    np.testing.assert_allclose(shifted.moves[2].position, np.array(ENDS[2]) + way)
    assert (shifted.index, shifted.since) == (sequence.index, sequence.since)


def test_one_phase_alone_can_be_shifted():
    sequence = _sequence()
    moves = (*sequence.moves[:2], replace(sequence.moves[2], phase="release"))
    shifted = shift_later(replace(sequence, moves=moves), np.array([0.0, 0.0, 0.1]), ("release",))
    np.testing.assert_array_equal(shifted.moves[1].position, ENDS[1])
    np.testing.assert_allclose(shifted.moves[2].position, np.add(ENDS[2], [0.0, 0.0, 0.1]))


def test_inserted_moves_come_next():
    sequence = _sequence()
    longer = insert_next(sequence, (sequence.moves[2], sequence.moves[1]))
    assert [move.action for move in longer.moves] == ["move 0", "move 2", "move 1", "move 1", "move 2"]
    assert longer.move is sequence.move
