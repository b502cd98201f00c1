"""Opening round a standing object: where the model has the hook, the steps of the base, pressing and righting."""

import functools
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from spiraltrunk.control.messages import CameraObservation, Command, Observation
from spiraltrunk.design import presets
from spiraltrunk.model.kinematics.enclosure import first_wrapped, snug_bend
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.strategies.moves import Move, MoveSequence, begin, tilted_base
from spiraltrunk.strategies.wrap import opening, standing_plan
from spiraltrunk.strategies.wrap.hook_model import find_first, find_hook
from spiraltrunk.strategies.wrap.opening import find_withdrawn, plan_opening, press_down, right
from spiraltrunk.strategies.wrap.standing import WrapHorizontal
from spiraltrunk.strategies.wrap.standing_model import cable_pulls, object_center, section_ends, shut_pull
from spiraltrunk.strategies.wrap.standing_plan import housing_sink

PAPER = presets.PAPER
SHUT = float(shut_pull(PAPER)[0])
VENTRAL = -PAPER.cable_direction[:, 1]
WIDTH, HEIGHT = 0.060, 0.120
AHEAD = np.array([0.0, 1.0, 0.0])


@functools.cache
def touched_down(
    lean: float = 0.0, tilt: float = 1.5, width: float = WIDTH, rise: float = 0.0
) -> tuple[MoveSequence, Observation]:
    """A cylinder that the trunk has lowered to the ground over its place, leaning ahead by ``lean`` [rad].

    It is ``rise`` [m] above the ground.
    """
    shape = parse_object(f"cylinder-{1e3 * width:.0f}")
    scene = SceneOptions(support="ground", orientation="upright", shape=shape, position=(0.43, 0.14, 0.0))
    seen = SimPlant(PAPER, scene).reset()
    moves = WrapHorizontal().init(seen).sequence.moves
    at = next(i for i, move in enumerate(moves) if move.action == "lower")
    rotation, tension = tilted_base(AHEAD, tilt), cable_pulls(PAPER, 1.3 * SHUT, 0.0)
    hook = find_hook(PAPER, width, rotation, 1.3 * SHUT)
    low = seen.task.target.length / 2 * math.cos(lean) + width / 2 * math.sin(lean) + rise
    ground = seen.task.goal.ground
    assert ground is not None
    center = np.array([*seen.task.goal.place[:2], ground + low])
    T_world_base = np.eye(4)
    T_world_base[:3, :3], T_world_base[:3, 3] = rotation, center - hook.center
    axis = np.array([0.0, math.sin(lean), math.cos(lean)])
    look = CameraObservation(time=seen.time, position=center, axis=axis)
    start = Command(T_world_base=T_world_base, cable_tension=tension)
    held = tuple(
        replace(move, position=T_world_base[:3, 3], rotation=rotation) if i == at else move
        for i, move in enumerate(moves)
    )
    sequence = replace(begin(held, seen), index=at, since=seen.time, start=start)
    return sequence, replace(seen, camera=look, cable_tension=tension)


def steps(sequence: MoveSequence) -> list[Move]:
    return [move for move in sequence.moves[sequence.index + 1 :] if move.action == "uncurl"]


def relative_pull(move: Move) -> float:
    return float(move.tension @ VENTRAL) / SHUT


@pytest.mark.parametrize("turn", [0.0, 0.7, -2.1])
def test_a_base_turned_about_the_vertical_turns_the_trunk(turn: float) -> None:
    base, tension = tilted_base(AHEAD, 1.4), cable_pulls(PAPER, 0.5 * SHUT, 0.0)
    about = Rotation.from_rotvec([0.0, 0.0, turn])
    turned = section_ends(PAPER, about.as_matrix() @ base, tension)
    np.testing.assert_allclose(turned, about.apply(section_ends(PAPER, base, tension)), atol=1e-9)


def test_a_base_rolled_half_round_mirrors_the_trunk() -> None:
    base, tension = tilted_base(AHEAD, 1.4), cable_pulls(PAPER, 0.5 * SHUT, 0.0)
    rolled = base @ Rotation.from_rotvec([math.pi, 0.0, 0.0]).as_matrix()
    ends = section_ends(PAPER, base, tension)
    np.testing.assert_allclose(section_ends(PAPER, rolled, tension), ends * [-1.0, 1.0, 1.0], atol=1e-6)


def test_joints_open_from_the_base_on_as_the_pull_falls() -> None:
    firsts = [find_first(PAPER, WIDTH, pull * SHUT) for pull in (1.2, 0.5, 0.3, 0.2, 0.15, 0.1, 0.01)]
    assert firsts[0] == first_wrapped(snug_bend(PAPER, WIDTH))
    assert (np.diff(firsts) >= 0).all()
    assert firsts[-1] == PAPER.n_joint - 1


