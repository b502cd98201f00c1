"""Recordings whose errors are known by construction come out with these errors, wherever the cameras stood."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import ModelError, TakeError
from spiraltrunk.mocap import build_session, compute_deviation, load_shapes, read_session, write_shapes
from spiraltrunk.mocap.protocol.protocol import Protocol, Run
from spiraltrunk.mocap.protocol.schedule import build_schedule
from spiraltrunk.mocap.recordings.axes import read_axes, turn_quaternions
from spiraltrunk.mocap.recordings.motive_write import write_motive
from spiraltrunk.mocap.session.plausibility import compute_reach
from spiraltrunk.mocap.session.prediction import predict
from spiraltrunk.mocap.session.session import SessionSettings
from spiraltrunk.mocap.signal.registration import read_alignment
from spiraltrunk.model.kinematics.measured_shapes import compute_marker_offset
from spiraltrunk.workflows.virtual_session.synthetic_take import CameraOptions, build_synthetic_take

SECTIONS = (1, 3, 5, 7, 9, 11, 13, 15)


def build(protocol, takes, alignment="base", **more):
    settings = SessionSettings(design=PAPER, alignment=read_alignment(alignment), **more)
    return build_session(protocol, takes, settings)


def deviate(run):
    return compute_deviation(run.points, run.predicted.points, run.rotation, run.predicted.rotation)


@pytest.mark.parametrize("alignment", ["base", "run", "shape", "run:1-9", "shape:1-9"])
@pytest.mark.parametrize("name", ["bend", "rest-0", "rest-45"])
def test_the_model_itself_has_no_error_but_noise(name, alignment, protocol, rehearse):
    run = build(protocol, {name: [rehearse(name)]}, alignment).runs[0]
    found = deviate(run)
    assert found.sections == list(SECTIONS)
    assert found.max_deviation < 1e-3
    assert found.mean_rmse < 4e-4
    assert found.mean_turn < np.radians(1.5)
    np.testing.assert_allclose(run.points[0, 0], run.predicted.points[0, 0], atol=1e-3)


def test_a_shift_of_all_points_counts_in_full_by_the_base_and_not_at_all_by_a_fit(protocol, rehearse):
    take = rehearse("bend", shift=np.array([0.0, 0.0, 7e-3]), noise=2e-5)
    by_base = deviate(build(protocol, {"bend": [take]}, "base").runs[0])
    np.testing.assert_allclose(by_base.per_shape, 7e-3, atol=2e-4)
    np.testing.assert_allclose(by_base.per_section[np.array(SECTIONS) - 1], 7e-3, atol=2e-4)
    assert deviate(build(protocol, {"bend": [take]}, "run").runs[0]).max_deviation < 2e-4


def test_errors_of_single_shapes_and_sections_come_out_where_they_were_put(protocol, rehearse):
    shift = np.zeros((5, 18, 3))
    shift[2, 4, 2], shift[2, 8, 2], shift[4, 8, 2] = 6e-3, 8e-3, -5e-3
    found = deviate(build(protocol, {"bend": [rehearse("bend", shift=shift, noise=2e-5)]}, "base").runs[0])
    np.testing.assert_allclose(found.distance[2, [4, 8]], [6e-3, 8e-3], atol=2e-4)
    np.testing.assert_allclose(found.per_shape[[2, 4]], [1e-2 / np.sqrt(8), 5e-3 / np.sqrt(8)], atol=2e-4)
    np.testing.assert_allclose(found.per_section[8], np.sqrt((64 + 25) / 5) * 1e-3, atol=2e-4)
    assert found.max_deviation == pytest.approx(8e-3, abs=2e-4)


def test_the_other_model_has_the_error_that_both_models_have_between_them(protocol, rehearse):
    """By an independent alignment, scipy's, of one model on the other."""
    run = protocol.run("bend")
    plan = build_schedule(PAPER, protocol, run)
    chosen = np.array(SECTIONS) - 1
    truth = predict(PAPER, plan, model="statics").points[:, chosen].reshape(-1, 3)
    target = predict(PAPER, plan).points[:, chosen].reshape(-1, 3)
    turn, _ = Rotation.align_vectors(target - target.mean(axis=0), truth - truth.mean(axis=0))
    away = np.linalg.norm(turn.apply(truth - truth.mean(axis=0)) + target.mean(axis=0) - target, axis=1).reshape(5, -1)
    expected = np.sqrt((away**2).mean(axis=1))
    takes = {"bend": [rehearse("bend", model="statics", noise=5e-5)]}
    np.testing.assert_allclose(deviate(build(protocol, takes, "run").runs[0]).per_shape, expected, atol=2e-4)
    assert expected.mean() > 2e-3
    by_statics = build(protocol, takes, "run", model="statics").runs[0]
    assert deviate(by_statics).max_deviation < 3e-4


