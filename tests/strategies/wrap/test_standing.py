"""Wraps of standing objects: what is planned, what is felt, and one whole trial."""

import functools
import math
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.control.messages import CameraObservation, Command, Observation
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.design import presets
from spiraltrunk.design.rules import design_from_rules
from spiraltrunk.errors import ModelError
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.strategies import resting
from spiraltrunk.strategies.moves import Move, tilted_base
from spiraltrunk.strategies.wrap import attempts, distal_plan, standing, standing_plan
from spiraltrunk.strategies.wrap.attempts import CUT, SAG_MOST, lift_further
from spiraltrunk.strategies.wrap.standing import (
    StandingState,
    StandingWrap,
    WrapHorizontal,
    WrapOblique,
    WrapObliqueLow,
)
from spiraltrunk.strategies.wrap.standing_model import (
    cable_pulls,
    curl_tilt,
    object_center,
    shut_pull,
    wrapped_width,
)
from spiraltrunk.strategies.wrap.standing_plan import TEST
from spiraltrunk.strategies.wrap.unsteady import STEADY, push_that_topples
from spiraltrunk.workflows.grasp.trial import run_trial

PAPER = presets.PAPER
STRATEGY = WrapHorizontal()


@functools.cache
def first_seen(name: str = "cylinder-60") -> Observation:
    """What is seen at the start, beside a standing object."""
    scene = SceneOptions(support="ground", orientation="upright", shape=parse_object(name), position=(0.43, 0.14, 0.0))
    return SimPlant(PAPER, scene).reset()


@pytest.fixture(scope="module")
def start() -> tuple[StandingState, Observation]:
    seen = first_seen()
    return STRATEGY.init(seen), seen


@pytest.mark.parametrize(
    ("name", "strategy"),
    [
        *(
            (name, STRATEGY)
            for name in ("cylinder-33", "cylinder-60", "cylinder-120", "cylinder-150", "box-80", "bottle-70")
        ),
        *((name, WrapOblique()) for name in ("cylinder-60", "cylinder-150")),
        *((name, WrapObliqueLow()) for name in ("cylinder-60", "bottle-70")),
    ],
)
def test_the_housing_stays_above_the_ground_in_every_move(name: str, strategy: StandingWrap) -> None:
    seen = first_seen(name)
    ground, housing = seen.task.goal.ground, PAPER.housing
    assert ground is not None
    for move in strategy.init(seen).sequence.moves:
        assert move.rotation is not None
        along = move.rotation[:, 0]
        for back in (housing.neck_length, housing.neck_length + housing.length):
            low = (move.position - back * along)[2] - housing.radius * np.sqrt(1 - along[2] ** 2)
            assert low > ground + 0.01


def test_the_plan_has_every_milestone_in_order(start: tuple[StandingState, Observation]) -> None:
    planned = dict.fromkeys(move.milestone for move in start[0].sequence.moves if move.milestone is not None)
    assert list(planned) == [milestone for milestone in Milestone if milestone is not Milestone.PUSHED]


def test_tension_rises_to_the_grip_and_falls_again(start: tuple[StandingState, Observation]) -> None:
    moves = start[0].sequence.moves
    most = [move.tension.max() for move in moves]
    tight = next(i for i, move in enumerate(moves) if move.action == "tighten")
    assert (np.diff(most[1:tight]) >= -1e-9).all()
    assert most[tight] == max(most)
    assert max(most) <= PAPER.cable.tension_max


def test_a_heavier_object_is_gripped_harder() -> None:
    grips = [max(m.tension.max() for m in STRATEGY.init(first_seen(name)).sequence.moves)
             for name in ("cylinder-60", "cylinder-60-heavy")]  # fmt: skip
    assert grips[1] > grips[0]


