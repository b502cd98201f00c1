"""Distal wraps of standing objects that are too short for a full one: what is planned, and two whole trials."""

import functools
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from spiraltrunk.control.messages import CameraObservation, Observation
from spiraltrunk.design import presets
from spiraltrunk.errors import ModelError
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.strategies.moves import Move, base_position, build_frame
from spiraltrunk.strategies.wrap.arm_lag import LAG
from spiraltrunk.strategies.wrap.assess import RIM
from spiraltrunk.strategies.wrap.attempts import JAMMED
from spiraltrunk.strategies.wrap.distal_plan import HEADROOM, find_height, find_rim
from spiraltrunk.strategies.wrap.set_down import (
    DISTAL_DRAG,
    OFF,
    center_place,
    is_on_ground,
    righting,
    set_down_clear,
)
from spiraltrunk.strategies.wrap.standing import StandingState, WrapHorizontal, WrapOblique, WrapObliqueLow
from spiraltrunk.strategies.wrap.standing_model import band_heights, shut_pull, wrap_start
from spiraltrunk.strategies.wrap.standing_plan import housing_sink
from spiraltrunk.workflows.grasp.trial import run_trial

PAPER = presets.PAPER
FAMILY = (WrapObliqueLow(), WrapOblique(), WrapHorizontal())
CAN = "cylinder:diameter_mm=50,height_mm=80,mass_g=200"
JAR = "cylinder:diameter_mm=80,height_mm=80,mass_g=300"
TIN = "cylinder:diameter_mm=66,height_mm=115,mass_g=350"
CARTON = "box:x_mm=40,y_mm=40,z_mm=144,mass_g=250"


@functools.cache
def first_seen(name: str = CAN) -> Observation:
    """What is seen at the start, beside a standing object."""
    scene = SceneOptions(support="ground", orientation="upright", shape=parse_object(name), position=(0.43, 0.14, 0.0))
    return SimPlant(PAPER, scene).reset()


@functools.cache
def begin(name: str = CAN, number: int = 6) -> StandingState:
    """State of the strategy of this number at the start."""
    return FAMILY[number - 4].init(first_seen(name))


def plan(name: str = CAN, number: int = 6) -> tuple[Move, ...]:
    return begin(name, number).sequence.moves


def plan_unturned(name: str, number: int = 6) -> tuple[Move, ...]:
    """Moves for an object whose yaw is unknown, which is approached from ahead."""
    seen = first_seen(name)
    unknown = replace(seen, task=replace(seen.task, target=replace(seen.task.target, side_yaw=None)))
    return FAMILY[number - 4].init(unknown).sequence.moves


def at_end_of(action: str, axis: np.ndarray) -> tuple[StandingState, Observation]:
    """The last instant of an action, a camera looking at an object with this axis under the trunk's base."""
    seen, state = first_seen(), begin()
    at = next(i for i, move in enumerate(state.sequence.moves) if move.action == action)
    since = seen.time - state.sequence.moves[at].duration
    base = state.sequence.moves[at].position
    look = CameraObservation(time=seen.time, position=base + np.array([0.1, 0.07, -0.03]), axis=axis)
    begun = state.sequence.start
    frame = begun.T_world_base.copy()
    frame[:3, 3] = base  # It does not move any more.
    sequence = replace(state.sequence, index=at, since=since, start=replace(begun, T_world_base=frame))
    return replace(state, sequence=sequence), replace(seen, camera=look)


@pytest.mark.parametrize(
    ("name", "number"),
    [
        pytest.param(name, number, marks=[] if number == fast else [pytest.mark.slow])
        for name, fast in ((CAN, 4), (JAR, 5), (TIN, 6), (CARTON, 4))
        for number in (4, 5, 6)
    ],
)
def test_from_80_mm_on_there_is_a_plan_in_which_the_housing_clears_the_ground(name: str, number: int) -> None:
    seen, state = first_seen(name), begin(name, number)
    assert state.is_distal
    assert seen.task.goal.ground is not None
    for move in state.sequence.moves:
        assert move.rotation is not None
        along = move.rotation[:, 0]
        for back in (PAPER.housing.neck_length, PAPER.housing.neck_length + PAPER.housing.length):
            low = (move.position - back * along)[2] - PAPER.housing.radius * math.sqrt(1 - along[2] ** 2)
            assert low > seen.task.goal.ground + 0.01, move.action