def test_alignments_are_ordered(protocol, rehearse):
    """The more a fit may do, the smaller the sum of squares that is left."""
    takes = {"bend": [rehearse("bend", model="statics")]}
    left = [
        float(np.nansum(deviate(build(protocol, takes, kind).runs[0]).distance ** 2))
        for kind in ("base", "run", "shape")
    ]
    assert left[0] > left[1] > left[2]


def test_the_cameras_frame_makes_no_difference(protocol, rehearse):
    one, other = (
        build(protocol, {"bend": [rehearse("bend", yaw=yaw, shift=0.002, noise=2e-5, seed=3)]}).runs[0]
        for yaw in (0.0, 2.5)
    )  # fmt: skip
    np.testing.assert_allclose(one.points, other.points, atol=1e-4)


def test_two_takes_are_averaged(protocol, rehearse):
    up, down = np.array([0.0, 0.0, 3e-3]), np.array([0.0, 0.0, -1e-3])
    takes = [rehearse("bend", shift=up, yaw=0.1, noise=2e-5), rehearse("bend", shift=down, yaw=1.9, seed=1, noise=2e-5)]
    run = build(protocol, {"bend": takes}).runs[0]
    np.testing.assert_allclose(deviate(run).per_shape, 1e-3, atol=1e-4)
    assert run.spread == pytest.approx(2e-3, abs=1e-4)
    assert any("takes of run 'bend': 2; the protocol asks for 1" in note for note in run.notes)


def hide(take, name, frames, how):
    """The take with a body and its markers unseen, or held, in some frames."""

    def change(track):
        if not track.name.startswith(name):
            return track
        position = track.position.copy()
        position[frames] = np.nan if how == "unseen" else position[frames.start] if how == "held" else 9.0
        changes = {"position": position}
        if hasattr(track, "quaternion_wxyz"):
            turn = track.quaternion_wxyz.copy()
            turn[frames] = np.nan if how == "unseen" else turn[frames.start]
            changes["quaternion_wxyz"] = turn
        return replace(track, **changes)

    return replace(take, bodies=tuple(map(change, take.bodies)), markers=tuple(map(change, take.markers)))


@pytest.mark.parametrize("how", ["unseen", "held"])
def test_a_section_that_is_not_seen_in_a_shape_is_no_number_there(how, protocol, rehearse):
    """A pose held over from the shape before would be an error of centimetres, were it taken for measured."""
    take = hide(rehearse("bend"), "section_09", slice(65, 125), how)
    run = build(protocol, {"bend": [take]}).runs[0]
    missing = np.isnan(run.points[:, 8, 0])
    np.testing.assert_array_equal(missing, [False, True, False, False, False])
    assert deviate(run).max_deviation < 1e-3
    assert any("longest in section 9" in note for note in run.notes)
    both = build(protocol, {"bend": [take, rehearse("bend", seed=1)]}).runs[0]
    assert np.isfinite(both.points[1, 8]).all()
    assert any("1 of 90 points" in note for note in both.notes)


def test_a_short_occlusion_costs_nothing(protocol, rehearse):
    take = hide(rehearse("bend"), "section_09", slice(80, 90), "unseen")
    assert np.isfinite(build(protocol, {"bend": [take]}).runs[0].points[:, 8]).all()


def test_markers_alone_are_enough(protocol, rehearse):
    take = rehearse("bend")
    bare = replace(take, bodies=())
    run = build(protocol, {"bend": [bare]}, "run").runs[0]
    assert deviate(run).max_deviation < 1e-3
    assert deviate(run).mean_turn < np.radians(1.5)
    with pytest.raises(TakeError, match="no rigid body with orientation at the trunk's base"):
        build(protocol, {"bend": [bare]}, "base")


