"""Virtual session: it says what it is, its files read like any other, and the same seed gives the same session."""

import math
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.calibration.predict_states import place_markers
from spiraltrunk.cli import main
from spiraltrunk.design import design_from_rules, load_design, write_design
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import ModelError
from spiraltrunk.mocap.protocol.protocol import Protocol, Run
from spiraltrunk.mocap.protocol.schedule import build_schedule
from spiraltrunk.mocap.protocol.toml import load_protocol
from spiraltrunk.mocap.recordings.load import load_take
from spiraltrunk.mocap.recordings.take import SYNTHETIC
from spiraltrunk.mocap.session.session import SessionSettings, read_session
from spiraltrunk.mocap.signal.registration import Alignment
from spiraltrunk.model.kinematics.measured_shapes import compute_marker_offset
from spiraltrunk.workflows.virtual_session import session as session_module
from spiraltrunk.workflows.virtual_session.cameras import NAME, record_run
from spiraltrunk.workflows.virtual_session.printed_trunk import PrintOptions, draw_printed_trunk, weigh
from spiraltrunk.workflows.virtual_session.session import measure_session, simulate_session, write_session
from spiraltrunk.workflows.virtual_session.simulate import simulate_run, solve_run

SHORT = Protocol(
    name="short",
    runs=(
        Run(name="rest-045", kind="rest", theta_0=math.pi / 4),
        Run(name="bend-dorsal", kind="bend-dorsal", steps=4, step=0.005),
    ),
)


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    folder = tmp_path_factory.mktemp("takes")
    world = draw_printed_trunk(PAPER, 2)
    played = simulate_session(PAPER, world, SHORT, is_simulated=False)
    return folder, played, write_session(PAPER, played, 2, folder)


def test_files_say_that_they_are_no_measurement(session):
    _, _, files = session
    takes = [path for path in files if path.suffix == ".csv"]
    assert len(takes) == 4
    for path in takes:
        header = path.read_text().splitlines()[0]
        assert NAME in header
        assert SYNTHETIC in header


def test_files_read_back_as_the_shapes_that_were_played(session):
    """Through noise, gaps, poses held over, missing frames and a frame of the cameras' own."""
    folder, played, _ = session
    protocol = load_protocol(folder / "protocol.toml")
    takes = {run.schedule.run.name: [folder / f"{run.schedule.run.name}_1.csv"] for run in played}
    shapes = read_session(protocol, takes, SessionSettings(design=PAPER, alignment=Alignment(kind="base")))
    truth = np.concatenate([place_markers(PAPER, run.ends, compute_marker_offset(PAPER)) for run in played])
    away = np.linalg.norm(shapes.points - truth, axis=-1)
    assert np.isfinite(away).sum() == 6 * 15
    # The base's axes, from three markers at 44 mm and 100 frames, are known to 0.9 mrad: five times that at the tip.
    assert np.nanmax(away) < 2.5e-3


@pytest.mark.parametrize("n_cable", [2, 3])
def test_the_protocol_that_is_written_plans_the_pulls_that_were_played(tmp_path, n_cable):
    """With its slack and its design, whichever the number of cables."""
    angles = tuple(2 * math.pi * i / n_cable for i in range(n_cable))
    design = replace(PAPER, name="mine", cable=replace(PAPER.cable, angles=angles))
    source = replace(SHORT, slack=(0.009, 0.003, 0.001)[:n_cable])
    played = simulate_session(design, draw_printed_trunk(design, 2), source, is_simulated=False)
    files = write_session(design, played, 2, tmp_path)
    assert tmp_path / "trunk.toml" in files
    written = load_protocol(tmp_path / "protocol.toml")
    assert written.slack == source.slack
    assert load_design(written.design) == design
    for run in played:
        plan = build_schedule(design, written, written.run(run.schedule.run.name))
        np.testing.assert_allclose(plan.commanded, run.schedule.commanded, rtol=0, atol=1e-12)


def test_a_preset_is_named_and_not_written(session):
    folder, _, files = session
    assert load_protocol(folder / "protocol.toml").design == "paper"
    assert folder / "trunk.toml" not in files


def test_a_shorter_trunk_has_markers_on_the_sections_that_it_has(tmp_path):
    design = design_from_rules(b=0.16, turns=10 / 12)
    played = simulate_session(design, draw_printed_trunk(design, 2), SHORT, is_simulated=False)
    write_session(design, played, 2, tmp_path)
    protocol = load_protocol(tmp_path / "protocol.toml")
    shapes = read_session(protocol, {"rest-045": [tmp_path / "rest-045_1.csv"]}, SessionSettings(design=design))
    assert (np.flatnonzero(np.isfinite(shapes.points).all(axis=(0, 2))) + 1).tolist() == [2, 4, 6, 7, 8, 9, 10]