def plan_beside_cylinder(x_mm: int, y_mm: int, z_mm: int) -> tuple[list[Move], list[Move]]:
    """Moves for a box, and for the cylinder whose girth, by its profile, is that of the box."""
    round_one = first_seen().task.target
    girth_mm = 2 * (x_mm + y_mm) * round_one.width / wrapped_width(round_one)
    names = (
        f"box:x_mm={x_mm},y_mm={y_mm},z_mm={z_mm},mass_g=300",
        f"cylinder:diameter_mm={girth_mm / np.pi:.9f},height_mm={z_mm},mass_g=300",
    )
    box, cylinder = (list(STRATEGY.init(_untold(first_seen(name))).sequence.moves) for name in names)
    return box, cylinder


def _untold(seen: Observation) -> Observation:
    """The observation of an object whose yaw is unknown, which is approached from ahead."""
    return replace(seen, task=replace(seen.task, target=replace(seen.task.target, side_yaw=None)))


def assert_alike(moves: list[Move], others: list[Move]) -> None:
    for one, other in zip(moves, others, strict=True):
        np.testing.assert_allclose(one.position, other.position, atol=1e-6)
        np.testing.assert_allclose(one.tension, other.tension, atol=1e-6)


def test_a_box_is_wrapped_as_the_cylinder_of_the_same_girth() -> None:
    assert_alike(*plan_beside_cylinder(80, 80, 200))


def test_a_flat_box_is_wrapped_as_the_cylinder_of_the_same_girth_and_not_of_a_square_one() -> None:
    moves = plan_beside_cylinder(100, 50, 230)
    assert_alike(*([move for move in part if move.action == "curl"] for part in moves))


def test_the_lift_makes_up_for_what_the_object_has_risen_too_little(start: tuple[StandingState, Observation]) -> None:
    state, seen = start
    moves = state.sequence.moves
    at = next(i for i, move in enumerate(moves) if move.action == "steady")
    sequence = replace(state.sequence, index=at)
    for risen, more in ((TEST, 0.0), (TEST - 0.008, 0.008), (-0.005, SAG_MOST), (2 * TEST, 0.0)):
        place = np.array([0.4, 0.1, state.stood + risen])
        look = CameraObservation(time=seen.time, position=place, axis=np.array([0.0, 0.0, 1.0]))
        higher = lift_further(sequence, replace(seen, camera=look), state.stood).moves
        for before, after in zip(moves, higher, strict=True):
            rise = CUT + more if before.action in ("lift", "carry", "hold") else 0.0
            np.testing.assert_allclose(after.position - before.position, [0.0, 0.0, rise], atol=1e-12)


def test_the_closed_curl_has_the_object_where_the_model_says(start: tuple[StandingState, Observation]) -> None:
    state, seen = start
    target = seen.task.target
    last = next(move for move in state.sequence.moves if move.action == "tighten")
    curl = [move for move in state.sequence.moves if move.action == "curl"][-1]
    assert last.rotation is not None
    tilt = float(np.arccos(-last.rotation[2, 0]))
    aside, ahead, _ = object_center(PAPER, target.width, tilt, curl.tension)
    side = state.side
    forward = np.cross([0.0, 0.0, 1.0], side)
    way = (target.position - last.position) * [1.0, 1.0, 0.0]
    np.testing.assert_allclose([way @ side, way @ forward], [aside, ahead], atol=0.004)  # As far as a look is off.


def test_what_topples_early_is_wrapped_above_its_middle_and_all_else_low_down() -> None:
    lower = WrapObliqueLow()
    lower.plane = replace(lower.plane, slender_height=0.0)
    for name, is_raised in (("cylinder-60", True), ("box-60", True), ("bottle-70", False), ("cylinder-90", False)):
        heights = [
            next(m for m in one.init(first_seen(name)).sequence.moves if m.action == "tighten").position[2]
            for one in (WrapObliqueLow(), lower)
        ]
        assert (heights[0] > heights[1] + 0.01) == is_raised, name


def test_what_is_too_short_for_the_housing_is_refused() -> None:
    with pytest.raises(ModelError, match=r"20 mm tall; allowed: [0-9]+ mm or more"):
        STRATEGY.init(first_seen("disc-80x20"))