def test_the_hook_of_a_closed_trunk_is_where_the_wrap_is() -> None:
    tilt, pull = 1.4, 1.2 * SHUT
    center = object_center(PAPER, WIDTH, tilt, cable_pulls(PAPER, pull, 0.0), find_first(PAPER, WIDTH, pull))
    hook = find_hook(PAPER, WIDTH, tilted_base(AHEAD, tilt), pull)
    np.testing.assert_allclose(hook.center[:2], center[:2], atol=1e-9)
    assert np.linalg.norm(hook.normal) == pytest.approx(1.0)
    assert hook.normal[2] > 0.9
    assert hook.lowest < hook.center[2]


def test_a_trunk_that_opens_sags_and_its_hook_tilts_ahead() -> None:
    hooks = [find_hook(PAPER, WIDTH, tilted_base(AHEAD, 1.4), pull * SHUT) for pull in (1.2, 0.7, 0.5, 0.35)]
    assert (np.diff([hook.center[2] for hook in hooks]) < 0).all()
    assert (np.diff([hook.normal[1] for hook in hooks]) > 0).all()


def test_the_pull_falls_in_small_steps_and_the_hook_stays_round_the_object() -> None:
    sequence, seen = touched_down()
    opened = plan_opening(sequence, seen, HEIGHT)
    pulls = [relative_pull(move) for move in steps(opened)]
    assert pulls[-1] == pytest.approx(opening.LAST)
    assert (np.diff(pulls) < 0).all()
    assert np.diff([1.3, *pulls]).min() >= -opening.EASE - 1e-9
    for move in steps(opened):
        assert move.rotation is not None
        hook = find_hook(PAPER, WIDTH, move.rotation, relative_pull(move) * SHUT)
        np.testing.assert_allclose((move.position + hook.center - seen.task.goal.place)[:2], 0.0, atol=1e-5)


@pytest.mark.parametrize(
    ("width", "lean", "rise", "is_soon"),
    [(0.090, 0.0, 0.0, True), (0.120, 0.06, 0.0, True), (0.090, 0.08, 0.0, False), (0.090, 0.0, 0.03, False),
     (WIDTH, 0.0, 0.0, False)],
)  # fmt: skip
def test_the_trunk_springs_open_sooner_round_a_wide_object_that_stands(
    width: float, lean: float, rise: float, is_soon: bool
) -> None:
    sequence, seen = touched_down(lean, width=width, rise=rise)
    pulls = [relative_pull(move) for move in steps(plan_opening(sequence, seen, HEIGHT))]
    loose = opening.CLOSE * float(shut_pull(PAPER)[first_wrapped(snug_bend(PAPER, width))]) / SHUT
    assert pulls[-1] == pytest.approx(opening.LAST_WIDE * loose if is_soon else opening.LAST)
    assert pulls[-1] < loose


@pytest.mark.parametrize("name", ["paper", "spirob-1m"])
def test_a_wide_object_is_never_followed_further_than_a_narrow_one(name: str) -> None:
    design = presets.get(name)
    _, seen = touched_down(width=0.090)
    seen = replace(seen, task=replace(seen.task, design=design))
    assert seen.camera is not None
    lasts = [opening._find_last(seen, seen.camera, share * design.length) for share in (0.12, 0.131, 0.16, 0.19)]
    assert lasts[0] == opening.LAST
    assert min(lasts) >= opening.LAST


def test_the_trunk_springs_open_where_the_last_step_ends() -> None:
    sequence, seen = touched_down()
    opened = plan_opening(sequence, seen, HEIGHT)
    last = steps(opened)[-1]
    for move in opened.moves:
        if move.action == "open":
            np.testing.assert_array_equal(move.position, last.position)
            np.testing.assert_array_equal(move.rotation, last.rotation)
    off = next(move for move in opened.moves if move.action == "draw off")
    assert off.position[2] >= last.position[2]