def test_bodies_alone_are_enough(protocol, rehearse):
    take = replace(rehearse("bend"), markers=())
    for orientation, is_known in (("body", True), ("markers", False), ("none", False)):
        run = build(replace(protocol, orientation=orientation), {"bend": [take]}).runs[0]
        assert deviate(run).max_deviation < 1e-3
        assert np.isfinite(deviate(run).mean_turn) == is_known


def test_shapes_are_what_calibration_reads(protocol, rehearse, tmp_path):
    takes = {"rest-45": [rehearse("rest-45")], "bend": [rehearse("bend"), rehearse("bend", seed=2)]}
    shapes = read_session(protocol, takes, SessionSettings(design=PAPER, alignment=read_alignment("base")))
    assert shapes.kind == ("bend-dorsal",) * 5 + ("rest",)
    assert shapes.take == ("synthetic+synthetic",) * 5 + ("synthetic",)
    np.testing.assert_array_equal(shapes.follows, [-1, 0, 1, 2, 3, -1])
    np.testing.assert_allclose(np.degrees(shapes.theta_0), [90] * 5 + [45])
    np.testing.assert_allclose(shapes.pull[:5, 0], 0.02 * np.arange(5), atol=1e-5)
    assert np.isnan(shapes.pull[:, 1:]).all()
    assert np.isnan(shapes.pull[5]).all()
    assert shapes.marker_offset[0] == pytest.approx(0.0474092, abs=1e-7)
    path = write_shapes(shapes, tmp_path / "shapes.json")
    again = load_shapes(path)
    for name in ("theta_0", "pull", "follows", "marker_offset", "points", "rotation"):
        np.testing.assert_array_equal(getattr(again, name), getattr(shapes, name))
    assert (again.kind, again.take) == (shapes.kind, shapes.take)


@pytest.mark.parametrize("key", ["theta_0_rad", "pull_m", "follows", "seat_m", "points_m", "rotation"])
@pytest.mark.parametrize("value", [5, "x", None, [[1.0], []], {}, []])
def test_shapes_with_an_array_of_another_size_are_refused(key, value, tmp_path):
    shapes = {
        "schema": 1, "kind": ["rest"], "take": ["a"], "theta_0_rad": [1.5], "pull_m": [[0.0, 0.0]], "follows": [-1],
        "seat_m": [0.05], "points_m": [[[0.0, 0.0, 0.0]]], "rotation": np.eye(3)[None, None].tolist(),
    }  # fmt: skip
    path = tmp_path / "shapes.json"
    path.write_text(json.dumps(shapes))
    assert load_shapes(path).kind == ("rest",)
    path.write_text(json.dumps(shapes | {key: value}))
    with pytest.raises(TakeError, match=r"shapes\.json.*; allowed: "):
        load_shapes(path)


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", '{"schema": 1}', '{"schema": 2}', "[" * 5000, '{"schema": 1, "kind": 3}']
)
def test_other_json_is_refused(text, tmp_path):
    path = tmp_path / "shapes.json"
    path.write_text(text)
    with pytest.raises(TakeError, match=re.escape("shapes.json")):
        load_shapes(path)


def test_a_wrong_number_of_shapes_is_told_with_their_times(protocol, rehearse):
    with pytest.raises(TakeError) as caught:
        build(protocol, {"rest-0": [rehearse("bend")]})
    assert (
        "5 static shapes found (0.0-0.7, 1.4-1.8, 2.6-3.0, 3.8-4.2, 5.0-5.6 s); allowed: 1, as run 'rest-0' has"
        in str(caught.value)
    )
    with pytest.raises(TakeError, match="1 static shapes found"):
        build(protocol, {"bend": [rehearse("rest-0")]})
    with pytest.raises(TakeError, match=r"no static shape found in \d+ frames, \d\.\d+ s: .* slowest .* mm/s, .* unit"):
        build(protocol, {"bend": [rehearse("bend", hold=0.1)]})


