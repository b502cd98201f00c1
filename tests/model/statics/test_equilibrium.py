"""The equilibrium against closed forms, the paper's rest, and what it refuses."""

import math
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import ModelError, SpiralTrunkError
from spiraltrunk.model import reference, statics
from spiraltrunk.model.kinematics.shape import Status
from spiraltrunk.model.statics.equilibrium import Loads, QuasiStatic, StaticsOptions

STRICT = StaticsOptions(tolerance=1e-12)
TURN = PAPER.n_section * PAPER.delta_theta


def light(n_joint, stiffness):
    """A trunk on the paper's spiral cut finer or coarser, without weight to speak of; stiffness by joint and length."""
    cut = replace(
        PAPER, n_section=n_joint + 1, delta_theta=TURN / (n_joint + 1), gripper=None,
        mass=replace(PAPER.mass, sections=(1e-12,) * (n_joint + 1)), joint=replace(PAPER.joint, stiffness=None),
    )  # fmt: skip
    values = tuple(np.broadcast_to(stiffness(cut), n_joint).tolist())
    return replace(cut, joint=replace(cut.joint, stiffness=values))


def joint_place(design):
    """Distances of the joints from the base, shape (n_joint,) [m]."""
    return np.cumsum(design.section_length)[:-1]


def deflection(design, force):
    """Displacement of the tip of the horizontal trunk under a force, shape (3,) [m]."""
    shape = statics.solve(design, theta_0=0.0, loads=Loads(force=force), options=STRICT)
    assert shape.status == Status.CONVERGED
    return shape.points[-1] - [design.length, 0, 0]


# Closed forms.


@pytest.mark.parametrize("direction", [(0, 1, 0), (0, 0, 1), (0, -0.6, 0.8)])
def test_a_small_force_deflects_the_chain_by_levers_squared_over_stiffness(direction):
    design = light(17, lambda cut: 1e4 * cut.scale[:-1] ** 3)
    lever, force = design.length - joint_place(design), 0.1
    expected = force * (lever**2 / design.joint_stiffness).sum()
    found = deflection(design, force * np.array(direction)) @ direction
    assert found == pytest.approx(expected, rel=3e-9)


def test_a_tapered_cantilever_deflects_as_euler_and_bernoulli_say_with_the_square_of_the_joints():
    """4 P L^3 / (3 pi E r_t r_0^3) for a cone clamped at its base, r_0, and loaded at its tip, r_t."""
    wide, thin, modulus, force = 8e-3, 4e-3, 16.9e6, 1e-4

    def stiffness(cut):
        place, length = joint_place(cut), cut.length
        ends = np.concatenate([[0.0], (place[:-1] + place[1:]) / 2, [length]])
        radius = wide + (thin - wide) * place / length
        return modulus * math.pi * radius**4 / 4 / np.diff(ends)

    errors = []
    for count in (10, 20, 40, 80):
        design = light(count, stiffness)
        exact = 4 * force * design.length**3 / (3 * math.pi * modulus * thin * wide**3)
        errors.append(deflection(design, (0, force, 0))[1] / exact - 1)
    order = np.log2(np.abs(errors[:-1]) / np.abs(errors[1:]))
    assert abs(errors[-1]) < 1e-3
    np.testing.assert_allclose(order, 2.0, rtol=0, atol=0.15)


def test_a_pure_tension_straight_along_the_axis_bends_nothing():
    design = light(17, lambda _: 1.0)
    shape = statics.solve(design, theta_0=0.3, loads=Loads(force=(math.cos(0.3), -math.sin(0.3), 0)))
    assert shape.joint_angle.max() < 1e-9


def test_one_joint_bends_by_tension_times_lever_over_stiffness():
    """Two sections, cable 1 at a tension: T dL/dq = K q, L the chord 2 R sin((opening - q) / 2)."""
    design = replace(
        PAPER, n_section=2, theta_tip=PAPER.theta_base - 2 * PAPER.delta_theta, gripper=None,
        mass=replace(PAPER.mass, sections=(1e-12, 1e-12)), joint=replace(PAPER.joint, stiffness=(2.0,)),
    )  # fmt: skip
    opening, arm = design.delta_theta, float(design.hole_to_joint[0])
    shape = statics.solve(design, tension=(30.0, 0, 0), options=STRICT)
    bend = float(shape.joint_angle[0])
    length = math.hypot(2 * arm * math.sin((opening - bend) / 2), statics.SHUT)
    assert bend == pytest.approx(30.0 * arm**2 * math.sin(opening - bend) / length / 2.0, rel=1e-9)
    assert shape.gap[0, 0] == pytest.approx(length, rel=1e-12)