def find_ways(sequence: MoveSequence, seen: Observation) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Level ways: of the base as it follows the hook, off the object then, and off it as planned, shapes (2,) [m]."""
    opened = plan_opening(sequence, seen, HEIGHT)
    last = steps(opened)[-1].position
    off, away = (next(m.position for m in each.moves if m.action == "draw off") for each in (opened, sequence))
    before = next(move.position for move in sequence.moves if move.action == "open")
    return (last - before)[:2], (off - last)[:2], (away - before)[:2]


def test_the_base_withdraws_by_what_it_did_not_go_back_with_the_hook() -> None:
    aside, off, planned = find_ways(*touched_down())
    whole = float(np.linalg.norm(planned))
    behind = float(aside @ planned) / whole
    assert 0.1 * whole < behind < (1 - opening.LEAST_WITHDRAWAL) * whole
    np.testing.assert_allclose(off, planned * (1 - behind / whole), atol=1e-12)


@pytest.mark.parametrize(
    ("misplaced", "aside", "behind"),
    [
        ([0.0, 0.0, 0.0], [0.01, -0.03, 0.02], 0.03),
        ([0.02, -0.02, 0.3], [0.0, -0.03, 0.0], 0.01),  # The object stands further back, so that less is behind it.
        ([0.0, 0.0, 0.0], [0.0, 0.05, 0.0], 0.0),
        ([0.0, 0.0, 0.0], [0.0, -0.5, 0.0], 0.1 * (1 - opening.LEAST_WITHDRAWAL)),
    ],
)
def test_only_what_leads_away_from_where_the_object_stands_counts_as_withdrawn(
    misplaced: list[float], aside: list[float], behind: float
) -> None:
    way = find_withdrawn(np.array(misplaced), np.array(aside), np.array([0.0, -0.1, 0.04]))
    np.testing.assert_allclose(way, [0.0, -behind, 0.0], atol=1e-12)


def test_where_no_withdrawal_is_planned_none_is_covered() -> None:
    np.testing.assert_array_equal(find_withdrawn(np.zeros(3), np.ones(3), np.array([0.0, 0.0, 0.1])), np.zeros(3))


@pytest.mark.parametrize(
    ("tilt", "lean"),
    [(1.6, 0.2), *(pytest.param(*row, marks=pytest.mark.slow) for row in ((1.6, 0.0), (1.35, 0.2), (1.35, 0.0)))],
)
def test_the_housing_clears_the_ground_and_the_base_turns_little_at_a_step(lean: float, tilt: float) -> None:
    sequence, seen = touched_down(lean, tilt)
    before, ground = tilted_base(AHEAD, tilt), seen.task.goal.ground
    assert ground is not None
    for move in steps(plan_opening(sequence, seen, HEIGHT)):
        assert move.rotation is not None
        sink = housing_sink(PAPER, math.acos(-move.rotation[2, 0]))
        assert move.position[2] - sink >= ground + opening.CLEAR - 1e-9
        assert Rotation.from_matrix(move.rotation @ before.T).magnitude() <= opening.TURN + 1e-9
        before = move.rotation


def test_a_leaning_object_stands_upright_on_its_edge_once_only_the_hook_holds_it() -> None:
    lean = 0.15
    (sequence, seen), (_, straight) = touched_down(lean), touched_down()
    last = steps(plan_opening(sequence, seen, HEIGHT))[-1]
    assert last.rotation is not None
    assert straight.camera is not None
    hook = find_hook(PAPER, WIDTH, last.rotation, relative_pull(last) * SHUT)
    length = seen.task.target.length
    back = length / 2 * math.sin(lean) + WIDTH / 2 * (1 - math.cos(lean))
    expected = seen.task.goal.place + np.array([0.0, -back, 0.0])
    np.testing.assert_allclose((last.position + hook.center - expected)[:2], 0.0, atol=0.012)  # The hook was higher.


def test_without_a_camera_the_plan_is_kept() -> None:
    sequence, seen = touched_down()
    blind = replace(seen, camera=None)
    assert plan_opening(sequence, blind, HEIGHT) is sequence
    assert right(sequence, blind, HEIGHT) is sequence


def during(action_index: int, lean: float = 0.0) -> tuple[MoveSequence, Observation]:
    """The sequence in a step of the opening, the object seen to lean ahead."""
    sequence, seen = touched_down()
    opened = plan_opening(sequence, seen, HEIGHT)
    count = len(steps(opened))
    at = opened.index + 1 + action_index % count
    assert seen.camera is not None
    look = replace(seen.camera, axis=np.array([0.0, math.sin(lean), math.cos(lean)]))
    return replace(opened, index=at), replace(seen, camera=look)


@pytest.mark.parametrize(("load", "sign"), [(1.0, -1), (0.0, -1), (-opening.PRESS, 0), (-3.0, 1)])
def test_the_base_sinks_until_the_object_is_pressed_on_the_ground(load: float, sign: int) -> None:
    sequence, seen = during(3)
    pressed = press_down(sequence, seen, load)
    for before, after in zip(sequence.moves[sequence.index :], pressed.moves[sequence.index :], strict=True):
        way = after.position - before.position
        np.testing.assert_array_equal(way[:2], 0.0)
        is_opening = before.action in ("uncurl", "open")
        assert np.sign(round(way[2], 12)) == (sign if is_opening else 0)
        assert abs(way[2]) <= 2 * opening.PRESS_STEP + 1e-12


def test_the_base_never_sinks_so_far_that_the_housing_meets_the_ground() -> None:
    sequence, seen = during(3)
    for _ in range(2000):
        sequence = press_down(sequence, seen, 5.0)
    ground = seen.task.goal.ground
    assert ground is not None
    for move in sequence.moves[sequence.index :]:
        if move.action in ("uncurl", "open"):
            assert move.rotation is not None
            low = move.position[2] - housing_sink(PAPER, math.acos(-move.rotation[2, 0]))
            assert low == pytest.approx(ground + opening.CLEAR)


def test_a_base_that_points_upwards_stays_so_high_that_the_arm_behind_it_clears_the_ground() -> None:
    sequence, seen = touched_down(tilt=1.9)
    ground, (radius, behind, gap) = seen.task.goal.ground, standing_plan.WRIST
    assert ground is not None
    for move in steps(plan_opening(sequence, seen, HEIGHT)):
        assert move.rotation is not None
        back = -behind * move.rotation[:, 0]
        drop = radius * math.sqrt(1 - move.rotation[2, 0] ** 2)
        assert move.position[2] + back[2] - drop >= ground + gap - 1e-9


def test_a_lean_is_righted_only_once_the_hook_alone_holds() -> None:
    early, seen = during(0, lean=0.1)
    assert right(early, seen, HEIGHT) is early
    late, seen = during(-2, lean=0.1)
    shifted = right(late, seen, HEIGHT)
    way = shifted.moves[late.index + 1].position - late.moves[late.index + 1].position
    assert way[1] < -0.005
    np.testing.assert_allclose(way[[0, 2]], 0.0, atol=1e-12)


def test_once_a_wide_object_stands_that_leaned_as_it_was_set_down_the_trunk_springs_open() -> None:
    sequence, seen = touched_down(0.15, width=0.090)
    opened = plan_opening(sequence, seen, HEIGHT)
    loose = opening._loose_pull(PAPER, 0.090)
    pulls = [relative_pull(move) for move in steps(opened)]
    soon = next(i for i, pull in enumerate(pulls) if pull <= opening.LAST_WIDE * loose)
    assert soon < len(pulls) - 1
    _, upright = touched_down(width=0.090)
    early, late = (replace(opened, index=opened.index + 1 + i) for i in (soon - 1, soon))
    assert steps(right(late, seen, HEIGHT)) != []  # It leans.
    assert steps(right(early, upright, HEIGHT)) != []  # The wrap is too tight.
    ended = right(late, upright, HEIGHT)
    assert steps(ended) == []
    for move in ended.moves[ended.index + 1 :]:
        if move.action == "open":
            np.testing.assert_array_equal(move.position, late.move.position)
            np.testing.assert_array_equal(move.rotation, late.move.rotation)
    planned, left = (next(m for m in each.moves if m.action == "draw off") for each in (opened, ended))
    assert left.rotation is late.move.rotation  # It does not turn on.
    was, last = late.move.position[:2], steps(opened)[-1].position[:2]
    before = planned.position[:2] - last
    along, after = before / np.linalg.norm(before), left.position[:2] - was
    assert after @ along == pytest.approx(
        np.linalg.norm(before) + (last - was) @ along
    )  # The withdrawal's end is kept.
    assert abs(after[0] * along[1] - after[1] * along[0]) < 1e-12


def test_a_narrow_object_that_stands_is_followed_to_the_last_step(monkeypatch: pytest.MonkeyPatch) -> None:
    sequence, seen = touched_down(0.15, width=0.090)
    opened = plan_opening(sequence, seen, HEIGHT)
    soon = opening.LAST_WIDE * opening._loose_pull(PAPER, 0.090)
    first = next(i for i, move in enumerate(steps(opened)) if relative_pull(move) <= soon)
    late, (_, upright) = replace(opened, index=opened.index + 1 + first), touched_down(width=0.090)
    assert steps(right(late, upright, HEIGHT)) == []
    monkeypatch.setattr(opening, "WIDE", 0.2)
    assert len(steps(right(late, upright, HEIGHT))) == len(steps(late)) > 0


@pytest.mark.parametrize("lean", [0.01, 0.1])
def test_it_springs_open_round_an_upright_object_and_rights_another_but_not_for_ever(lean: float) -> None:
    sequence, seen = during(-1, lean=lean)
    added = 0
    while True:
        further = right(sequence, seen, HEIGHT)
        if len(further.moves) == len(sequence.moves):
            break
        added += 1
        assert further.moves[further.index + 1].action == "uncurl"
        sequence = replace(further, index=further.index + 1)
    assert added == (0 if lean < opening.UPRIGHT else opening.RIGHTINGS)
    assert further.moves[sequence.index + 1].action == "open"
