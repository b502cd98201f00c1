"""Calibration: what is told is found, what is not told says so, and bad input is refused in one line."""

import math
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.calibration.calibrate import Settings, Weighing, calibrate, compute_rmse, describe
from spiraltrunk.calibration.fit_problem import FitProblem, split_half
from spiraltrunk.calibration.identifiability import advise, list_unidentified
from spiraltrunk.calibration.map_fit import (
    MODEL_ERROR,
    TWIST_ALONE,
    TWISTED_SLACK,
    MapEstimate,
    add_model_error,
    inflate,
)
from spiraltrunk.calibration.noise_model import Block, NoiseModel, build_covariance, factorise, whiten
from spiraltrunk.calibration.parameters import (
    BenchStiffness,
    Prior,
    Winders,
    apply_parameters,
    build_prior,
    name_parameters,
)
from spiraltrunk.calibration.predict_states import State, find_states, predict_statics
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DesignError, ModelError
from spiraltrunk.mocap.protocol.protocol import Protocol, Run
from spiraltrunk.model.kinematics.measured_shapes import MeasuredShapes
from spiraltrunk.model.statics.pull_sequences import carry_gripper
from spiraltrunk.workflows.virtual_session.printed_trunk import draw_printed_trunk, weigh
from spiraltrunk.workflows.virtual_session.session import MeasurementOptions, measure_session, simulate_session

NAN = math.nan
RESTS = tuple(Run(name=f"rest-{t:03d}", kind="rest", theta_0=math.radians(90 - t)) for t in (0, 45, 90, 135))

BEND = State(theta_0=math.pi / 2, pull=(0.02, NAN, NAN), before=-1, kind="bend-dorsal", chain=0)
TWIST = State(theta_0=math.pi / 2, pull=(0.06, -0.02, NAN), before=-1, kind="twist", chain=1)


def _measure(runs, seed=4, **how):
    world = draw_printed_trunk(PAPER, seed)
    played = simulate_session(PAPER, world, Protocol(name="short", runs=runs), is_simulated=False)
    return world, measure_session(PAPER, played, seed, MeasurementOptions(**how))


@pytest.fixture(scope="module")
def bent():
    """A world bent in 6 steps of 20 mm and at rest at one tilt, measured exactly, and its calibration."""
    runs = (RESTS[1], RESTS[2], Run(name="bend-dorsal", kind="bend-dorsal", steps=6, step=0.02))
    world, shapes = _measure(runs, noise=1e-5, turn=1e-6, shift=1e-6, sections=tuple(range(1, 19)))
    mass, _ = weigh(PAPER, world, 2e-6)
    fitted = np.isin(shapes.take, ("rest-090_1", "bend-dorsal_1"))
    settings = Settings(weighing=Weighing(mass=mass, spread=2e-6))
    return world, calibrate(PAPER, shapes, fitted, settings)


@pytest.mark.slow
def test_a_trunk_measured_exactly_is_found(bent):
    world, found = bent
    joints = dict(zip(found.names, found.fit.values - world.values, strict=True))
    assert max(abs(joints[f"stiffness_{i:02d}"]) for i in range(1, 17)) < 0.05
    assert abs(joints["friction"]) < 0.005
    assert abs(joints["slack_1"]) < 1e-4
    assert abs(joints["hole"]) < 1e-3


@pytest.mark.slow
def test_the_error_on_shapes_held_out_falls_to_a_twentieth(bent):
    _, found = bent
    assert found.held_out.calibrated.mean() < found.held_out.uncalibrated.mean() / 20
    assert found.held_out.calibrated.mean() < 1e-3


@pytest.mark.slow
def test_the_calibrated_design_is_what_the_parameters_say(bent):
    _, found = bent
    said = {parameter.name: parameter.value for parameter in found.parameters}
    np.testing.assert_allclose(found.design.joint_stiffness, [said[f"stiffness_{i + 1:02d}"] for i in range(17)])
    assert found.design.cable.friction == pytest.approx(said["friction"])
    assert found.design.total_mass == pytest.approx(said["mass"])
    assert found.design.gripper is not None