def test_times_choose_what_counts(protocol, rehearse):
    take = rehearse("bend")
    first = replace(protocol, runs=(replace(protocol.run("rest-0"), begin=0.0, end=1.0),))
    assert deviate(build(first, {"rest-0": [take]}).runs[0]).max_deviation < 1e-3
    timed = replace(protocol, runs=(replace(protocol.run("bend"), begin=-0.2, period=1.2),))
    assert deviate(build(timed, {"bend": [take]}).runs[0]).max_deviation < 1e-3
    late = replace(protocol, runs=(replace(protocol.run("bend"), begin=60.0),))
    with pytest.raises(TakeError, match="between begin_s and end_s"):
        build(late, {"bend": [take]})


def test_another_trunk_or_unit_is_noticed(protocol, rehearse):
    large = _scale(rehearse("bend", sections=tuple(range(1, 16))), 1.5)
    with pytest.raises(TakeError, match=r"mm apart; allowed: .* is it another trunk, another unit"):
        build(protocol, {"bend": [large]})
    short = replace(PAPER, n_section=12, mass=replace(PAPER.mass, sections=None, density=1000.0))
    with pytest.raises(TakeError, match="section 15 recorded; allowed: 1 to 12"):
        build_session(protocol, {"rest-0": [rehearse("rest-0")]}, SessionSettings(design=short))


@pytest.mark.parametrize("sections", [(1, 3, 5, 7, 9, 11, 13, 15), (1, 9, 17), (2, 6, 18)])
@pytest.mark.parametrize("name", ["rest-0", "rest-45"])
def test_another_unit_is_noticed_without_neighbours(name, sections, protocol, rehearse):
    take = rehearse(name, sections=sections)
    build(protocol, {name: [take]}, "run")
    with pytest.raises(TakeError, match="another unit"):
        build(protocol, {name: [_scale(take, 1e-3)]}, "run")
    calm = replace(protocol, still=replace(protocol.still, speed=9.0))
    with pytest.raises(TakeError, match="another unit"):
        build(calm, {name: [_scale(take, 1e3)]}, "run")


@pytest.mark.parametrize("factor", [0.98, 0.996, 1.0, 1.004, 1.02])
@pytest.mark.parametrize("name", ["bend", "rest-45"])
def test_an_error_of_scale_is_told(name, factor, protocol, rehearse):
    """Bent as far as cable 1 goes, too: neighbours are held against the design at the bend that they show."""
    take = _scale(rehearse(name, sections=tuple(range(1, 16)), noise=2e-5), factor)
    notes = [note for note in build(protocol, {name: [take]}, "run").runs[0].notes if "in the median" in note]
    expected = {0.98: "2.0% nearer together", 1.02: "2.0% further apart"}.get(factor)
    assert len(notes) == (expected is not None)
    assert expected is None or expected in notes[0]


def test_no_shape_is_beyond_the_reach_of_the_joints():
    """Random bends in space within the joint limit, drawn as chains on their own."""
    draw = np.random.default_rng(0)
    offset, length = compute_marker_offset(PAPER), PAPER.section_length
    for one, other in [(0, 1), (0, 2), (3, 7), (2, 8), (0, 17), (10, 17)]:
        least, most = compute_reach(PAPER, one, other)
        for k in range(200):
            bend = PAPER.joint_limit * (draw.uniform(0.8, 1.0, other - one) if k else np.ones(other - one))
            about = 0.3 * k / 200 * draw.normal(size=other - one)
            turn, place = Rotation.identity(), np.array([length[one] - offset[one], 0.0, 0.0])
            for joint, section in enumerate(range(one + 1, other + 1)):
                axis = np.array([0.0, -np.sin(about[joint]), np.cos(about[joint])])
                turn = turn * Rotation.from_rotvec(bend[joint] * axis)
                place = place + turn.apply([offset[section] if section == other else length[section], 0.0, 0.0])
            assert least - 1e-12 <= np.linalg.norm(place) <= most + 1e-12
            if k == 0 and other - one <= 4:
                assert np.linalg.norm(place) == pytest.approx(least)
    assert most == pytest.approx(length[10:17].sum() - offset[10] + offset[17])


def _scale(take, factor):
    def grow(track):
        return replace(track, position=factor * track.position)

    return replace(take, bodies=tuple(map(grow, take.bodies)), markers=tuple(map(grow, take.markers)))