@pytest.mark.parametrize(
    ("diameter_mm", "height_mm", "is_distal"), [(80, 152, False), (80, 144, True), (100, 144, False), (100, 136, True)]
)
def test_narrow_things_are_wrapped_in_full_only_well_below_their_rim(
    diameter_mm: int, height_mm: int, *, is_distal: bool
) -> None:
    seen = first_seen(f"cylinder:diameter_mm={diameter_mm},height_mm={height_mm},mass_g=200")
    assert WrapObliqueLow().init(seen).is_distal is is_distal


def test_a_narrow_thing_is_wrapped_near_its_rim_where_no_distal_wrap_can_be_planned(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refuse(observation: Observation, plane: standing_plan.WrapPlane) -> tuple[Move, ...]:
        raise ModelError("no distal wrap")

    monkeypatch.setattr(distal_plan, "plan_distal_moves", refuse)
    assert not WrapObliqueLow().init(first_seen("cylinder:diameter_mm=80,height_mm=144,mass_g=200")).is_distal
    with pytest.raises(ModelError, match="no distal wrap"):
        WrapObliqueLow().init(first_seen("cylinder:diameter_mm=80,height_mm=110,mass_g=200"))


def test_the_end_waits_until_what_rocks_is_seen_still(start: tuple[StandingState, Observation]) -> None:
    state, seen = at_the_end_of(start, "leave", 0.0)

    def look(state: StandingState, time: float, lean: float) -> StandingState:
        axis = np.array([math.sin(lean), 0.0, math.cos(lean)])
        camera = CameraObservation(time=time, position=seen.task.goal.place, axis=axis)
        later = replace(seen, time=time + 0.01, camera=camera)
        return STRATEGY.step(replace(state, sequence=replace(state.sequence, since=time - 9.0)), later)[0]

    state = look(state, seen.time, 0.0)
    assert state.sequence.move.action == "rest"
    assert look(state, seen.time + 0.5, 0.0).is_done  # It stands still at once.
    leans, time = [0.02, 0.02, 0.0, 0.0, 0.0], seen.time
    for lean in leans:  # Between the first and the second it seems to stand still.
        assert not state.is_done
        time += 0.5
        state = look(state, time, lean)
    assert state.is_done
    again = look(at_the_end_of(start, "leave", 0.0)[0], seen.time, 0.0)
    assert not look(again, seen.time, 0.0).is_done  # The camera has not looked since.
    assert look(again, seen.time + 0.5, 1.5).is_done  # What has toppled is not waited for.
    state, time = look(at_the_end_of(start, "leave", 0.0)[0], seen.time, 0.0), seen.time
    for i in range(resting.MOST_RESTS):  # What never stands still is left in the end.
        assert not state.is_done
        time += 0.5
        state = look(state, time, 0.06 * (i % 2 - 0.5))
    assert state.is_done


def test_the_same_state_and_sight_give_the_same_command(start: tuple[StandingState, Observation]) -> None:
    first, again = (STRATEGY.step(*start) for _ in range(2))
    np.testing.assert_array_equal(first[1].T_world_base, again[1].T_world_base)
    np.testing.assert_array_equal(first[1].cable_tension, again[1].cable_tension)


def touching(start: tuple[StandingState, Observation], lean: float, before: float = 0.01) -> StandingState:
    """At a distance before the end of the sideways move [m], with the dorsal cable pulled in by ``lean`` [m]."""
    state, seen = start
    at = next(i for i, move in enumerate(state.sequence.moves) if move.action == "touch")
    touch = state.sequence.moves[at]
    assert touch.rotation is not None
    there = np.eye(4)
    there[:3, :3], there[:3, 3] = touch.rotation, touch.position - [before, 0.0, 0.0]
    sequence = replace(
        state.sequence, index=at, since=seen.time - 0.01, start=Command(T_world_base=there, cable_tension=touch.tension)
    )
    bent = replace(seen, T_world_base=there, cable_pull=np.array([lean, 0.0, 0.0]))
    return STRATEGY.step(replace(state, sequence=sequence, lean=lean, lean_free=0.0), bent)[0]


def test_a_trunk_that_is_pushed_back_stops_and_curls(start: tuple[StandingState, Observation]) -> None:
    assert touching(start, 0.0).sequence.move.action == "touch"
    state = touching(start, 0.003)
    assert state.sequence.move.action == "curl"
    shifted, planned = (next(m for m in s.sequence.moves if m.action == "curl") for s in (state, start[0]))
    beyond = (standing_plan.OVERSHOOT - standing.RELIEF) * PAPER.length - 0.01
    np.testing.assert_allclose(shifted.position - planned.position, [beyond, 0.0, 0.0], atol=1e-5)
    places = [[m.position for m in s.sequence.moves if m.phase == "release"] for s in (state, start[0])]
    np.testing.assert_array_equal(*places)


def test_what_topples_easily_is_not_touched_where_a_camera_sees_it() -> None:
    steady, blind = (first_seen(f"cylinder:diameter_mm=60,height_mm=200,mass_g={mass}") for mass in (400, 60))
    assert [push_that_topples(seen.task.target) < STEADY for seen in (steady, blind)] == [False, True]
    light = look_at(blind)
    assert [STRATEGY.init(seen).is_unsteady for seen in (look_at(steady), blind, light)] == [False, False, True]
    state = touching((STRATEGY.init(light), light), 0.003, before=0.0)
    assert state.sequence.move.action == "touch"  # Though it leans, until the move ends.
    moves = STRATEGY.init(light).sequence.moves
    touch, near = (next(move for move in moves if move.action == action) for action in ("touch", "near"))
    way = np.linalg.norm(touch.position - near.position)  # To where the object is expected, and no further.
    np.testing.assert_allclose(way, standing_plan.NEAR * PAPER.length, atol=1e-9)
    ended = replace(state, sequence=replace(state.sequence, since=light.time - touch.duration))
    after = STRATEGY.step(ended, light)[0].sequence
    assert after.move.action == "curl"
    planned = next(move for move in moves if move.action == "curl")
    np.testing.assert_array_equal(after.move.position, planned.position)


def look_at(seen: Observation) -> Observation:
    """The same where a camera sees the object at its place."""
    target = seen.task.target
    return replace(seen, camera=CameraObservation(time=seen.time, position=target.position, axis=target.axis))


def test_the_trunk_springs_open_where_it_stands(start: tuple[StandingState, Observation]) -> None:
    moves = start[0].sequence.moves
    at = next(i for i, move in enumerate(moves) if move.action == "open")
    before, opened = moves[at - 1], moves[at]
    assert before.tension.max() > standing_plan.SPRING * shut_pull(PAPER)[0] * 0.99
    more = standing_plan.OPENED_TAIL / standing_plan.TAIL
    np.testing.assert_allclose(opened.tension, more * moves[0].tension)  # The tail's alone, higher than in the reach.
    assert opened.duration < 0.1
    np.testing.assert_array_equal(opened.position, before.position)
    np.testing.assert_array_equal(opened.rotation, before.rotation)


def test_cables_are_equal_before_a_falling_plane_opens() -> None:
    moves = WrapOblique().init(first_seen()).sequence.moves
    ventral = PAPER.cable_direction[:, 1] < 0
    spread = {action: np.ptp(next(m for m in moves if m.action == action).tension[ventral])
              for action in ("tighten", "level", "lower", "uncurl")}  # fmt: skip
    assert spread["tighten"] > 1.0
    assert max(spread["level"], spread["lower"], spread["uncurl"]) < 1e-6


def at_the_end_of(
    start: tuple[StandingState, Observation], action: str, load: float
) -> tuple[StandingState, Observation]:
    """The last instant of an action, with part ``load`` of the object's weight on the trunk's base."""
    state, seen = start
    at = next(i for i, move in enumerate(state.sequence.moves) if move.action == action)
    move = state.sequence.moves[at]
    begun = Command(T_world_base=seen.T_world_base, cable_tension=move.tension)
    sequence = replace(state.sequence, index=at, since=seen.time - move.duration, start=begun)
    weight = load * 9.80665 * seen.task.target.mass
    pull = np.array([-0.1, 0.05, 0.06])
    now = replace(seen, base_force=np.array([0.0, 0.0, -weight]), cable_pull=pull, cable_tension=move.tension)
    return replace(state, sequence=sequence, weight=weight, weight_empty=0.0, pull=pull), now


def test_what_is_carried_is_held_by_length_with_the_dorsal_cable_taut(
    start: tuple[StandingState, Observation],
) -> None:
    state, seen = at_the_end_of(start, "steady", 1.0)
    state, _ = STRATEGY.step(state, seen)
    lift = state.sequence.move
    assert lift.action == "lift"
    assert lift.pull is not None
    assert lift.tension[0] == 1.0
    assert lift.tension[1:] == pytest.approx(0.95 * PAPER.cable.tension_max)
    np.testing.assert_allclose(lift.pull[1:], [0.05, 0.06] + 5e-5 * state.tight[1:])
    lower = next(move for move in state.sequence.moves if move.action == "lower")
    assert lower.pull is None
    slipped, _ = STRATEGY.step(replace(state, pull=seen.cable_pull - 0.01), seen)
    np.testing.assert_array_equal(slipped.sequence.move.pull, lift.pull)  # Nothing is paid out.
    settled, _ = STRATEGY.step(replace(state, pull=seen.cable_pull + 0.01), seen)
    assert settled.sequence.move.pull is not None
    assert (settled.sequence.move.pull[1:] > lift.pull[1:] + 0.005).all()


def test_the_head_rights_what_still_leans_once_the_cables_are_equal(start: tuple[StandingState, Observation]) -> None:
    turned = {}
    for action in ("try", "level"):
        state, seen = at_the_end_of(start, action, 1.0)
        axis = np.array([0.0, 0.1, 1.0]) / np.sqrt(1.01)
        planned, base = state.sequence.move.rotation, state.sequence.move.position
        look = CameraObservation(time=seen.time, position=base + np.array([0.08, 0.05, -0.3]), axis=axis)
        state, _ = STRATEGY.step(state, replace(seen, camera=look))
        assert state.sequence.move.rotation is not None
        assert planned is not None
        turned[action] = np.abs(state.sequence.move.rotation - planned).max()
    assert turned["try"] == 0.0
    assert turned["level"] > 0.05


def test_a_falling_plane_is_wrapped_higher_where_its_base_will_sink(monkeypatch: pytest.MonkeyPatch) -> None:
    height, tilt, usual, low = [], [], standing_plan.SAG, WrapObliqueLow()
    low.plane = replace(low.plane, slender_height=0.0)
    for sag in (0.0, usual):
        monkeypatch.setattr(standing_plan, "SAG", sag)
        moves = low.init(first_seen()).sequence.moves
        ends = [next(move for move in moves if move.action == action) for action in ("touch", "tighten")]
        tilt = [np.arccos(-move.rotation[2, 0]) for move in ends if move.rotation is not None]
        height.append(ends[1].position[2])
    assert tilt[0] - tilt[1] > np.radians(10)
    assert height[1] - height[0] == pytest.approx(usual * PAPER.length * (tilt[0] - tilt[1]))


@pytest.mark.parametrize("ahead", [0.02, -0.02])
@pytest.mark.parametrize("tilt_deg", [60, 84, 104, 130])
def test_the_gap_to_the_housing_is_that_of_its_surface(tilt_deg: float, ahead: float) -> None:
    tilt, housing, center = np.radians(tilt_deg), PAPER.housing, np.array([0.09, ahead, -0.1])
    rotation = tilted_base(np.array([0.0, 1.0, 0.0]), tilt)
    turn, along = np.radians(np.arange(0, 360, 1)), np.linspace(0.0, housing.length, 23) + housing.neck_length
    x, y, z = rotation.T
    rim = housing.radius * (np.cos(turn)[:, None] * y + np.sin(turn)[:, None] * z)
    surface = rim[None] - along[:, None, None] * x
    expected = np.hypot(*(surface[..., :2] - center[:2]).reshape(-1, 2).T).min()
    assert standing_plan.housing_gap(PAPER, tilt, center) == pytest.approx(expected, abs=2e-4)


@pytest.mark.parametrize(("name", "is_near"), [("cylinder-60", False), ("cylinder-120", True)])
def test_a_wide_object_in_a_short_trunk_is_kept_from_the_housing(name: str, *, is_near: bool) -> None:
    design = design_from_rules(arm_radius=0.036)
    scene = SceneOptions(support="ground", orientation="upright", shape=parse_object(name), position=(0.43, 0.14, 0.0))
    seen, strategy = SimPlant(design, scene).reset(), WrapOblique()
    pull = cable_pulls(design, standing_plan.STEPS[-1] * float(shut_pull(design)[0]), 0.0)
    level, falling = (
        curl_tilt(design, wrapped_width(seen.task.target), pull, slope) for slope in (0.0, strategy.plane.slope)
    )
    closed = [move for move in strategy.init(seen).sequence.moves if move.action == "curl"][-1]
    assert closed.rotation is not None
    assert np.arccos(-closed.rotation[2, 0]) == pytest.approx(level if is_near else falling, abs=1e-6)


def risen(state: StandingState, seen: Observation, times: int) -> StandingState:
    """The state at the end of so many further rises of the test of the load."""
    sequence = state.sequence
    for _ in range(times):
        sequence = replace(attempts.rise_further(sequence), index=sequence.index + 1)
    return replace(state, sequence=replace(sequence, since=seen.time - sequence.move.duration))


def test_the_test_of_the_load_rises_further_before_anything_is_let_go(start: tuple[StandingState, Observation]) -> None:
    state, seen = at_the_end_of(start, "try", 0.0)
    tried, rise = state.sequence.move.position, np.array([0.0, 0.0, standing_plan.TEST])
    level = next(move.position for move in state.sequence.moves if move.action == "level")
    further, _ = STRATEGY.step(state, seen)
    assert further.sequence.move.action == "try"
    assert further.retries == 0
    np.testing.assert_allclose(further.sequence.move.position, tried + rise, atol=1e-12)
    loaded, seen = at_the_end_of(start, "try", 1.0)
    for times in range(attempts.RISES + 1):
        borne, _ = STRATEGY.step(risen(loaded, seen, times), seen)
        assert borne.sequence.move.action == "level"
        np.testing.assert_allclose(borne.sequence.move.position, level + times * rise, atol=1e-12)


def test_the_closing_trunk_yields_upwards_where_it_presses_on_something(
    start: tuple[StandingState, Observation],
) -> None:
    state, seen = at_the_end_of(start, "curl", 0.0)
    state = replace(state, sequence=replace(state.sequence, since=seen.time - 0.1))
    lift = next(move.position for move in state.sequence.moves if move.action == "lift")
    lower = next(move.position for move in state.sequence.moves if move.action == "lower")
    for pressed, rise in ((attempts.PRESS - 0.1, 0.0), (attempts.PRESS + 0.1, attempts.YIELD)):
        felt = STRATEGY.sense(replace(state, weight_empty=state.weight + pressed), seen).sequence
        up = np.array([0.0, 0.0, rise])
        np.testing.assert_allclose(felt.move.position, state.sequence.move.position + up, atol=1e-12)
        later = {move.action: move.position for move in felt.moves}
        np.testing.assert_allclose(later["lift"], lift + up, atol=1e-12)
        np.testing.assert_allclose(later["lower"], lower, atol=1e-12)


def test_what_has_toppled_is_not_tried_again(start: tuple[StandingState, Observation]) -> None:
    state, seen = at_the_end_of(start, "try", 0.0)
    state, _ = STRATEGY.step(risen(state, seen, attempts.RISES), seen)
    at = next(i for i, move in enumerate(state.sequence.moves) if move.action == "back off")
    since = seen.time - state.sequence.moves[at].duration
    begun = replace(state, sequence=replace(state.sequence, index=at, since=since))
    look = CameraObservation(time=seen.time, position=seen.task.target.position, axis=np.array([1.0, 0.0, 0.1]))
    toppled, _ = STRATEGY.step(begun, replace(seen, camera=look))
    assert toppled.gave_up == "nothing was lifted: the object has toppled"


def test_what_is_not_held_is_let_go_at_once_and_grasped_where_it_is_seen(
    start: tuple[StandingState, Observation],
) -> None:
    state, seen = at_the_end_of(start, "try", 0.0)
    state, _ = STRATEGY.step(risen(state, seen, attempts.RISES), seen)
    assert state.sequence.move.action == "let go"
    assert state.retries == 1
    repeated = [move.action for move in state.sequence.moves[state.sequence.index :]]
    assert repeated[: repeated.index("level")].count("try") == 1
    later = state.sequence.moves[state.sequence.index :]
    assert min(move.duration for move in later if move.action == "let go") == standing_plan.OPEN_TIME
    at = next(i for i, move in enumerate(state.sequence.moves) if move.action == "back off")
    moved = seen.task.target.position + np.array([0.01, -0.02, 0.03])
    look = CameraObservation(time=seen.time, position=moved, axis=seen.task.target.axis)
    since = seen.time - state.sequence.moves[at].duration
    begun = replace(state, sequence=replace(state.sequence, index=at, since=since))
    again, _ = STRATEGY.step(begun, replace(seen, camera=look))
    assert again.sequence.move.action == "near"
    np.testing.assert_allclose(
        again.sequence.move.position - state.sequence.moves[at + 1].position, [0.01, -0.02, 0.0], atol=1e-12
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cylinder-60", "cylinder-90"])
def test_a_standing_cylinder_is_carried_and_stands_again(name: str) -> None:
    trial = run_trial(PAPER, parse_object(name), strategy="wrap-horizontal", seed=1)
    assert trial.verdict.success, trial.verdict.reason


def test_the_near_horizontal_wrap_lowers_more_slowly() -> None:
    """It holds low and stiffly, and would meet the ground at the move's greatest speed."""
    durations = [
        next(move.duration for move in standing_plan.plan_moves(first_seen(), strategy.plane) if move.action == "lower")
        for strategy in (WrapHorizontal(), WrapOblique())
    ]
    assert durations == pytest.approx([1.3 * standing_plan.TIMES["lower"], standing_plan.TIMES["lower"]])


@pytest.mark.slow
@pytest.mark.parametrize(("shape", "seed"), [("box-80", 781402101), ("cylinder-90", 2054783779)])
def test_the_grounds_blow_does_not_take_the_wrist_to_its_limit(shape: str, seed: int) -> None:
    trial = run_trial(PAPER, parse_object(shape), strategy="wrap-horizontal", seed=seed)
    torque = np.array([sample.arm_torque for sample in trial.plant.trace])
    assert (np.abs(torque) < trial.plant.arm_limits.torque).all()


@pytest.mark.slow
@pytest.mark.parametrize(("shape", "seed"), [("box-80", 1327070126), ("cylinder-90", 3241803871)])
def test_what_leans_as_it_is_lowered_is_set_down_at_its_place(shape: str, seed: int) -> None:
    trial = run_trial(PAPER, parse_object(shape), strategy="wrap-horizontal", seed=seed)
    assert trial.verdict.success, trial.verdict.reason
    assert trial.verdict.place_error < 0.04
