"""Creep of held things: it is measured in the hold, falls with the hardness of friction, and is told in one line."""

import pytest

from spiraltrunk.workflows.grasp.world import GRIP_FRICTION

LIGHT = 13238
"""A light thing that fingers hold by its upper edge."""


@pytest.fixture
def creep(load_benchmark):
    return load_benchmark("held_creep")


def test_a_line_tells_what_was_held_and_how_fast_it_sank(creep):
    held = [creep.Holding(True, seed > 1, 1e-4 * seed, 0.1) for seed in (1, 2, 3)]
    line = creep.describe(300.0, [*held, creep.Holding(False, False, None, float("nan"))])
    assert "hardness    300: 3 of 4 held, 2 succeed; sinking 0.200 mm/s in the median" in line
    assert line.endswith("0.300 at most; 0.100 s a simulated second")


@pytest.mark.slow
def test_what_falls_where_friction_creeps_is_held_where_it_does_not(creep):
    job = (LIGHT, creep.find_first(LIGHT))
    assert job[1] == "tip-grip"
    soft, hard = (creep.hold(job, hardness=hardness, noslip=0) for hardness in (10.0, GRIP_FRICTION))
    exact = creep.hold(job, hardness=30.0, noslip=10)
    assert not soft.is_held
    assert hard.is_success
    assert exact.is_success
    assert abs(exact.sink) < abs(hard.sink) < 2e-4