# The paper's rest.

LUMPED = replace(
    PAPER, gripper=None,
    mass=replace(PAPER.mass, sections=(*PAPER.mass.sections[:-1], PAPER.mass.sections[-1] + PAPER.gripper.mass)),
)  # fmt: skip
"""The paper adds the gripper's mass to the last section's, at that section's centre K_c."""

REST_DEG = {
    0: (10.27, 9.42, 8.52, 7.64, 6.82, 6.03, 5.25, 4.47, 3.73, 3.08, 2.53, 2.05, 1.62, 1.24, 0.89, 0.54, 0.20),
    -45: (11.40, 11.46, 11.21, 10.71, 10.07, 9.27, 8.33, 7.29, 6.20, 5.20, 4.31, 3.52, 2.81, 2.16, 1.55, 0.95, 0.35),
}
"""Joint angles under gravity from the paper's equations ("Resting under gravity"), base to tip, by theta_0 [deg]."""


@pytest.mark.parametrize("theta_0_deg", REST_DEG)
def test_the_trunk_rests_as_the_papers_equations_say(theta_0_deg):
    shape = statics.solve(LUMPED, theta_0=math.radians(theta_0_deg))
    np.testing.assert_allclose(np.degrees(shape.joint_angle), REST_DEG[theta_0_deg], rtol=0, atol=0.01)


@pytest.mark.parametrize("theta_0", [-1.2, -0.4, 0.0, 0.7, 1.5])
def test_rest_is_that_of_the_forward_model_on_the_designs_own_lengths(theta_0):
    shape = statics.solve(LUMPED, theta_0=theta_0, options=STRICT)
    rest = reference.rest(LUMPED, theta_0, as_authors=False)
    np.testing.assert_allclose(shape.points, rest.points, rtol=0, atol=1e-9)


# How it answers.


def test_the_status_says_how_it_ended():
    free = -PAPER.cable_stroke
    assert statics.solve(PAPER).status == Status.CONVERGED
    assert statics.solve(PAPER, pull=(0.06, free, free)).status == Status.CONVERGED
    assert statics.solve(PAPER, pull=(0.06, free, free), tension=2.0).status == Status.STALLED
    for tension in ((60.0, 60.0, 0), (60.0, 0, 0)):
        full = statics.solve(PAPER, tension=tension)
        assert full.status == Status.ALL_SHUT
        assert full.is_shut.all()
    assert "pull less" in full.advice
    few = statics.solve(PAPER, pull=(0.06, free, free), options=StaticsOptions(steps_most=2))
    assert few.status == Status.NOT_CONVERGED
    assert few.forces.residual > 1e-9
    assert np.isfinite(few.points).all()


def test_an_elastic_winder_gives_way_by_tension_over_stiffness():
    free = -PAPER.cable_stroke
    shape = statics.solve(PAPER, pull=(0.06, free, free), options=StaticsOptions(cable_stiffness=2e4))
    assert shape.cable_change[0] == pytest.approx(0.06 - shape.forces.cable_tension[0] / 2e4, abs=1e-9)
    assert shape.forces.cable_tension[0] > 1


def test_a_winder_at_its_largest_tension_is_the_same_as_that_tension():
    free = -PAPER.cable_stroke
    held = statics.solve(PAPER, pull=(0.1, free, free), tension=3.0)
    np.testing.assert_allclose(held.points, statics.solve(PAPER, tension=(3.0, 0, 0)).points, rtol=0, atol=1e-8)


def test_cables_by_length_and_by_tension_go_together():
    mixed = statics.solve(
        PAPER, pull=(0.05, 0, 0), tension=(60, 4, 0), by_tension=(False, True, True), theta_0=1.0
    )  # fmt: skip
    assert mixed.cable_change[0] == pytest.approx(0.05, abs=1e-9)
    assert mixed.forces.cable_tension[1:] == pytest.approx([4, 0], abs=1e-12)
    again = statics.solve(PAPER, tension=mixed.forces.cable_tension, theta_0=1.0)
    np.testing.assert_allclose(again.points, mixed.points, rtol=0, atol=1e-7)


# What it refuses.

