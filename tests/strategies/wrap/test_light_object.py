"""Light objects: below what the arm feels, a camera tells whether the object is borne."""

from __future__ import annotations

import functools
import math
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.control.messages import CameraObservation, Observation
from spiraltrunk.design import presets
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.strategies.moves import MoveSequence
from spiraltrunk.strategies.wrap.attempts import may_rise, rise_further
from spiraltrunk.strategies.wrap.light_object import HIGH, OFF_GROUND, is_off_ground, is_too_light
from spiraltrunk.strategies.wrap.standing import RETRIES, StandingState, WrapHorizontal

STRATEGY = WrapHorizontal()
TALL, LOW = "cylinder:diameter_mm=60,height_mm=180", "cylinder:diameter_mm=50,height_mm=90"


@functools.cache
def first_seen(size: str) -> Observation:
    """What is seen at the start, beside a standing cylinder."""
    shape = parse_object(f"{size},mass_g=100")
    scene = SceneOptions(support="ground", orientation="upright", shape=shape, position=(0.43, 0.14, 0.0))
    return SimPlant(presets.PAPER, scene).reset()


def seen_at(rise: float, lean: float = 0.0, mass: int = 30, size: str = TALL) -> Observation:
    """What is seen of a cylinder of so many grams that has risen by so much and leans."""
    first = first_seen(size)
    target = replace(first.task.target, mass=1e-3 * mass)
    first = replace(first, task=replace(first.task, target=target))
    axis = np.array([math.sin(lean), 0.0, math.cos(lean)])
    place = first.task.target.position + np.array([0.0, 0.0, rise])
    return replace(first, camera=CameraObservation(time=first.time, position=place, axis=axis))


def at_the_end_of(action: str, seen: Observation, *, load: float) -> StandingState:
    """The state at the end of an action, after all rises and retries, in which the arm measured a load [N]."""
    state = STRATEGY.init(replace(seen, camera=None))
    at = next(i for i, move in enumerate(state.sequence.moves) if move.action == action)
    sequence: MoveSequence = replace(state.sequence, index=at)
    while action == "try" and may_rise(sequence):
        sequence = replace(rise_further(sequence), index=sequence.index + 1)
    sequence = replace(sequence, since=seen.time - sequence.move.duration - 1e-9)
    return replace(state, sequence=sequence, weight_empty=state.weight - load, retries=RETRIES)


@pytest.mark.parametrize(("mass", "is_light"), [(27, True), (50, True), (52, False), (100, False)])
def test_the_arm_feels_what_weighs_more_than_51_g(mass: int, is_light: bool) -> None:
    assert is_too_light(seen_at(0.0, mass=mass)) is is_light
    assert not is_too_light(replace(seen_at(0.0, mass=mass), camera=None))


@pytest.mark.parametrize("lean", [0.0, 0.2, -0.5, math.pi / 2])
def test_an_object_is_off_the_ground_where_its_low_edge_is(lean: float) -> None:
    edge = 0.09 * math.cos(lean) + 0.03 * abs(math.sin(lean)) - 0.09
    stood = float(seen_at(0.0).task.target.position[2])
    assert not is_off_ground(seen_at(edge + OFF_GROUND - 1e-4, lean), stood)
    assert is_off_ground(seen_at(edge + OFF_GROUND + 1e-4, lean), stood)


@pytest.mark.parametrize("size", [TALL, LOW])
@pytest.mark.parametrize("action", ["try", "lift"])
def test_a_light_object_that_is_seen_to_rise_is_carried_on_whatever_the_arm_feels(action: str, size: str) -> None:
    seen = seen_at(0.012, size=size)
    state, _ = STRATEGY.step(at_the_end_of(action, seen, load=0.0), seen)
    assert state.gave_up is None
    assert state.sequence.move.action == {"try": "level", "lift": "carry"}[action]


@pytest.mark.parametrize("action", ["try", "lift"])
def test_a_light_object_that_stays_on_the_ground_is_given_up_whatever_the_arm_feels(action: str) -> None:
    seen = seen_at(0.0)
    state, _ = STRATEGY.step(at_the_end_of(action, seen, load=seen.task.target.mass * GRAVITY), seen)
    assert state.gave_up == "nothing was lifted: the camera sees the object on the ground"


def test_a_heavier_object_is_judged_by_the_arm() -> None:
    seen = seen_at(0.012, mass=60)
    state, _ = STRATEGY.step(at_the_end_of("try", seen, load=0.0), seen)
    assert state.gave_up == "nothing was lifted: the arm feels no load"


@pytest.mark.parametrize(("rise", "gave_up"), [(HIGH + 0.01, None), (HIGH - 0.01, "the arm feels no load")])
def test_what_the_arm_does_not_feel_is_carried_on_where_it_is_seen_high_up(rise: float, gave_up: str | None) -> None:
    seen = seen_at(rise, mass=70)
    state, _ = STRATEGY.step(at_the_end_of("lift", seen, load=0.0), seen)
    assert state.gave_up == (gave_up and f"nothing was lifted: {gave_up}")


@pytest.mark.parametrize(("rise", "action"), [(0.02, "lower"), (0.0, "uncurl")])
def test_a_light_object_is_let_go_where_it_is_seen_on_the_ground(rise: float, action: str) -> None:
    seen = seen_at(rise)
    state = at_the_end_of("lower", seen, load=0.0)
    state = replace(state, sequence=replace(state.sequence, since=seen.time - 1.0))
    assert STRATEGY.sense(state, seen).sequence.move.action == action