@pytest.mark.parametrize("number", [4, *(pytest.param(number, marks=pytest.mark.slow) for number in (5, 6))])
def test_it_wraps_above_the_centre_and_below_the_rim(number: int) -> None:
    plane = FAMILY[number - 4].plane
    for height in (80, 100, 120, 135):
        task = first_seen(f"cylinder:diameter_mm=60,height_mm={height},mass_g=200").task
        below, radius = find_rim(task, plane)
        wrapped = find_height(task, plane)
        assert wrapped == pytest.approx(task.target.length - below)
        assert wrapped > 0.5 * task.target.length
        wanted = min(plane.distal_height * task.target.length, task.target.length - HEADROOM * radius)
        assert wrapped >= wanted - 1e-9, "higher only where the ground asks for it"


@pytest.mark.parametrize(
    "name",
    [
        name if name in {"cylinder-60", "bottle-70"} else pytest.param(name, marks=pytest.mark.slow)
        for name in WrapHorizontal.objects
    ],
)
def test_what_is_tall_enough_is_wrapped_in_full(name: str) -> None:
    assert not any(begin(name, number).is_distal for number in (4, 5, 6))


@pytest.mark.parametrize("name", [JAR, "cylinder-90"])
def test_where_the_object_jams_a_distal_wrap_closes_without_moving_the_arm_on(name: str) -> None:
    seen, state = first_seen(name), begin(name)
    at = next(i for i, move in enumerate(state.sequence.moves) if move.action == "curl")
    state = replace(state, sequence=replace(state.sequence, index=at, since=seen.time - 0.1))
    here, free = base_position(state.sequence, seen.time), -float(seen.base_force[2])
    tight, lift, lower = (
        next(move.position for move in state.sequence.moves if move.action == action)
        for action in ("tighten", "lift", "lower")
    )
    for push, is_stopped in ((JAMMED - 0.1, False), (JAMMED + 0.1, name == JAR)):
        pushed = replace(seen, base_force=np.array([push, 0.0, -free]))
        sequence = FAMILY[2].sense(replace(state, weight=free, weight_empty=free), pushed).sequence
        assert sequence.move.action == ("tighten" if is_stopped else "curl")
        if is_stopped:
            later = {move.action: move.position for move in sequence.moves[sequence.index :]}
            np.testing.assert_allclose(later["tighten"], here, atol=1e-12)
            np.testing.assert_allclose(later["lift"], lift + here - tight, atol=1e-12)
            np.testing.assert_allclose(later["lower"], lower, atol=1e-12)


def test_an_object_so_short_that_the_sections_press_on_its_rim_is_told() -> None:
    for name, is_held in ((CAN, True), ("cylinder:diameter_mm=53,height_mm=51,mass_g=144", False)):
        below, radius = find_rim(first_seen(name).task, WrapObliqueLow.plane)
        assert radius in PAPER.section_radius
        assert (below >= RIM * radius) == is_held


@pytest.mark.parametrize("name", [CAN, JAR, TIN])
def test_the_closed_trunk_is_round_the_object_and_above_the_ground(name: str) -> None:
    target, ground = first_seen(name).task.target, first_seen(name).task.goal.ground
    closed = [move for move in plan(name) if move.action == "curl"][-1]
    assert closed.rotation is not None
    tilt = math.acos(-closed.rotation[2, 0])
    middle, lowest = band_heights(PAPER, target.width, tilt, closed.tension)
    base = closed.position[2] - ground
    assert base + lowest > 0.0
    assert base + middle < target.length


def test_the_base_stays_open_and_high_until_the_object_is_borne() -> None:
    moves = plan()
    curl, borne = ([m for m in moves if m.action == action][-1] for action in ("curl", "lift"))
    assert curl.tension @ -PAPER.cable_direction[:, 1] < 0.7 * shut_pull(PAPER)[0]
    assert borne.tension @ -PAPER.cable_direction[:, 1] > shut_pull(PAPER)[0]
    assert min(move.position[2] for move in moves) == pytest.approx(curl.position[2])


def test_a_wider_object_is_closed_round_by_sections_nearer_to_the_base() -> None:
    pulls = []
    for name in (TIN, JAR):
        curl = [move for move in plan(name) if move.action == "curl"][-1]
        pulls.append(float(curl.tension @ -PAPER.cable_direction[:, 1]))
        assert pulls[-1] > 1.5 * shut_pull(PAPER)[wrap_start(PAPER, first_seen(name).task.target.width)]
    assert pulls[1] > 1.2 * pulls[0]