@pytest.mark.slow
def test_rest_alone_tells_neither_cables_nor_mass():
    _, shapes = _measure(RESTS)
    found = calibrate(PAPER, shapes, np.array([take.endswith("_1") for take in shapes.take]))
    untold = {parameter.name: parameter.width_ratio for parameter in list_unidentified(found)}
    for name in ("friction", "slack_1", "hole"):
        assert untold[name] == pytest.approx(1.0, abs=1e-6)
    assert untold["mass"] > 0.9
    assert "stiffness_over_mass" not in untold
    words = advise(found, was_weighed=False)
    assert "ratio alone" in words[0]
    assert any(line.startswith("slack_1") for line in words)


@pytest.mark.parametrize("factor", [0.5, 3.0])
def test_stiffness_and_mass_together_leave_shapes_with_friction_as_they_are(factor):
    """The law on which the advice rests."""
    _, shapes = _measure((Run(name="bend-dorsal", kind="bend-dorsal", steps=4, step=0.02),))
    states, names = find_states(shapes)[0], name_parameters(PAPER)
    values = np.zeros(len(names))
    values[names.index("friction")] = 0.2
    ends = []
    for shift in (0.0, math.log(factor)):
        turned = values + shift * np.array([name.startswith("stiffness") or name == "mass" for name in names])
        design, winders = apply_parameters(carry_gripper(PAPER), turned)
        ends.append(predict_statics(design, states, winders).points)
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=2e-5)


@pytest.mark.parametrize(("exponent", "level"), [(3.0, 0.0), (2.5, 0.3), (3.4, -0.2)])
def test_the_exponent_of_a_power_law_is_told(exponent, level):
    """Of joints K_i = c scale_i^n exactly n is told, and the mean over the mass, which c moves."""
    prior = build_prior(PAPER, Prior())
    law = exponent * np.log(PAPER.scale[:-1]) + level
    values = np.zeros(len(prior.names))
    values[: PAPER.n_joint] = law - np.log(PAPER.joint_stiffness)
    values[prior.names.index("mass")] = 0.1
    fit = MapEstimate(values=values, covariance=0.01 * prior.covariance, misfits=(), n_outlier=0, has_converged=True)
    told = {one.name: one for one in describe(PAPER, fit, prior)}
    found, ratio = told["stiffness_exponent"], told["stiffness_over_mass"]
    assert found.value == pytest.approx(exponent, rel=1e-9)
    assert ratio.value == pytest.approx(math.exp(law.mean()) / (PAPER.total_mass * math.exp(0.1)), rel=1e-9)
    for one in (found, ratio):
        assert one.low < one.value < one.high
        assert one.width_ratio == pytest.approx(0.1)


def test_repeated_commands_are_one_state():
    _, shapes = _measure((RESTS[0], Run(name="bend-dorsal", kind="bend-dorsal", steps=3, step=0.01)))
    states, of_shape = find_states(shapes)
    half = len(shapes.kind) // 2
    assert (of_shape[:half] == of_shape[half:]).all()
    assert len(states) == len(set(of_shape.tolist()))


def test_slack_is_cable_that_is_not_pulled():
    _, shapes = _measure((Run(name="bend-dorsal", kind="bend-dorsal", steps=3, step=0.02),))
    states = find_states(shapes)[0]
    trunk = carry_gripper(replace(PAPER, cable=replace(PAPER.cable, friction=0.1)))
    late = tuple(replace(state, pull=(state.pull[0] + 0.004, NAN, NAN)) for state in states)
    taut, slack = Winders(slack=np.zeros(3)), Winders(slack=np.full(3, 0.004))
    np.testing.assert_allclose(
        predict_statics(trunk, late, slack).points, predict_statics(trunk, states, taut).points, atol=1e-6
    )