def test_markers_counted_backwards_are_noticed(protocol, rehearse):
    take = rehearse("bend", sections=tuple(range(1, 16)))
    swap = {"Marker2": "Marker3", "Marker3": "Marker2"}
    names = [marker.name.split(":") for marker in take.markers]
    markers = tuple(
        replace(marker, name=f"{body}:{swap.get(end, end)}")
        for marker, (body, end) in zip(take.markers, names, strict=True)
    )
    with pytest.raises(TakeError, match=r"points towards the base; .* numbered from the base, and --axes .*mirrored"):
        build(protocol, {"bend": [replace(take, markers=markers)]})


def test_too_few_or_doubled_sections_are_refused(protocol, rehearse):
    take = rehearse("bend")
    with pytest.raises(TakeError, match=r"2 sections found among 'base'"):
        build(protocol, {"bend": [replace(take, bodies=take.bodies[:3], markers=())]})
    twice = replace(take, bodies=(*take.bodies, replace(take.bodies[1], name="Section 1")))
    with pytest.raises(TakeError, match="section 1 is there twice, as 'section_01' and 'Section 1'"):
        build(protocol, {"bend": [twice]})
    beyond = replace(protocol, sections=((3, "section_03"), (5, "section_05"), (7, "section_07"), (19, "tip")))
    with pytest.raises(TakeError, match="the protocol's section 19 is 'tip'; allowed: 1 to 18"):
        build(beyond, {"bend": [take]})
    named = replace(protocol, sections=((1, "section_03"), (2, "section_05"), (3, "elsewhere")))
    with pytest.raises(TakeError, match="2 sections found"):
        build(named, {"bend": [take]})


def test_names_can_be_told(protocol, rehearse):
    take = rehearse("bend")
    renamed = replace(
        take, markers=(), bodies=tuple(replace(body, name=body.name.replace("section_", "RB ")) for body in take.bodies)
    )
    named = replace(protocol, sections=tuple((number, f"RB {number:02d}") for number in SECTIONS))
    assert deviate(build(named, {"bend": [renamed]}).runs[0]).max_deviation < 1e-3


def test_a_base_that_moves_or_leans_is_told(protocol, rehearse):
    take = rehearse("rest-45")
    wrong = replace(protocol, runs=(replace(protocol.run("rest-0")), replace(protocol.run("rest-45"), theta_0=0.7)))
    notes = build(wrong, {"rest-45": [take]}).runs[0].notes
    assert any("the base is tilted otherwise than set: its axis is 4" in note for note in notes)
    assert any("deg below the horizontal, not 40.1" in note for note in notes)
    bend = rehearse("bend")
    place = bend.bodies[0].position + np.linspace(0, 0.01, len(bend.frame))[:, None]
    moved = replace(bend, bodies=(replace(bend.bodies[0], position=place), *bend.bodies[1:]))
    assert any("the base moved by" in note for note in build(protocol, {"bend": [moved]}).runs[0].notes)


@pytest.mark.parametrize("alignment", ["base", "run", "shape", "run:1-9"])
def test_a_take_of_another_tilt_is_refused_whatever_the_alignment(alignment, protocol, rehearse):
    with pytest.raises(TakeError, match=r"45\.\d deg below the horizontal, not 90\.0; allowed: .* --axes, .* 'rest-0'"):
        build(protocol, {"rest-0": [rehearse("rest-45")]}, alignment)
    near = replace(protocol, runs=(replace(protocol.run("rest-45"), theta_0=np.radians(41.0)),))
    notes = build(near, {"rest-45": [rehearse("rest-45")]}, alignment).runs[0].notes
    assert sum("is tilted otherwise than set" in note for note in notes) == 1
    assert not any("tilted" in note for note in build(protocol, {"bend": [rehearse("bend")]}, alignment).runs[0].notes)


def test_without_a_base_tilt_is_not_judged(protocol, rehearse):
    take = rehearse("rest-45")
    read = build(protocol, {"rest-0": [replace(take, bodies=take.bodies[1:])]}, "run")
    assert not any("tilted" in note for note in read.runs[0].notes)


