"""The trunk as a mechanism: statics against an independent equilibrium, energy, joint limits, full pull."""

import itertools
import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from scipy.optimize import fsolve

from spiraltrunk.design import presets
from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.rules import design_from_rules
from spiraltrunk.sim.robot.trunk import NEIGHBOURS, cable_name, hinge_names, hinge_order, trunk_spec

BARE = replace(PAPER, gripper=None)
"""The paper's trunk without its gripper: the closed form knows sections alone."""


def _hinges(model, design):
    """Addresses of the hinges about y and z, shape (n_joint, 2)."""
    return np.array([[model.joint(name).qposadr[0] for name in hinge_names(i)] for i in range(design.n_joint)])


def _bends(model, data, design):
    """Angles between neighbouring axes, from the bodies' frames [rad]."""
    axes = [data.body(f"section_{n + 1:02d}").xmat.reshape(3, 3)[:, 0] for n in range(design.n_section)]
    return np.array([math.acos(min(1.0, float(a @ b))) for a, b in itertools.pairwise(axes)])


def _step(model, data, seconds):
    mujoco.mj_step(model, data, round(seconds / model.opt.timestep))
    mujoco.mj_forward(model, data)


def _rotation(about, angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]] if about == "y" else [[c, -s, 0], [s, c, 0], [0, 0, 1]])


def _equilibrium(design, down):
    """Hinge angles (about y, z) at which springs balance the weights beyond them; ``down`` in the base frame."""
    order = [tuple(name[-1] for name in hinge_order(i)) for i in range(design.n_joint)]
    weight = 9.81 * design.section_mass[:, None] * down

    def residual(flat):
        q = flat.reshape(-1, 2)
        turns, starts = [np.eye(3)], [np.zeros(3)]
        for i, names in enumerate(order):
            turn = turns[-1]
            starts.append(starts[-1] + design.section_length[i] * turn[:, 0])
            for about in names:
                turn = turn @ _rotation(about, q[i, "yz".index(about)])
            turns.append(turn)
        centers = np.array([s + c * t[:, 0] for s, c, t in zip(starts, design.section_center, turns, strict=True)])
        out = np.zeros_like(q)
        for i, names in enumerate(order):
            moment = np.cross(centers[i + 1 :] - starts[i + 1], weight[i + 1 :]).sum(axis=0)
            # The first hinge turns about its axis in the section before, the second in the section beyond.
            for about, frame in zip(names, (turns[i], turns[i + 1]), strict=True):
                k = "yz".index(about)
                out[i, k] = design.joint_stiffness[i] * q[i, k] - moment @ frame[:, 1 + k]
        return out.ravel()

    solution, _, found, _ = fsolve(residual, np.zeros(2 * design.n_joint), full_output=True)
    assert found == 1
    return solution.reshape(-1, 2)


@pytest.mark.parametrize("tilt", [pytest.param(0.0, marks=pytest.mark.slow), 45.0, 90.0])
@pytest.mark.parametrize("name", ["paper", "spirob-15"])
def test_the_trunk_settles_where_its_weight_is_balanced(build_trunk, name, tilt):
    design = replace(presets.get(name), gripper=None)
    model = build_trunk(design, tilt)
    model.dof_damping *= 10  # Where it rests does not depend on it; when does.
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    down = data.site("trunk_base").xmat.reshape(3, 3).T @ [0, 0, -1.0]
    expected = _equilibrium(design, down)
    _step(model, data, 8.0)
    measured = data.qpos[_hinges(model, design)]
    np.testing.assert_allclose(measured, expected, rtol=0, atol=math.radians(0.03))
    sag = np.abs(np.degrees(expected)).max()
    assert (sag > 3.0) if (name, tilt) == ("paper", 90.0) else (sag < 30.0)


def _swing(model, steps):
    """Potential and kinetic energy of an undamped swing from the straight trunk at each step [J]."""
    model.dof_damping[:] = 0.0
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    data, middle = mujoco.MjData(model), mujoco.MjData(model)
    energy = []
    for _ in range(steps):
        position, before = data.qpos.copy(), data.qvel.copy()
        mujoco.mj_step(model, data)
        # The integrator's velocities belong to the middles of the steps: their mean belongs to the position between.
        is_staggered = model.opt.integrator != mujoco.mjtIntegrator.mjINT_RK4
        middle.qpos[:], middle.qvel[:] = position, (before + data.qvel) / 2 if is_staggered else before
        mujoco.mj_forward(model, middle)
        energy.append(middle.energy.copy())
    return np.array(energy).T


