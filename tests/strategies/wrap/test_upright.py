"""The head turns what it holds upright, rigidly, and no farther than the housing clears the ground."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from spiraltrunk.control.messages import CameraObservation, Command, Observation
from spiraltrunk.design import presets
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.strategies.moves import MoveSequence, begin, command_at
from spiraltrunk.strategies.wrap.set_down import set_down_clear
from spiraltrunk.strategies.wrap.standing import WrapHorizontal
from spiraltrunk.strategies.wrap.standing_plan import housing_sink, plan_moves
from spiraltrunk.strategies.wrap.upright import carry_upright, set_down_upright

PLANE = WrapHorizontal.plane


@pytest.fixture(scope="module")
def held() -> tuple[MoveSequence, Observation]:
    """A cylinder held in the air, at the end of the hold."""
    shape = parse_object("cylinder-60")
    scene = SceneOptions(support="ground", orientation="upright", shape=shape, position=(0.43, 0.14, 0.0))
    seen = SimPlant(presets.PAPER, scene).reset()
    moves = plan_moves(seen, PLANE)
    at = next(i for i, move in enumerate(moves) if move.action == "hold")
    T_base = np.eye(4)
    T_base[:3, :3], T_base[:3, 3] = moves[at].rotation, moves[at].position
    since, start = seen.time - moves[at].duration, Command(T_world_base=T_base, cable_tension=moves[at].tension)
    return replace(begin(moves, seen), index=at, since=since, start=start), seen


def leaning(
    seen: Observation, base: np.ndarray, turn: np.ndarray, below: float = -0.02
) -> tuple[Observation, np.ndarray]:
    """The object seen beside the base, leaning by the rotation vector ``turn`` [rad], and its axis."""
    axis = Rotation.from_rotvec(turn).apply([0.0, 0.0, 1.0])
    look = CameraObservation(time=seen.time, position=base + np.array([0.08, 0.05, -below]), axis=axis)
    return replace(seen, camera=look), axis


@pytest.mark.parametrize("turn", [[0.1, 0.0, 0.0], [-0.2, 0.1, 0.0], [0.0, -0.3, 0.0]])
def test_it_is_turned_about_itself_until_it_stands(held: tuple[MoveSequence, Observation], turn: list[float]) -> None:
    sequence, seen = held
    at = next(i for i, move in enumerate(sequence.moves) if move.action == "try")
    sequence = replace(sequence, index=at)
    now = command_at(sequence, seen.time).T_world_base
    seen, axis = leaning(seen, now[:3, 3], np.array(turn), below=0.3)  # The housing is far above the ground.
    assert seen.camera is not None
    level, before = carry_upright(sequence, seen, PLANE.ground_gap).moves[at + 1], sequence.moves[at]
    assert level.rotation is not None
    turned = level.rotation @ now[:3, :3].T
    np.testing.assert_allclose(turned @ axis, [0.0, 0.0, 1.0], atol=1e-9)
    np.testing.assert_allclose(np.arccos((np.trace(turned) - 1) / 2), np.linalg.norm(turn), atol=1e-7)
    np.testing.assert_allclose(level.position - seen.camera.position, turned @ (before.position - seen.camera.position))


@pytest.mark.parametrize("turn", [[0.1, 0.0, 0.0], [0.4, 0.0, 0.0], [-0.4, 0.2, 0.0]])
def test_it_is_set_down_over_its_place_and_the_housing_stays_off_the_ground(
    held: tuple[MoveSequence, Observation], turn: list[float]
) -> None:
    sequence, seen = held
    base = command_at(sequence, seen.time).T_world_base
    seen, _ = leaning(seen, base[:3, 3], np.array(turn))
    assert seen.camera is not None
    moves = set_down_clear(sequence, seen, PLANE.ground_gap).moves
    lower = next(move for move in moves if move.action == "lower")
    assert lower.rotation is not None
    to_base = lower.rotation @ base[:3, :3].T @ (base[:3, 3] - seen.camera.position)
    np.testing.assert_allclose((lower.position - to_base)[:2], seen.task.goal.place[:2], atol=1e-9)
    tilt = float(np.arccos(-lower.rotation[2, 0]))
    ground = seen.task.goal.ground
    assert ground is not None
    assert lower.position[2] - housing_sink(presets.PAPER, tilt) > ground + PLANE.ground_gap / 2 - 1e-9


def test_without_a_camera_nothing_is_turned(held: tuple[MoveSequence, Observation]) -> None:
    sequence, seen = held
    blind = replace(seen, camera=None)
    assert carry_upright(sequence, blind, PLANE.ground_gap) is sequence
    assert set_down_upright(sequence, blind, PLANE.ground_gap) is sequence


@pytest.mark.parametrize(("above", "bows"), [(-0.02, False), (0.005, True)])
def test_the_head_bows_where_the_housing_would_keep_the_object_off_the_ground(
    held: tuple[MoveSequence, Observation], above: float, bows: bool
) -> None:
    sequence, seen = held
    base = command_at(sequence, seen.time).T_world_base
    seen, _ = leaning(seen, base[:3, 3], np.zeros(3), below=-above)
    lower = next(move for move in set_down_upright(sequence, seen, PLANE.ground_gap).moves if move.action == "lower")
    assert lower.rotation is not None
    turned = lower.rotation @ base[:3, :3].T
    angle = float(np.degrees(np.arccos(min(1.0, (np.trace(turned) - 1) / 2))))
    assert (0.9 < angle < 12.1) if bows else angle < 1e-6, angle
    assert seen.camera is not None
    over = float((turned @ (base[:3, 3] - seen.camera.position))[2])  # Of the base over the object's centre.
    tilt = float(np.arccos(-lower.rotation[2, 0]))
    lowest = housing_sink(presets.PAPER, tilt) + PLANE.ground_gap / 2
    assert seen.task.target.length / 2 + over >= lowest - 1e-9