def test_wrong_axes_are_refused(protocol, rehearse, tmp_path):
    path = write_motive(rehearse("rest-0"), tmp_path / "rest-0_1.csv")
    with pytest.raises(TakeError, match=r"0\.0 deg below the horizontal, not 90\.0"):
        build(protocol, {"rest-0": [path]}, "run", axes="z-up")


def test_the_same_data_is_one_take(protocol, rehearse):
    take = rehearse("bend")
    with pytest.raises(TakeError, match="'b': the same data as 'a'"):
        build(protocol, {"bend": [replace(take, source="a"), replace(take, source="b")]})
    build(protocol, {"bend": [take, rehearse("bend", seed=1)]})


def test_axes_are_asked_for_and_taken_from_either_place(protocol, rehearse, tmp_path):
    path = write_motive(rehearse("rest-0"), tmp_path / "rest-0_1.csv")
    silent = replace(protocol, axes=None)
    with pytest.raises(TakeError, match="axis convention of the recordings is not given"):
        build(silent, {"rest-0": [path]})
    for run in (build(silent, {"rest-0": [path]}, axes="y-up"), build(protocol, {"rest-0": [path]})):
        assert deviate(run.runs[0]).max_deviation < 1e-3


def test_nothing_and_unknown_runs_and_models_are_refused(protocol, rehearse):
    with pytest.raises(TakeError, match="no recordings given"):
        build(protocol, {})
    with pytest.raises(TakeError, match="unknown run 'kick'; known: bend, rest-0, rest-45"):
        build(protocol, {"kick": [rehearse("bend")]})
    with pytest.raises(ModelError, match="model is 'magic'"):
        build(protocol, {"bend": [rehearse("bend")]}, model="magic")
    with pytest.raises(ModelError, match="friction given with the model reference"):
        build(protocol, {"bend": [rehearse("bend")]}, friction=0.1)


def test_twist_and_ventral_bending_come_out_too():
    runs = (
        Run(name="twist", kind="twist", steps=2, step=0.015, first=0.06),
        Run(name="back", kind="bend-ventral", steps=2, step=0.03, theta_0=0.5),
    )
    protocol = Protocol(name="p", runs=runs, axes="y-up")
    for run in runs:
        plan = build_schedule(PAPER, protocol, run)
        for model in ("reference", "statics") if run.kind == "twist" else ("reference",):
            found = predict(PAPER, plan, model=model)
            take = build_synthetic_take(
                PAPER, found.points, found.rotation, run.theta_0, CameraOptions(rate=60.0, hold=0.8, move=0.4)
            )
            session = build(protocol, {run.name: [take]}, model=model)
            assert deviate(session.runs[0]).max_deviation < 1e-3
            pulled = {"twist": [False, False, True], "back": [True, False, False]}[run.name]
            np.testing.assert_array_equal(np.isnan(session.shapes.pull[-1]), pulled)


@pytest.mark.parametrize("axes", ["z-up", "x-up", "y,z,x", "-x,y,-z", "x,y,-z"])
def test_an_export_in_other_axes_gives_the_same(axes, protocol, rehearse, tmp_path):
    """Motive's export permutes the room's axes and those of rigid bodies alike: R becomes Q R Q^T."""
    take = rehearse("bend")
    to_file = read_axes(axes).T

    def export(track):
        position = track.position @ to_file.T
        if not hasattr(track, "quaternion_wxyz"):
            return replace(track, position=position)
        return replace(track, position=position, quaternion_wxyz=turn_quaternions(track.quaternion_wxyz, to_file))

    exported = replace(take, bodies=tuple(map(export, take.bodies)), markers=tuple(map(export, take.markers)))
    path = write_motive(exported, tmp_path / "bend_1.csv")
    for orientation in ("body", "markers"):
        session = build(replace(protocol, orientation=orientation), {"bend": [path]}, axes=axes)
        plain = build(replace(protocol, orientation=orientation), {"bend": [take]})
        np.testing.assert_allclose(session.shapes.points, plain.shapes.points, atol=5e-6)
        np.testing.assert_allclose(session.shapes.rotation, plain.shapes.rotation, atol=1e-3)
        assert not any("tilted" in note for note in session.runs[0].notes)