@pytest.mark.parametrize("tilt", [pytest.param(30.0, marks=pytest.mark.slow), 60.0])
def test_an_undamped_swing_keeps_its_energy(build_trunk, tilt):
    """Over 3 s it stays within 0.2 % of the weight times the length, and twice as close at half the step."""
    drift = []
    for step in (1e-3, 5e-4):
        model = build_trunk(BARE, tilt)
        model.opt.timestep = step
        potential, kinetic = _swing(model, round(3.0 / step))
        drift.append(np.ptp(potential + kinetic))
        assert kinetic.max() > 0.01
    assert drift[0] <= 0.002 * BARE.total_mass * 9.81 * BARE.length
    assert drift[1] < 0.65 * drift[0]


def test_the_swing_is_conservative(build_trunk):
    """A Runge-Kutta scheme of fourth order leaves no drift: what the other one shows is its own, not the model's."""
    model = build_trunk(BARE, 60.0)
    model.opt.timestep, model.opt.integrator = 5e-4, mujoco.mjtIntegrator.mjINT_RK4
    potential, kinetic = _swing(model, 2000)
    assert np.ptp(potential + kinetic) <= 1e-5 * kinetic.max()


def _largest_bend(model, design, seconds, pull, tension):
    """Largest bend [deg] while the cables are pulled in within half a second and then held."""
    largest, data = 0.0, mujoco.MjData(model)
    for n in range(round(seconds / 0.01)):
        pull(model, design, np.array(tension) * min(1.0, n / 50))
        mujoco.mj_step(model, data, 10)
        largest = max(largest, float(_bends(model, data, design).max()))
    assert sum(warning.number for warning in data.warning) == 0
    assert np.isfinite(data.qpos).all()
    return math.degrees(largest)


@pytest.mark.parametrize(
    ("tension", "duration"),
    [
        pytest.param((0, 60, 60), 12.0, id="ventral"),
        pytest.param((0, 60, 60), 60.0, id="ventral for a minute", marks=pytest.mark.slow),
        pytest.param((60, 0, 0), 60.0, id="dorsal for a minute", marks=pytest.mark.slow),
    ],
)
def test_full_pull_stays_within_the_joints_limits(build_trunk, pull, tension, duration):
    model = build_trunk(PAPER)
    assert 29.0 < _largest_bend(model, PAPER, duration, pull, tension) <= 33.0


@pytest.mark.parametrize("tilt", [*(pytest.param(tilt, marks=pytest.mark.slow) for tilt in (89.0, 90.0)), 90.5])
@pytest.mark.parametrize("tension", [(0, 60, 60), (60, 0, 0)], ids=["ventral", "dorsal"])
def test_a_horizontal_base_curls_without_harm(build_trunk, pull, tilt, tension):
    model = build_trunk(PAPER, tilt)
    assert 29.0 < _largest_bend(model, PAPER, 4.0, pull, tension) <= 33.0