def test_a_flat_box_is_closed_round_by_its_girth_with_room_for_its_diagonal() -> None:
    """Tensions and heights are those of the cylinder of its girth, the way aside that of the one round its corners."""
    box, girth, corners = (
        [move for move in plan_unturned(name) if move.action == "curl"]
        for name in ("box:x_mm=100,y_mm=30,z_mm=150,mass_g=300",
                     f"cylinder:diameter_mm={2 * (100 + 30) / math.pi:.6f},height_mm=150,mass_g=300",
                     f"cylinder:diameter_mm={math.hypot(100, 30):.6f},height_mm=150,mass_g=300")
    )  # fmt: skip
    assert len(box) == len(girth)
    for one, other in zip(box, girth, strict=True):
        np.testing.assert_allclose(one.tension, other.tension, atol=0.05)
        assert one.position[2] == pytest.approx(other.position[2], abs=5e-4)
    pairs = [(one, other) for one in box for other in corners if np.allclose(one.tension, other.tension, atol=0.05)]
    assert len(pairs) >= 6
    for one, other in pairs:
        np.testing.assert_allclose(one.position[:2], other.position[:2], atol=5e-4)


def test_a_taller_object_is_wrapped_higher_and_in_a_flatter_plane() -> None:
    tilts, heights = [], []
    for height in (80, 100, 130):
        closed = [m for m in plan(f"cylinder:diameter_mm=50,height_mm={height},mass_g=200") if m.action == "curl"][-1]
        assert closed.rotation is not None
        tilts.append(math.acos(-closed.rotation[2, 0]))
        heights.append(closed.position[2])
    assert (np.diff(tilts) > 0).all()
    assert (np.diff(heights) > 0).all()


def test_the_low_wrap_is_lower_than_the_horizontal_one() -> None:
    low, level = (next(move for move in plan(TIN, number) if move.action == "tighten").position[2] for number in (4, 6))
    assert low < level


def test_what_is_too_short_for_a_distal_wrap_is_refused() -> None:
    with pytest.raises(ModelError, match=r"30 mm tall; allowed: [0-9]+ mm or more"):
        plan("cylinder:diameter_mm=60,height_mm=30,mass_g=100")


@pytest.mark.parametrize(("lean", "azimuth"), [(0.0, 0.0), (0.2, 0.7), (0.45, -2.5)])
def test_an_object_is_righted_about_its_low_edge(lean: float, azimuth: float) -> None:
    toward = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
    turn = Rotation.from_rotvec(lean * np.cross([0.0, 0.0, 1.0], toward))
    _, seen = at_end_of("lower", turn.apply([0.0, 0.0, 1.0]))
    assert seen.camera is not None
    target = seen.task.target
    edge = np.array([target.width / 2, 0.0, -target.length / 2])  # Of an upright object, in the direction of the lean.
    edge = Rotation.from_rotvec([0.0, 0.0, azimuth]).apply(edge)
    expected = turn.apply(edge) - edge  # The edge stays where it is, so that the centre moves by as much.
    np.testing.assert_allclose(righting(seen, seen.camera), expected * [1, 1, 0], atol=1e-12)


def test_the_housing_clears_the_ground_when_a_leaning_object_is_set_down() -> None:
    state, seen = at_end_of("hold", np.array([0.0, math.sin(0.5), math.cos(0.5)]))
    ground = seen.task.goal.ground
    assert ground is not None
    for move in set_down_clear(state.sequence, seen, 0.03).moves:
        if move.phase == "release":
            assert move.rotation is not None
            assert move.position[2] - housing_sink(PAPER, math.acos(-move.rotation[2, 0])) >= ground + 0.0149


def test_a_leaning_object_is_set_down_short_of_where_its_righting_ends() -> None:
    state, seen = at_end_of("bring", np.array([0.0, math.sin(0.4), math.cos(0.4)]))
    assert seen.camera is not None
    centred = center_place(state.sequence, seen, np.array([1.0, 0.0, 0.0]), DISTAL_DRAG)
    after = {move.action: move for move in centred.moves}
    for before in state.sequence.moves:
        if before.action not in ("lower", "uncurl", "open", "draw off", "leave", "rest"):
            continue
        # Lowered, righted and dragged, the object that is seen comes to stand at its place.
        dragged = PAPER.length * np.array([*DISTAL_DRAG, 0.0])
        last = [move for move in state.sequence.moves if move.action == before.action][-1]
        way = after[before.action].position - last.position
        moved = seen.camera.position + way + righting(seen, seen.camera) + dragged
        np.testing.assert_allclose((moved - seen.task.goal.place)[:2], 0.0, atol=1e-12)
    lean = righting(seen, seen.camera)
    assert lean[1] < -0.01
    assert lean[0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("off", "is_moved"), [(0.5 * OFF, False), (2 * OFF, True)])