BAD = [
    ({"pull": math.nan}, "pull"), ({"pull": (0, math.inf, 0)}, "pull"), ({"pull": "far"}, "pull"),
    ({"pull": (0.01, 0.02)}, "pull"), ({"pull": (0.14, 0, 0)}, "pull"), ({"pull": (-0.14, 0, 0)}, "pull"),
    ({"pull": np.zeros((2, 4))}, "pull"), ({"pull": [[0.01, 0, 0], [0.01]]}, "pull"), ({"pull": object()}, "pull"),
    ({"pull": 1j}, "pull"), ({"tension": -1.0}, "tension"), ({"tension": (61, 0, 0)}, "tension"),
    ({"tension": math.nan}, "tension"), ({"tension": "much"}, "tension"), ({"tension": (1.0,) * 4}, "tension"),
    ({"by_tension": (True, False)}, "by_tension"), ({"by_tension": (1, 0, 0)}, "by_tension"),
    ({"by_tension": (False, True, True)}, "pull"), ({"theta_0": math.nan}, "theta_0"), ({"theta_0": "up"}, "theta_0"),
    ({"roll": math.inf}, "roll"), ({"roll": None}, "roll"), ({"friction": -0.1}, "friction"),
    ({"friction": math.nan}, "friction"), ({"friction": "dry"}, "friction"),
    ({"loads": Loads(mass=-1.0)}, "loads.mass"), ({"loads": Loads(mass=math.inf)}, "loads.mass"),
    ({"loads": Loads(mass=1.0, section=18)}, "loads.section"), ({"loads": Loads(section=0.5)}, "loads.section"),
    ({"loads": Loads(force=(1, 2))}, "loads.force"),
    ({"loads": Loads(force=math.nan)}, "loads.force"), ({"loads": Loads(force=(1e5, 0, 0))}, "loads.force"),
    ({"loads": Loads(force=(1, 0, 0), force_section=-19)}, "loads.force_section"),
    ({"tension": np.full((1000, 3), "a")}, "tension"), ({"tension": np.full(3, 1j)}, "tension"),
    ({"loads": Loads(mass=np.ones(4), force=np.zeros((5, 3)))}, "batches are loads.mass"),
    ({"tension": (-1, 50, 0)}, "tension is -1"), ({"loads": Loads(mass=(-1, 500))}, "loads.mass is -1"),
    ({"loads": Loads(force=(0, -2e4, 0))}, "loads.force is -20000"),
]  # fmt: skip


@pytest.mark.parametrize(("given", "name"), BAD)
def test_what_it_cannot_answer_is_refused_in_one_line(given, name):
    with pytest.raises(SpiralTrunkError, match=rf"^{name} .*; allowed: ") as caught:
        statics.solve(PAPER, **given)
    assert isinstance(caught.value, ValueError)
    assert "\n" not in str(caught.value)


def test_batches_that_do_not_fit_are_refused():
    with pytest.raises(ModelError, match="allowed"):
        statics.solve(PAPER, pull=np.zeros((2, 3)), theta_0=np.zeros(3))


@pytest.mark.parametrize(
    ("field", "value"),
    [("hole_set_back", 0.5), ("hole_set_back", -0.1), ("cable_stiffness", 0.0), ("cable_stiffness", math.nan),
     ("increment", 0.0), ("tension_increment", -1.0), ("tolerance", 0.0), ("steps_most", 0), ("steps_most", 1.5)],
)  # fmt: skip
def test_impossible_options_are_refused(field, value):
    with pytest.raises(SpiralTrunkError, match=field):
        StaticsOptions(**{field: value})


@pytest.mark.parametrize("field", ["damping_time", "pull_speed", "tension_speed"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.inf, math.nan])
def test_impossible_quasi_static_loadings_are_refused(field, value):
    with pytest.raises(SpiralTrunkError, match=f"quasi_static.{field}"):
        QuasiStatic(**{field: value})


def test_torsion_and_hinges_exclude_each_other():
    with pytest.raises(ModelError, match="has_torsion and has_hinges"):
        StaticsOptions(has_torsion=True, has_hinges=True)


def test_the_start_is_of_the_same_trunk():
    other = statics.solve(presets.get("spirob-1m"))
    with pytest.raises(ModelError, match=r"start.gap has shape \(42, 3\); allowed: \(..., 17, 3\)"):
        statics.solve(PAPER, start=other)


def test_a_batch_of_none_is_answered():
    shape = statics.solve(PAPER, theta_0=np.zeros(0))
    assert shape.points.shape == (0, 18, 3)
    assert shape.advice == "converged"
