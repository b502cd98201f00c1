"""The compiled trunk against the design: where it is, how long its cables are, what it weighs and how stiff it is."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.design.rules import design_from_rules
from spiraltrunk.model.kinematics import cables
from spiraltrunk.model.kinematics.frames import section_ends, section_frames
from spiraltrunk.sim import TrunkOptions, trunk_spec
from spiraltrunk.sim.robot.trunk import cable_name, hinge_names, hinge_order, section_name


def _drawn(seed):
    """A design with everything that the parity rests on drawn at random."""
    rng = np.random.default_rng(seed)
    design = design_from_rules(
        b=rng.uniform(0.08, 0.3), delta_theta=math.pi / int(rng.choice([4, 6, 9])), arm_radius=rng.uniform(0.02, 0.09)
    )
    angles = tuple(np.sort(rng.uniform(0, 2 * math.pi / 4, 4) * 0.8 + np.arange(4) * math.pi / 2))
    cable = replace(design.cable, angles=angles, hole_fraction=rng.uniform(0.3, 0.9))
    joint = replace(design.joint, stiffness=tuple(rng.uniform(0.01, 2.0, design.n_joint)))
    mass = replace(design.mass, center_fraction=rng.uniform(0.3, 0.7))
    arm, housing = replace(design.arm, roll=rng.uniform(-3, 3)), replace(design.housing, length=rng.uniform(0.05, 0.2))
    return replace(design, cable=cable, joint=joint, mass=mass, arm=arm, housing=housing, name=f"drawn {seed}")


DESIGNS = [*(presets.get(name) for name in presets.NAMES), *(_drawn(seed) for seed in (1, 2, 3))]


@pytest.fixture(params=DESIGNS, ids=lambda design: design.name)
def design(request):
    return request.param


def _bent(design, model, seed):
    """Data of a trunk bent at random within the joints' limits, and the joints' rotations composed in their order."""
    rng = np.random.default_rng(seed)
    data = mujoco.MjData(model)
    rotation = np.tile(np.eye(3), (design.n_joint, 1, 1))
    for i in range(design.n_joint):
        angle, towards = design.joint_limit * math.sqrt(rng.uniform()), rng.uniform(0, 2 * math.pi)
        bend = dict(zip(hinge_names(i), (angle * math.cos(towards), angle * math.sin(towards)), strict=True))
        for name in hinge_order(i):
            data.qpos[model.joint(name).qposadr[0]] = bend[name]
            rotation[i] = rotation[i] @ (_about_y if name.endswith("_y") else _about_z)(bend[name])
    mujoco.mj_forward(model, data)
    return data, rotation


def _about_y(a):
    return np.array([[math.cos(a), 0, math.sin(a)], [0, 1, 0], [-math.sin(a), 0, math.cos(a)]])


def _about_z(a):
    return np.array([[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]])


def _base(data):
    base = data.site("trunk_base")
    return base.xpos, base.xmat.reshape(3, 3)


@pytest.mark.parametrize("seed", range(3))
def test_section_ends_are_where_the_model_says(design, seed):
    model = trunk_spec(design).compile()
    data, rotation = _bent(design, model, seed)
    position, turn = _base(data)
    expected = position + section_ends(design, section_frames(design, rotation)) @ turn.T
    measured = [data.site(f"end_{n + 1:02d}").xpos for n in range(design.n_section)]
    np.testing.assert_allclose(measured, expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_sections_point_where_the_model_says(design, seed):
    model = trunk_spec(design).compile()
    data, rotation = _bent(design, model, seed)
    expected = _base(data)[1] @ section_frames(design, rotation)[:, :3, :3]
    measured = [data.body(section_name(n)).xmat.reshape(3, 3) for n in range(design.n_section)]
    np.testing.assert_allclose(measured, expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_tendons_are_as_long_as_the_models_cables(design, seed):
    model = trunk_spec(design, TrunkOptions(hole_set_back=0.0)).compile()
    data, rotation = _bent(design, model, seed)
    measured = [data.tendon(cable_name(c)).length[0] for c in range(design.n_cable)]
    np.testing.assert_allclose(measured, cables.lengths_from_rotations(design, rotation).length, rtol=0, atol=1e-9)


@pytest.mark.parametrize("set_back", [TrunkOptions().hole_set_back, 0.15])
def test_holes_set_back_lengthen_the_gaps_by_that_much(design, set_back):
    """The holes carried along by the frames, both moved into their section along its axis."""
    model = trunk_spec(design, TrunkOptions(hole_set_back=set_back)).compile()
    data, rotation = _bent(design, model, 5)
    frames = section_frames(design, rotation)
    back = set_back * design.face_half_width * design.k_p ** np.arange(design.n_section)
    for c, angle in enumerate(design.cable.angles):
        path = []
        for n in range(design.n_section):
            for (axial, ring), shift in zip(design.hole_position[n], (back[n], -back[n]), strict=True):
                local = np.array([axial + shift, ring * math.cos(angle), ring * math.sin(angle), 1.0])
                path.append((frames[n] @ local)[:3])
        expected = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
        assert data.tendon(cable_name(c)).length[0] == pytest.approx(expected, abs=1e-9)


def test_the_straight_trunk_lies_along_the_mounts_axis(design):
    model = trunk_spec(design).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    before = design.housing.length + design.housing.neck_length
    tip = data.site(f"end_{design.n_section:02d}").xpos
    np.testing.assert_allclose(tip, [0, 0, before + design.length], rtol=0, atol=1e-9)
    dorsal = data.body(section_name(0)).xmat.reshape(3, 3)[:, 1]
    np.testing.assert_allclose(dorsal, [math.cos(design.arm.roll), math.sin(design.arm.roll), 0], rtol=0, atol=1e-9)


def test_masses_centres_and_inertias_are_the_designs(design):
    model = trunk_spec(design).compile()
    bodies = [model.body(section_name(n)) for n in range(design.n_section)]
    np.testing.assert_allclose([b.mass[0] for b in bodies], design.section_mass, rtol=1e-9)
    centers = np.stack([design.section_center, 0 * design.section_center, 0 * design.section_center], axis=-1)
    np.testing.assert_allclose([b.ipos for b in bodies], centers, rtol=1e-9, atol=1e-15)
    for body, (axial, transverse) in zip(bodies, design.section_inertia, strict=True):
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, body.iquat)
        turn = turn.reshape(3, 3)
        measured = turn @ np.diag(body.inertia) @ turn.T
        expected = np.diag([axial, transverse, transverse])
        np.testing.assert_allclose(measured, expected, rtol=1e-9, atol=1e-9 * transverse)


def test_nothing_weighs_but_what_the_design_says(design):
    model = trunk_spec(design).compile()
    carried = design.housing.total_mass + design.housing.total_neck_mass
    assert model.body_mass.sum() == pytest.approx(design.total_mass + carried, rel=1e-9)


@pytest.mark.parametrize("factor", [1.0, 0.8])
def test_joints_are_as_stiff_and_damped_as_designed(design, factor):
    model = trunk_spec(design, TrunkOptions(stiffness_factor=factor)).compile()
    for i in range(design.n_joint):
        for name in hinge_names(i):
            joint, stiffness = model.joint(name), factor * design.joint_stiffness[i]
            assert joint.stiffness.flat[0] == pytest.approx(stiffness, rel=1e-9)
            assert model.dof_damping[joint.dofadr[0]] == pytest.approx(stiffness * design.joint.damping_time, rel=1e-9)


def test_motors_pull_no_harder_than_designed(design):
    model = trunk_spec(design).compile()
    for c in range(design.n_cable):
        np.testing.assert_allclose(model.actuator(cable_name(c)).forcerange, [-design.cable.tension_max, 0.0])