def test_an_object_far_from_its_place_is_moved_there_before_it_is_lowered(off: float, is_moved: bool) -> None:
    state, seen = at_end_of("bring", np.array([0.0, 0.0, 1.0]))
    assert seen.camera is not None
    side, sequence = np.array([1.0, 0.0, 0.0]), state.sequence
    frame = build_frame(sequence.move.position, sequence.move.rotation)
    sequence = replace(sequence, start=replace(sequence.start, T_world_base=frame))  # It moves no more.
    seen = replace(seen, camera=replace(seen.camera, position=seen.task.goal.place + np.array([off, 0.0, 0.1])))
    centred = center_place(sequence, seen, side, (0.0, 0.0))
    centring = [move for move in centred.moves if move.action == "center"]
    assert len(centring) == int(is_moved)
    for move in centring:
        way = move.position - sequence.move.position
        np.testing.assert_allclose(way, [-off, 0.0, 0.0], atol=1e-12)


def test_where_the_camera_looked_before_the_arm_stopped_the_rest_of_its_way_counts() -> None:
    state, seen = at_end_of("bring", np.array([0.0, 0.0, 1.0]))
    frame = state.sequence.start.T_world_base.copy()
    frame[:3, 3] += [0.1, -0.05, 0.0]
    moving = replace(state.sequence, start=replace(state.sequence.start, T_world_base=frame))
    side, duration = np.array([1.0, 0.0, 0.0]), state.sequence.move.duration
    ends = []
    for age in (0.0, 0.4 * duration):
        time = seen.time - age
        left = moving.move.position - base_position(moving, time - LAG)
        look = CameraObservation(time=time, position=seen.task.goal.place - left, axis=np.array([0.0, 0.0, 1.0]))
        centred = center_place(moving, replace(seen, camera=look), side, (0.0, 0.0))
        ends.append([move.position for move in centred.moves[-5:]])
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-12)
    np.testing.assert_allclose(ends[0], [move.position for move in moving.moves[-5:]], atol=1e-12)


@pytest.mark.parametrize(("rise", "lean", "stands"), [(0.0, 0.0, True), (0.025, 0.0, False), (0.008, 0.4, True),
                                                      (0.030, 0.4, False)])  # fmt: skip
def test_an_object_is_on_the_ground_where_it_stands_or_leans_on_its_edge(
    rise: float, lean: float, stands: bool
) -> None:
    _, seen = at_end_of("lower", np.array([0.0, math.sin(lean), math.cos(lean)]))
    assert seen.camera is not None
    center = seen.task.goal.place + np.array([0.0, 0.0, rise])
    assert is_on_ground(replace(seen, camera=replace(seen.camera, position=center))) == stands


def test_what_the_trunk_alone_touches_the_ground_with_is_lowered_further() -> None:
    state, seen = at_end_of("lower", np.array([0.0, 0.0, 1.0]))
    assert seen.camera is not None
    half_way = replace(state.sequence, since=seen.time - state.sequence.move.duration / 2)
    state, place = replace(state, sequence=half_way, weight=0.0), seen.task.goal.place
    unloaded = replace(seen, base_force=np.zeros(3))
    for rise, action in ((0.03, "lower"), (0.0, "uncurl")):
        look = replace(seen.camera, position=place + np.array([0.0, 0.0, rise]))
        assert FAMILY[2].step(state, replace(unloaded, camera=look))[0].sequence.move.action == action


def test_it_lets_go_of_what_it_missed_from_where_it_had_closed() -> None:
    state, seen = at_end_of("try", np.array([0.0, 0.0, 1.0]))
    weight = state.weight_empty
    while state.sequence.move.action == "try":  # It rises further first: the trunk may have pressed on the ground.
        seen = replace(seen, time=state.sequence.since + state.sequence.move.duration)
        felt = replace(seen, base_force=np.array([0.0, 0.0, -weight]))
        state, _ = FAMILY[2].step(replace(state, weight=weight), felt)
    assert state.sequence.move.action == "let go"
    later = state.sequence.moves[state.sequence.index :]
    closed = [move for move in plan() if move.action == "curl"][-1]
    spring = next(i for i, move in enumerate(later) if move.duration < 0.1)
    np.testing.assert_array_equal(later[spring - 1].tension, closed.tension)
    np.testing.assert_array_equal(later[spring].position, closed.position)


@pytest.mark.slow
@pytest.mark.parametrize("name", [CAN, TIN])
def test_a_low_cylinder_is_carried_and_stands_again(name: str) -> None:
    trial = run_trial(PAPER, parse_object(name), strategy="wrap-horizontal", seed=1)
    assert trial.verdict.success, trial.verdict.reason
    end = trial.plant.trace[-1].object_position
    assert end[2] == pytest.approx(trial.plant.trace[0].object_position[2], abs=0.002)  # It stands.
