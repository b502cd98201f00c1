"""Durations of moves: the peaks of minimum-jerk paths, and the sway of the hanging trunk."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from spiraltrunk.control.messages import Command
from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.rules import GRAVITY, design_from_rules
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.robot.trunk import section_name
from spiraltrunk.strategies.moves import Move, MoveSequence, base_position, base_velocity
from spiraltrunk.strategies.timing import (
    ACCELERATION,
    LEAST_TIME,
    LENGTH,
    SPEED,
    still_time,
    stretch,
    sway_period,
    travel_time,
)
from spiraltrunk.strategies.wrap.hung_plan import touch_speed
from spiraltrunk.strategies.wrap.standing_plan import TIMES, move_time


def _move(way, duration):
    move = Move(phase="reach", action="go", duration=duration, position=np.asarray(way, float), tension=np.zeros(3))
    start = Command(T_world_base=np.eye(4), cable_tension=np.zeros(3))
    return MoveSequence(moves=(move,), index=0, since=0.0, start=start, velocity=np.zeros(3))


@pytest.mark.parametrize("distance", [0.02, 0.2, 0.6])
def test_a_move_reaches_its_greatest_speed_or_acceleration_and_passes_neither(distance):
    way = np.array([0.0, 0.6, -0.8]) * distance
    duration = travel_time(way)
    sequence, times = _move(way, duration), np.linspace(0.0, duration, 4001)
    place = np.array([base_position(sequence, time) for time in times])
    velocity = np.gradient(place, times, axis=0)
    speed = np.linalg.norm(velocity, axis=1).max()
    acceleration = np.linalg.norm(np.gradient(velocity, times, axis=0)[2:-2], axis=1).max()
    assert max(speed / SPEED, acceleration / ACCELERATION) == pytest.approx(1.0, rel=1e-3)


def test_no_way_takes_the_least_time():
    assert travel_time(np.zeros(3)) == LEAST_TIME


def test_the_velocity_of_a_move_that_begins_is_its_initial_one():
    sequence = replace(_move([0.1, 0.0, 0.0], 1.0), velocity=np.array([0.0, 0.0, -0.2]))
    np.testing.assert_array_equal(base_velocity(sequence, 0.0), sequence.velocity)
    np.testing.assert_allclose(base_velocity(sequence, 0.01), sequence.velocity, atol=2e-3)


def test_the_trunk_hangs_still_after_a_level_move_of_still_time_and_sways_with_its_period_after_a_faster_one():
    way = np.array([0.0, 0.17, 0.0])
    calm, hasty = (_tip_sway(way, duration) for duration in (still_time(PAPER, way), 0.8))
    assert np.abs(calm[10:]).max() < 0.04 * way[1]  # Once the arm has followed its commands.
    assert np.abs(hasty).max() > 0.3 * way[1]
    crossings = np.flatnonzero(np.diff(np.sign(hasty)) != 0)
    period = 2 * 0.02 * np.diff(crossings).mean()
    assert period == pytest.approx(sway_period(PAPER), rel=0.15)


def test_a_load_at_the_tip_makes_the_sway_slower_up_to_that_of_a_pendulum_of_the_trunks_length():
    light, medium, heavy = (sway_period(PAPER, load) for load in (0.0, 0.1, 1e6))
    assert light < medium < heavy
    assert heavy == pytest.approx(2 * math.pi * math.sqrt(PAPER.length / GRAVITY), rel=1e-6)
    assert still_time(PAPER, np.zeros(3), 0.1) / still_time(PAPER, np.zeros(3)) == pytest.approx(medium / light)


def test_moves_of_a_long_trunk_last_longer_and_it_is_set_down_more_slowly():
    long, short = (design_from_rules(arm_radius=radius) for radius in (0.055, 0.036))
    assert stretch(PAPER) == stretch(short) == 1.0
    assert stretch(long) == pytest.approx(long.length / LENGTH)
    assert move_time(PAPER, "turn") == TIMES["turn"]
    assert move_time(long, "lift") == pytest.approx(TIMES["lift"] * stretch(long))
    assert move_time(long, "turn") > 1.5 * move_time(long, "lift") / TIMES["lift"] * TIMES["turn"]
    assert touch_speed(long) == pytest.approx(touch_speed(PAPER) / stretch(long) ** 4)


def _tip_sway(way, duration):
    """Displacement of the tip from below the base along the way in 1.6 s after a move [m]."""
    plant = SimPlant(PAPER)
    start = plant.reset().T_world_base
    tip = mujoco.mj_name2id(plant.model, mujoco.mjtObj.mjOBJ_BODY, section_name(PAPER.n_section - 1))
    rest, sway, frame = plant.data.xpos[tip] - start[:3, 3], [], start.copy()
    for step in range(round((duration + 1.6) / plant.control_period)):
        s = min(1.0, (step + 1) * plant.control_period / duration)
        frame[:3, 3] = start[:3, 3] + s**3 * (10 - 15 * s + 6 * s**2) * way
        base = plant.step(Command(T_world_base=frame.copy(), cable_tension=np.zeros(3))).T_world_base
        if s == 1.0:
            sway.append(float((plant.data.xpos[tip] - base[:3, 3] - rest) @ way) / float(np.linalg.norm(way)))
    return np.array(sway)
