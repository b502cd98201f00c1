"""Wraps of standing objects: what is planned, what is felt, and one whole trial."""

from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.errors import ModelError
from spiraltrunk.plant import Observation
from spiraltrunk.sim.objects import parse_object
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.scene import SceneOptions
from spiraltrunk.strategies.wrap_horizontal import WrapHorizontal
from spiraltrunk.strategies.wrap_standing import StandingState
from spiraltrunk.trial import run_trial

PAPER = presets.PAPER
STRATEGY = WrapHorizontal()


def first_seen(name: str = "cylinder-60") -> Observation:
    """What is seen at the start, beside a standing object."""
    scene = SceneOptions(stage="ground", stance="upright", shape=parse_object(name), position=(0.43, 0.14, 0.0))
    return SimPlant(PAPER, scene).reset()


@pytest.fixture(scope="module")
def start() -> tuple[StandingState, Observation]:
    seen = first_seen()
    return STRATEGY.init(seen), seen


@pytest.mark.parametrize("name", ["cylinder-33", "cylinder-60", "cylinder-120", "cylinder-150", "box-80", "bottle-70"])
def test_the_housing_stays_above_the_ground_in_every_move(name: str) -> None:
    seen = first_seen(name)
    ground, housing = seen.task.goal.ground, PAPER.housing
    assert ground is not None
    for move in STRATEGY.init(seen).progress.moves:
        assert move.rotation is not None
        along = move.rotation[:, 0]
        for back in (housing.neck_length, housing.neck_length + housing.length):
            low = (move.position - back * along)[2] - housing.radius * np.sqrt(1 - along[2] ** 2)
            assert low > ground + 0.01


def test_tension_rises_to_the_grip_and_falls_again(start: tuple[StandingState, Observation]) -> None:
    moves = start[0].progress.moves
    most = [move.tension.max() for move in moves]
    tight = next(i for i, move in enumerate(moves) if move.action == "tighten")
    assert (np.diff(most[1:tight]) >= -1e-9).all()
    assert most[tight] == max(most)
    assert max(most) <= PAPER.cable.tension_max


def test_a_heavier_object_is_gripped_harder() -> None:
    grips = [max(m.tension.max() for m in STRATEGY.init(first_seen(name)).progress.moves)
             for name in ("cylinder-60", "cylinder-60-heavy")]  # fmt: skip
    assert grips[1] > grips[0]


def test_what_is_too_short_for_the_housing_is_refused() -> None:
    with pytest.raises(ModelError, match=r"20 mm tall; allowed: [0-9]+ mm or more"):
        STRATEGY.init(first_seen("disc-80x20"))


def test_the_same_state_and_sight_give_the_same_command(start: tuple[StandingState, Observation]) -> None:
    first, again = (STRATEGY.step(*start) for _ in range(2))
    np.testing.assert_array_equal(first[1].T_world_base, again[1].T_world_base)
    np.testing.assert_array_equal(first[1].cable_tension, again[1].cable_tension)


def touching(start: tuple[StandingState, Observation], lean: float) -> StandingState:
    """Near the end of the sideways move, with the dorsal cable pulled in by ``lean`` [m]."""
    state, seen = start
    at = next(i for i, move in enumerate(state.progress.moves) if move.action == "touch")
    touch = state.progress.moves[at]
    assert touch.rotation is not None
    there = np.eye(4)
    there[:3, :3], there[:3, 3] = touch.rotation, touch.position - [0.01, 0.0, 0.0]
    progress = replace(state.progress, index=at, since=seen.time - 0.01, T_start=there)
    bent = replace(seen, T_world_base=there, cable_pull=np.array([lean, 0.0, 0.0]))
    return STRATEGY.step(replace(state, progress=progress, lean=lean, lean_free=0.0), bent)[0]


def test_a_trunk_that_is_pushed_back_stops_and_curls(start: tuple[StandingState, Observation]) -> None:
    assert touching(start, 0.0).progress.move.action == "touch"
    state = touching(start, 0.003)
    assert state.progress.move.action == "curl"
    shifted, planned = (next(m for m in s.progress.moves if m.action == "curl") for s in (state, start[0]))
    beyond = STRATEGY.options.overshoot * PAPER.length - 0.01
    np.testing.assert_allclose(shifted.position - planned.position, [beyond, 0.0, 0.0], atol=1e-5)
    places = [[m.position for m in s.progress.moves if m.phase == "release"] for s in (state, start[0])]
    np.testing.assert_array_equal(*places)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cylinder-60", "cylinder-90"])
def test_a_standing_cylinder_is_carried_and_stands_again(name: str) -> None:
    trial = run_trial(PAPER, parse_object(name), strategy="wrap-horizontal", seed=1)
    assert trial.verdict.success, trial.verdict.reason