@pytest.mark.parametrize("tilt", [0.0, 90.0])
def test_a_joint_limits_inverse_inertia_is_taken_where_it_acts(build_trunk, tilt):
    """Compiled in the straight trunk, where the limited distance is stationary, it is nil; bent joints give it.

    By the definition J M^-1 J', with J the derivative of the distance, taken here by differences.
    """
    raw, tuned = build_trunk(PAPER, tilt, tuned=False), build_trunk(PAPER, tilt)
    limits = [raw.tendon(f"limit_{i + 1:02d}").id for i in range(PAPER.n_joint)]
    assert (raw.tendon_invweight0[limits] < 1e-9).all()
    assert (tuned.tendon_invweight0[limits] > 0.1).all()
    hinges, data = _hinges(tuned, PAPER), mujoco.MjData(tuned)
    data.qpos[hinges[:, 1]] = PAPER.joint_limit
    mujoco.mj_forward(tuned, data)
    inertia = np.zeros((tuned.nv, tuned.nv))
    mujoco.mj_fullM(tuned, data, inertia)
    for i in (0, 8, PAPER.n_joint - 1):
        row = np.zeros(tuned.nv)
        for v in range(tuned.nv):
            ends = []
            for step in (-1e-6, 1e-6):
                data.qpos[hinges[:, 1]] = PAPER.joint_limit
                other = np.setdiff1d(np.arange(tuned.nq), hinges[:, 1])
                data.qpos[other] = 0.0
                data.qpos[v] += step
                mujoco.mj_fwdPosition(tuned, data)
                ends.append(data.ten_length[limits[i]])
            row[v] = (ends[1] - ends[0]) / 2e-6
        assert tuned.tendon_invweight0[limits[i]] == pytest.approx(row @ np.linalg.solve(inertia, row), rel=1e-4)