def test_too_few_sections_for_markers_are_refused_before_the_simulation(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(session_module, "simulate_session", lambda *_, **__: pytest.fail("simulated"))
    mass = replace(PAPER.mass, sections=PAPER.mass.sections[:5])
    write_design(replace(PAPER, name="five", n_section=5, theta_tip=6.0, mass=mass), tmp_path / "five.toml")
    assert main(["calibrate", "--virtual", str(tmp_path / "out"), "--design", str(tmp_path / "five.toml")]) == 2
    said = capsys.readouterr().err
    assert "has 5 sections, with markers on 2, 4; allowed in a virtual session: markers on 3 or more" in said
    assert said.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_gaps_and_held_poses_are_in_the_file(session):
    folder, _, _ = session
    take = load_take(folder / "bend-dorsal_1.csv", axes="y-up")
    assert any(np.isnan(body.position).any() for body in take.bodies)
    assert any(body.is_stale.any() for body in take.bodies)
    assert (np.diff(take.frame) > 1).any()
    assert not np.isnan(take.body("base").position).any()


def test_the_same_seed_gives_the_same_session():
    one, other, third = (draw_printed_trunk(PAPER, seed) for seed in (5, 5, 6))
    assert one.design == other.design != third.design
    plan = build_schedule(PAPER, SHORT, SHORT.runs[1])
    played = solve_run(one, plan)
    first, again = (record_run(PAPER, played, 3) for _ in range(2))
    np.testing.assert_array_equal(first.bodies[3].position, again.bodies[3].position)
    one, other = (measure_session(PAPER, [played], 1) for _ in range(2))
    np.testing.assert_array_equal(one.points, other.points)


def test_no_two_takes_share_their_noise(tmp_path):
    """The protocol allows a hundred takes of a run: the eleventh was the next run's first."""
    runs = tuple(Run(name=name, kind="rest", takes=11) for name in ("a", "b"))
    played = simulate_session(PAPER, draw_printed_trunk(PAPER, 2), Protocol(name="p", runs=runs), is_simulated=False)
    write_session(PAPER, played, 2, tmp_path)
    takes = [load_take(tmp_path / name, axes="y-up") for name in ("a_1.csv", "a_2.csv", "a_11.csv", "b_1.csv")]
    first = {take.body("base").position[0].tobytes() for take in takes}
    assert len(first) == len(takes)


def test_worlds_are_off_by_what_was_asked():
    options = PrintOptions(stiffness_scatter=0.0, center=0.0, hole=0.0)
    ratios = [draw_printed_trunk(PAPER, s, options).design.joint_stiffness / PAPER.joint_stiffness for s in range(12)]
    assert {round(float(r), 9) for ratio in ratios for r in ratio} == {0.8, 1.2}
    world = draw_printed_trunk(PAPER, 0, options)
    assert world.design.section_mass.sum() / PAPER.total_mass in (pytest.approx(0.9), pytest.approx(1.1))
    mass, spread = weigh(PAPER, world)
    assert abs(mass - world.design.section_mass.sum()) < 4 * spread


def test_without_friction_the_simulation_plays_what_the_model_plays():
    world = draw_printed_trunk(PAPER, 1, PrintOptions(friction=0.0, slack=0.0))
    for run in (SHORT.runs[0], Run(name="bend-dorsal", kind="bend-dorsal", steps=1, step=0.02)):
        plan = build_schedule(PAPER, SHORT, run)
        simulated, solved = simulate_run(world, plan), solve_run(world, plan)
        assert simulated.unsettled == 0
        assert np.linalg.norm(simulated.ends - solved.ends, axis=-1).max() < 2e-3


def test_pulled_slowly_and_softly_friction_holds_as_in_the_model():
    """Abrupt pulls at 10 mm/s would shake the cables loose: 2 mm, which a calibration takes for less friction."""
    world = draw_printed_trunk(PAPER, 301)
    plan = build_schedule(PAPER, SHORT, Run(name="bend-dorsal", kind="bend-dorsal", steps=4, step=0.01))
    simulated, solved = simulate_run(world, plan), solve_run(world, plan)
    assert simulated.unsettled == 0
    assert np.linalg.norm(simulated.ends - solved.ends, axis=-1).max() < 0.7e-3


def test_sag_bends_the_simulated_trunk_and_is_not_the_models():
    world = draw_printed_trunk(PAPER, 1, PrintOptions(sag=math.radians(0.3)))
    plan = build_schedule(PAPER, SHORT, Run(name="rest-000", kind="rest"))
    assert abs(simulate_run(world, plan).ends[0, -1, 2]) > 1e-4
    with pytest.raises(ModelError, match="sag"):
        solve_run(world, plan)
