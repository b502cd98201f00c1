"""Static shapes are found where they were put, and gaps where nothing was seen."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.errors import DesignError, TakeError
from spiraltrunk.mocap.signal.segmentation import (
    StillSettings,
    compute_middle,
    compute_speed,
    describe_slowest,
    find_gaps,
    find_stills,
    find_timed,
    summarise_gaps,
)

RATE = 100.0
STILL = StillSettings()


def record(
    levels: list[float], held: float, moved: float, noise: float, seed: int = 0
) -> tuple[np.ndarray, np.ndarray]:
    """Times and three points that go from level to level along a line, and hold each."""
    rng = np.random.default_rng(seed)
    hold, move = round(held * RATE), round(moved * RATE)
    parts = [np.full(hold, levels[0])]
    for before, beyond in pairwise(levels):
        parts += [np.linspace(before, beyond, move + 2)[1:-1], np.full(hold, beyond)]
    way = np.concatenate(parts)
    points = np.zeros((len(way), 3, 3)) + np.arange(3)[:, None] * 0.05
    points[..., 0] += way[:, None]
    return np.arange(len(way)) / RATE, points + rng.normal(0, noise, points.shape)


def test_speed_of_a_steady_motion_is_its_speed():
    points = np.zeros((200, 2, 3))
    points[:, :, 1] = 0.03 * np.arange(200)[:, None] / RATE
    np.testing.assert_allclose(compute_speed(points, RATE, 0.2), 0.03, rtol=1e-9)


@pytest.mark.parametrize("noise", [0.0, 1e-4, 5e-4])
def test_every_hold_is_found(noise):
    levels = [0.0, 0.005, 0.02, 0.01, 0.04]
    time, points = record(levels, 1.0, 0.5, noise)
    stills = find_stills(time, points, RATE, STILL)
    assert len(stills) == len(levels)
    for i, (frames, level) in enumerate(zip(stills, levels, strict=True)):
        assert 1.5 * i - 0.02 <= time[frames[0]] <= time[frames[-1]] <= 1.5 * i + 1.02
        middle = compute_middle(points[frames])
        np.testing.assert_allclose(middle[:, 0] - 0.05 * np.arange(3), level, atol=1e-9 + 0.4 * noise)


def test_a_short_rest_is_no_shape_and_one_disturbance_divides_none():
    time, points = record([0.0, 0.02, 0.04], 0.3, 0.5, 1e-5)
    assert find_stills(time, points, RATE, STILL) == []
    time, points = record([0.0, 0.02], 3.0, 0.5, 1e-5)
    points[100:110] += 0.05
    assert len(find_stills(time, points, RATE, STILL)) == 2


def test_unseen_points_are_left_out():
    time, points = record([0.0, 0.02, 0.04], 1.0, 0.5, 1e-4)
    points[:, 1] = np.nan
    points[20:40, 0] = np.nan
    assert len(find_stills(time, points, RATE, STILL)) == 3
    points[:] = np.nan
    assert find_stills(time, points, RATE, STILL) == []
    assert find_stills(time[:3], points[:3], RATE, STILL) == []


def test_missing_frames_do_not_join_shapes():
    time, points = record([0.0, 0.02], 1.0, 0.1, 1e-5)
    keep = np.r_[0:95, 115:210]
    assert len(find_stills(time[keep], points[keep], RATE, STILL)) == 2


def test_timed_steps_are_found_without_motion():
    time, points = record([0.0, 0.02, 0.02, 0.04], 1.0, 0.5, 1e-5)
    assert len(find_stills(time, points, RATE, STILL)) == 3
    stills = find_timed(time, points, RATE, STILL, (0.0, 1.5, 4))
    assert [round(time[frames[0]] / 1.5) for frames in stills] == [0, 1, 2, 3]
    with pytest.raises(TakeError, match=r"from 6\.00 to 7\.50 s nothing is still"):
        find_timed(time, points, RATE, STILL, (0.0, 1.5, 5))


def test_the_middle_wants_enough_frames():
    points = np.full((10, 2, 3), np.nan)
    points[:4, 0] = [[0, 0, 0], [1, 1, 1], [1, 1, 1], [9, 9, 9]]
    points[:1, 1] = 5
    np.testing.assert_array_equal(compute_middle(points, 3), [[1, 1, 1], [np.nan] * 3])


@pytest.mark.parametrize("wrong", [{"speed": 0.0}, {"window": np.nan}, {"hold": -1.0}, {"same": np.inf}])
def test_settings_are_checked(wrong):
    with pytest.raises(DesignError, match=r"still\."):
        StillSettings(**wrong)


@given(st.lists(st.booleans(), max_size=60))
def test_gaps_cover_exactly_the_long_runs_unseen(seen):
    is_seen, time = np.array(seen, bool), np.arange(len(seen)) / 100.0
    gaps = find_gaps(is_seen, time, 0.055)
    covered = np.zeros(len(seen), bool)
    for begin, end in gaps:
        assert end - begin > 0.055
        inside = (time > begin - 1e-9) & (time < end + 1e-9)
        covered |= inside & ~is_seen
    runs = "".join("1" if value else "0" for value in seen).split("1")
    inner = [len(run) for run in runs]
    long = 0
    for i, run in enumerate(inner):
        edges = (i > 0) + (i < len(inner) - 1)
        long += run if (run - 1 + edges) / 100.0 > 0.055 and run else 0
    assert covered.sum() == long


def test_the_longest_gap_is_told():
    time = np.arange(300) / 100.0
    seen = {"section 3": (time < 1.0) | (time > 2.0), "section 4": np.ones(300, bool)}
    (note,) = summarise_gaps(seen, time)
    assert "1 gap of more than 100 ms in 1 section, none filled; the longest in section 3 from 0.99 to 2.01 s" in note
    assert summarise_gaps({"section 4": seen["section 4"]}, time) == []


def test_the_calmest_stretch_is_the_speed_at_which_something_would_be_still():
    rate, settings = 60.0, StillSettings()
    time = np.arange(300) / rate
    way = np.cumsum(np.where((time > 2.0) & (time < 3.2), 8e-3, 40e-3)) / rate
    points = np.zeros((300, 3, 3))
    points[..., 0] = way[:, None]
    calmest = 8e-3
    assert not find_stills(time, points, rate, replace(settings, speed=calmest * 0.999))
    assert len(find_stills(time, points, rate, replace(settings, speed=calmest * 1.001))) == 1
    assert "5.00 s: the slowest stretch of 0.6 s moves at 8 mm/s" in describe_slowest(time, points, rate, settings)
    assert "too short" in describe_slowest(time[:5], points[:5], rate, settings)