def test_without_it_a_curl_diverges(build_trunk, pull, capfd, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its warnings to a file there.
    model = build_trunk(PAPER, 90.0, tuned=False)
    data = mujoco.MjData(model)
    pull(model, PAPER, (0, 60, 60))
    largest = 0.0
    for _ in range(100):
        mujoco.mj_step(model, data, 20)
        largest = max(largest, float(_bends(model, data, PAPER).max()))
    capfd.readouterr()  # And to the screen.
    assert largest > math.radians(33.0)


@pytest.mark.parametrize("apart", [40, pytest.param(20, marks=pytest.mark.slow)])
def test_the_joint_limit_is_a_cone(build_trunk, pull, apart):
    """Pulled with 60 N in any direction, weightless, all joints stop at the same angle."""
    model = build_trunk(BARE)
    model.opt.gravity[:] = 0.0
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    largest = []
    for towards in np.arange(0, 360, apart):
        data = mujoco.MjData(model)
        pull(model, BARE, _towards(math.radians(towards), 60.0))
        _step(model, data, 3.0)
        largest.append(math.degrees(_bends(model, data, BARE).max()))
    assert np.ptp(largest) <= 1.0
    assert min(largest) > 29.5
    assert max(largest) < 33.0


def _towards(angle, tension):
    """Tensions of two neighbouring cables whose resultant points to ``angle``."""
    for first, second in ((0, 1), (1, 2), (2, 0)):
        a, b = PAPER.cable.angles[first], PAPER.cable.angles[second]
        parts = np.linalg.solve([[math.cos(a), math.cos(b)], [math.sin(a), math.sin(b)]],
                                [math.cos(angle), math.sin(angle)])  # fmt: skip
        if (parts > -1e-9).all():
            out = np.zeros(3)
            out[[first, second]] = tension * np.maximum(parts, 0.0)
            return out
    raise AssertionError(angle)


def test_a_cable_pulls_to_its_side(build_trunk, pull):
    for c, angle in enumerate(PAPER.cable.angles):
        model = build_trunk(BARE)
        data = mujoco.MjData(model)
        pull(model, BARE, np.eye(3)[c] * 20.0)
        _step(model, data, 2.0)
        base = data.site("trunk_base")
        tip = base.xmat.reshape(3, 3).T @ (data.site("end_18").xpos - base.xpos)
        assert math.cos(math.atan2(tip[2], tip[1]) - angle) > 0.99


@pytest.mark.parametrize("name", presets.NAMES)
def test_sections_that_may_pass_through_each_other_never_meet(build_trunk, name):
    """Neighbours that do not collide: within the joints' cone, solids touch where faces meet and overlap nowhere."""
    design = presets.get(name)
    model = build_trunk(design)
    hinges, data, rng = _hinges(model, design), mujoco.MjData(model), np.random.default_rng(0)
    solids = [model.geom(f"section_{n + 1:02d}").id for n in range(design.n_section)]
    for draw in range(30):
        # At the limit, each joint its own way; at the limit, all one way; below the limit.
        towards = rng.uniform(0, 2 * math.pi, design.n_joint)
        towards = np.full(design.n_joint, towards[0]) if draw % 3 == 1 else towards
        angle = design.joint_limit * (np.sqrt(rng.uniform(size=design.n_joint)) if draw % 3 == 2 else 1.0)
        about_y = angle * np.cos(towards)
        about_z = np.arccos(np.minimum(1.0, np.cos(angle) / np.cos(about_y))) * np.sign(np.sin(towards))
        data.qpos[hinges] = np.stack([about_y, about_z], axis=-1)
        mujoco.mj_kinematics(model, data)
        np.testing.assert_allclose(_bends(model, data, design), angle, rtol=0, atol=1e-6)
        for n, away in ((n, away) for n in range(design.n_section) for away in range(1, NEIGHBOURS + 1)):
            if n + away < design.n_section:
                gap = mujoco.mj_geomDistance(model, data, solids[n], solids[n + away], 1.0, None)
                # The prism of equal area is 1.3 % wider than the section at its corners.
                assert gap > (-0.01 if away == 1 else 0.2) * design.section_radius[n]


def test_sections_further_apart_collide_with_each_other(build_trunk):
    model = build_trunk(PAPER)
    excluded = {tuple(sorted((int(pair) >> 16, int(pair) & 0xFFFF))) for pair in model.exclude_signature}
    bodies = [model.body(f"section_{n + 1:02d}").id for n in range(PAPER.n_section)]
    for i, first in enumerate(bodies):
        for j, second in enumerate(bodies[i + 1 :], start=i + 1):
            assert (tuple(sorted((first, second))) in excluded) == (j - i <= NEIGHBOURS)


@pytest.mark.parametrize("ctrl", [0.0, 0.3, 10.0])
def test_cables_never_push(build_trunk, pull, ctrl):
    """Whatever length the winder holds: the force on the cable is between full pull and nothing."""
    model = build_trunk(PAPER)
    pull(model, PAPER, (60, 60, 60))
    data = mujoco.MjData(model)
    motors = [model.actuator(cable_name(c)).id for c in range(3)]
    for _ in range(300):
        data.ctrl[motors] = ctrl
        mujoco.mj_step(model, data)
        assert (data.actuator_force[motors] <= 0.0).all()
        assert (data.actuator_force[motors] >= -60.0).all()
    if ctrl == 10.0:  # Far longer than the path: slack.
        assert (data.actuator_force[motors] == 0.0).all()


def test_slack_cables_leave_the_hanging_trunk_straight(build_trunk):
    model = build_trunk(PAPER)
    data = mujoco.MjData(model)
    _step(model, data, 1.0)
    assert np.degrees(_bends(model, data, PAPER).max()) < 0.1


@pytest.mark.parametrize("angle", [3.0, 15.0, 20.0, 30.0, 45.0])
def test_a_joint_gives_way_by_the_same_share_of_its_limit_for_every_angle(angle):
    """Over the angle the tendon's length falls by the lever: equal shares of the limits are equal lengths."""
    design = design_from_rules(delta_theta=math.radians(angle))
    model = trunk_spec(design).compile()
    data, lengths = mujoco.MjData(model), []
    for bend in (design.joint_limit - 1e-4, design.joint_limit + 1e-4):
        data.joint(hinge_names(0)[0]).qpos[0] = bend
        mujoco.mj_forward(model, data)
        lengths.append(float(data.tendon("limit_01").length[0]))
    assert (lengths[0] - lengths[1]) / 2e-4 == pytest.approx(0.01941 * 30.0 / angle, rel=1e-3)


def test_a_curled_trunk_gives_way_as_far_in_many_sections_as_in_few(build_trunk, pull):
    """By all joints beyond their limits together, under full pull; with equal levers it is 1.8 times as far."""
    excess = []
    for sections in (12, 36):
        design = replace(design_from_rules(delta_theta=math.radians(540.0 / sections)), gripper=None)
        model = build_trunk(design)
        model.opt.gravity[:] = 0.0
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        data = mujoco.MjData(model)
        pull(model, design, (0, 60, 60))
        _step(model, data, 5.0)
        excess.append(float((_bends(model, data, design) - design.joint_limit).sum()))
    assert math.radians(5.0) < excess[0]
    assert 0.8 < excess[1] / excess[0] < 1.25