def test_a_winder_gives_as_much_as_its_tension_says():
    """Gaps and give together are the cable that the command left."""
    _, shapes = _measure((Run(name="bend-dorsal", kind="bend-dorsal", steps=2, step=0.03),))
    states, trunk = find_states(shapes)[0], carry_gripper(replace(PAPER, cable=replace(PAPER.cable, friction=0.2)))
    played = predict_statics(trunk, states, Winders(slack=np.zeros(3), compliance=1e-4))
    for shape, length in zip(played.shapes[1:], played.length[1:], strict=True):
        assert shape.forces is not None
        given = shape.gap.sum(axis=0)[0] - length[0]
        assert given == pytest.approx(1e-4 * shape.forces.cable_tension[0], rel=1e-6)
        assert given > 2e-4


def test_whitened_residuals_have_the_covariance_that_was_asked_for():
    draw = np.random.default_rng(0)
    block = Block(
        points=draw.standard_normal((4, 3)), at=np.zeros((4, 2), int), lever=np.eye(4) * np.linspace(0.2, 1, 4),
        stroke=np.zeros(4), weight=np.ones(4),
    )  # fmt: skip
    noise = NoiseModel()
    whole = build_covariance(block, noise)
    white = whiten(factorise(block, noise), np.linalg.cholesky(whole))
    np.testing.assert_allclose(white @ white.T, np.eye(12), atol=1e-9)


def test_halves_that_agree_leave_the_covariance_and_others_widen_it():
    covariance, middle = np.diag([1.0, 1.0, 1.0, 1.0]), np.zeros(4)
    np.testing.assert_array_equal(inflate(covariance, middle, [middle, middle], 3), covariance)
    apart = np.array([0.0, 0.0, 0.0, 8.0])
    wide = inflate(covariance, middle, [apart / 2, -apart / 2], 3)
    np.testing.assert_allclose(np.sqrt(np.diag(wide)), [1, 1, 1, 4])


def test_the_models_own_error_is_in_what_recordings_tell_and_no_more_than_was_known():
    prior = build_prior(PAPER, Prior())
    k = prior.names.index("friction")
    sharp = 1e-4 * prior.covariance
    told = add_model_error(sharp, prior, (BEND,))
    assert told[k, k] == pytest.approx(sharp[k, k] + MODEL_ERROR["friction"] ** 2)
    told[k, k] = sharp[k, k]
    np.testing.assert_array_equal(told, sharp)
    for states in ((BEND,), (TWIST,), (BEND, TWIST)):
        np.testing.assert_allclose(add_model_error(prior.covariance, prior, states), prior.covariance)


def test_the_models_error_in_a_twist_is_in_the_slack_of_the_cable_that_nothing_else_pulls():
    prior = build_prior(PAPER, Prior())
    sharp = 1e-4 * prior.covariance
    more = np.diag(add_model_error(sharp, prior, (BEND, TWIST)) - add_model_error(sharp, prior, (BEND,)))
    assert more[prior.names.index("slack_2")] == pytest.approx(TWISTED_SLACK**2)
    assert np.count_nonzero(more) == 1


def test_a_twist_without_a_bending_doubles_every_interval_up_to_its_priors():
    """The parameters absorb an error that is common to all states of a twist."""
    prior = build_prior(PAPER, Prior())
    spread = 0.25 * prior.spread
    spread[:2] = 0.7 * prior.spread[:2]
    wide = np.sqrt(np.diag(add_model_error(np.diag(spread**2), prior, (TWIST,))))
    own = [i for i, name in enumerate(prior.names) if name not in ("friction", "slack_1", "slack_2")]
    np.testing.assert_allclose(wide[own], np.minimum(TWIST_ALONE * spread, prior.spread)[own])
    at = [prior.names.index(name) for name in ("friction", "slack_1", "slack_2")]
    errors = np.array([MODEL_ERROR["friction"], TWISTED_SLACK, TWISTED_SLACK])
    np.testing.assert_allclose(wide[at], np.hypot(TWIST_ALONE * spread[at], errors))


def test_each_half_has_its_own_steps_and_all_rests():
    _, shapes = _measure((RESTS[0], Run(name="bend-dorsal", kind="bend-dorsal", steps=7, step=0.01)))
    states = find_states(shapes)[0]
    size = (len(states), 18)
    problem = FitProblem(
        design=carry_gripper(PAPER),
        states=states,
        marker_offset=shapes.marker_offset,
        measured=np.zeros((*size, 3)),
        count=np.ones(size, int),
    )
    pulls = [[s.pull[0] for s in split_half(problem, odd).states] for odd in (0, 1)]
    seen = [p for half in pulls for p in half if not np.isnan(p)]
    assert len(seen) == len(set(seen)) == sum(s.kind == "bend-dorsal" for s in states)
    assert all(np.isnan(half).sum() == 1 for half in pulls)


def test_a_weighing_narrows_the_mass_alone():
    plain = build_prior(PAPER, Prior())
    weighed = build_prior(PAPER, Prior(), Weighing(mass=1.1 * PAPER.total_mass, spread=0.01 * PAPER.total_mass))
    at = plain.names.index("mass")
    assert weighed.spread[at] < 0.02 < plain.spread[at]
    assert weighed.mean[at] == pytest.approx(math.log(1.1), abs=2e-3)
    others = np.arange(len(plain.names)) != at
    np.testing.assert_array_equal(weighed.covariance[others][:, others], plain.covariance[others][:, others])


def test_a_bench_narrows_its_joint_and_shifts_the_others_with_it():
    plain = build_prior(PAPER, Prior())
    told = 1.3 * float(PAPER.joint_stiffness[4])
    known = build_prior(PAPER, Prior(), bench=(BenchStiffness(joint=5, value=told, spread=0.05),))
    prior = plain.spread[4]
    assert known.spread[4] == pytest.approx((1 / prior**2 + 1 / 0.05**2) ** -0.5)
    assert known.mean[4] == pytest.approx(math.log(1.3) * prior**2 / (prior**2 + 0.05**2))
    assert 0.1 < known.mean[0] < known.mean[4]
    assert known.spread[5] < 0.7 * plain.spread[5]
    np.testing.assert_array_equal(known.mean[17:], plain.mean[17:])
    many = tuple(BenchStiffness(joint=j, value=told, spread=0.1) for j in (1, 5, 5))
    assert np.linalg.eigvalsh(build_prior(PAPER, Prior(), bench=many).covariance[:17, :17]).min() > 0


@pytest.mark.parametrize(("joint", "value", "words"), [(18, 0.3, "1 to 17"), (2, 1e4, "same trunk")])
def test_a_bench_of_another_trunk_is_refused(joint, value, words):
    with pytest.raises(ModelError, match=words):
        build_prior(PAPER, Prior(), bench=(BenchStiffness(joint=joint, value=value, spread=0.1),))


def test_rmse_is_over_what_was_seen():
    measured = np.zeros((2, 3, 3))
    measured[0, 1], measured[1] = NAN, NAN
    predicted = np.ones((2, 3, 3))
    got = compute_rmse(predicted, measured)
    assert got[0] == pytest.approx(math.sqrt(3))
    assert math.isnan(got[1])


@pytest.mark.parametrize(
    ("bad", "words"),
    [({"mass": 5.0, "spread": 0.01}, "factor of four"), ({"mass": NAN, "spread": 1.0}, "weighing.mass")],
)
def test_bad_weighings_are_refused(bad, words):
    with pytest.raises((DesignError, ModelError), match=words):
        build_prior(PAPER, Prior(), Weighing(**bad))


def test_bad_choices_are_refused():
    _, shapes = _measure((RESTS[0],))
    for chosen in (np.zeros(2, bool), np.zeros(5, bool), np.ones(2)):
        with pytest.raises(ModelError, match="fitted"):
            calibrate(PAPER, shapes, chosen)
    unseen = replace(shapes, points=np.full_like(shapes.points, NAN))
    with pytest.raises(ModelError, match="no point"):
        calibrate(PAPER, unseen, np.ones(2, bool))
    fewer = MeasuredShapes(
        kind=shapes.kind, take=shapes.take, theta_0=shapes.theta_0, pull=shapes.pull, follows=shapes.follows,
        marker_offset=shapes.marker_offset[:5], points=shapes.points[:, :5], rotation=shapes.rotation[:, :5],
    )  # fmt: skip
    with pytest.raises(ModelError, match="allowed for this design"):
        calibrate(PAPER, fewer, np.ones(2, bool))
