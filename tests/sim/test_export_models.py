"""MJCF and URDF of trunk and hybrid: read by others, same mass, same rest shape, nothing outside the folder."""

from __future__ import annotations

import shutil
from dataclasses import replace
from xml.etree import ElementTree as ET

import mujoco
import numpy as np
import pytest
import trimesh
from PIL import Image

from spiraltrunk.design import ArmDesign, presets
from spiraltrunk.model import statics
from spiraltrunk.sim.export_models import KINDS, write_models
from spiraltrunk.sim.robot.arm import arm_spec
from spiraltrunk.sim.robot.trunk import hinge_names, trunk_spec

DESIGNS = ("paper", "spirob-15")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Models of two designs, moved after writing: their paths must be relative."""
    root = tmp_path_factory.mktemp("models")
    for name in DESIGNS:
        write_models(presets.get(name), root / "first" / name, ("mjcf", "urdf"))
    shutil.move(root / "first", root / "moved")
    return root / "moved"


def expected_mass(design):
    return design.total_mass + design.housing.total_mass + design.housing.total_neck_mass


@pytest.mark.parametrize("name", DESIGNS)
def test_the_trunk_loads_with_the_designs_mass(folder, name):
    model = mujoco.MjModel.from_xml_path(str(folder / name / "trunk.xml"))
    assert model.body_mass.sum() == pytest.approx(expected_mass(presets.get(name)), rel=1e-6)
    ours = trunk_spec(presets.get(name)).compile()
    assert model.nq == ours.nq
    assert model.body_inertia[1:] == pytest.approx(ours.body_inertia[1:], rel=1e-5)
    assert [model.body(b).name for b in range(model.nbody)] == [ours.body(b).name for b in range(ours.nbody)]


def test_the_hybrid_is_the_arm_and_the_trunk(folder):
    model = mujoco.MjModel.from_xml_path(str(folder / "paper" / "hybrid.xml"))
    arm = arm_spec(presets.PAPER.arm).compile()
    assert model.body_mass.sum() == pytest.approx(arm.body_mass.sum() + expected_mass(presets.PAPER), rel=1e-6)
    assert model.nq == arm.nq + 2 * presets.PAPER.n_joint + 6


def test_an_arm_of_capsules_is_written_too(tmp_path):
    design = replace(presets.PAPER, arm=ArmDesign(model="fr3"))
    write_models(design, tmp_path, ("mjcf", "urdf"))
    arm = arm_spec(design.arm).compile()
    for name in ("hybrid.xml", "hybrid.urdf"):
        model = mujoco.MjModel.from_xml_path(str(tmp_path / name))
        assert model.body_mass.sum() == pytest.approx(arm.body_mass.sum() + expected_mass(design), rel=2e-6)
        first = [model.joint(j).name for j in range(7)]
        np.testing.assert_allclose([model.joint(j).range for j in first], arm.jnt_range, rtol=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_no_path_leads_elsewhere(folder, kind):
    for ending in ("xml", "urdf"):
        root = ET.parse(folder / "paper" / f"{kind}.{ending}").getroot()
        paths = [item.get(key) for key in ("file", "filename") for item in root.iter() if item.get(key)]
        assert len(paths) >= presets.PAPER.n_section
        for path in paths:
            assert path.startswith("assets/")
            assert (folder / "paper" / path).is_file()


def settle(model, seconds=4.0):
    """Bends of the joints at rest, lying with the dorsal side up, cables slack, motion damped more than in life."""
    model.actuator_gainprm[:] = 0.0
    model.actuator_biasprm[:] = 0.0
    model.dof_damping[:] *= 4.0
    model.opt.timestep = 1e-3
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    model.opt.gravity[:] = -9.81 * data.xmat[model.body("section_01").id].reshape(3, 3)[:, 1]
    while data.time < seconds:
        mujoco.mj_step(model, data)
    assert np.abs(data.qvel).max() < 1e-3
    joints = sum(model.joint(j).name.endswith("_y") for j in range(model.njnt))
    angles = [[data.qpos[model.joint(name).qposadr[0]] for name in hinge_names(i)] for i in range(joints)]
    return np.hypot(*np.transpose(angles))


@pytest.mark.parametrize("name", DESIGNS)
def test_a_file_rests_as_the_simulation_does(folder, name):
    """Lying, where weight bends it most: read back and stepped."""
    bend = settle(mujoco.MjModel.from_xml_path(str(folder / name / "trunk.xml")))
    assert bend.max() > 0.03
    assert bend == pytest.approx(settle(trunk_spec(presets.get(name)).compile()), abs=1e-5)


def test_a_file_rests_as_the_equilibrium_does(folder):
    """Without a gripper, whose fingers the equilibrium has as one weight at the tip."""
    bend = settle(mujoco.MjModel.from_xml_path(str(folder / "spirob-15" / "trunk.xml")))
    assert bend == pytest.approx(np.abs(statics.solve(presets.get("spirob-15"), theta_0=0.0).joint_angle), abs=2e-4)


def test_a_full_curl_stays_within_the_limit(folder):
    """A plain load has no tuned limits: a cable wound in, the base lying, must neither diverge nor overshoot."""
    model = mujoco.MjModel.from_xml_path(str(folder / "spirob-15" / "trunk.xml"))
    design = presets.get("spirob-15")
    data = mujoco.MjData(model)
    model.opt.gravity[:] = [9.81, 0.0, 0.0]
    data.ctrl[:] = [model.tendon_length0[model.actuator_trnid[i, 0]] for i in range(model.nu)]
    cable = model.actuator("cable_1").id
    start = data.ctrl[cable]
    worst = 0.0
    while data.time < 1.5:
        data.ctrl[cable] = start - design.cable_stroke * min(1.0, data.time / 1.2)
        mujoco.mj_step(model, data)
        worst = max(worst, np.abs(data.qpos).max())
    assert not any(warning.number for warning in data.warning)
    assert worst < 1.1 * design.joint_limit
    assert np.abs(data.qpos).max() > 0.8 * design.joint_limit


@pytest.mark.parametrize("kind", KINDS)
def test_urdf_says_the_same_to_another_reader(folder, kind):
    """Mass, tree and the pose of every link at drawn joint angles, against MuJoCo's own kinematics of the MJCF."""
    yourdfpy = pytest.importorskip("yourdfpy", reason="reads URDF")
    robot = yourdfpy.URDF.load(str(folder / "paper" / f"{kind}.urdf"), load_meshes=False)
    assert robot.validate()
    model = mujoco.MjModel.from_xml_path(str(folder / "paper" / f"{kind}.xml"))
    mass = sum(link.inertial.mass for link in robot.robot.links if link.inertial)
    assert mass == pytest.approx(model.body_mass.sum(), rel=1e-5)
    data = mujoco.MjData(model)
    data.qpos[:] = np.random.default_rng(0).uniform(-0.4, 0.4, model.nq)
    mujoco.mj_kinematics(model, data)
    angles = {model.joint(j).name.replace("/", "_"): data.qpos[model.jnt_qposadr[j]] for j in range(model.njnt)}
    assert set(angles) == set(robot.actuated_joint_names)
    robot.update_cfg(angles)
    for b in range(1, model.nbody):
        T = robot.get_transform(model.body(b).name.replace("/", "_"), "world")
        assert T[:3, 3] == pytest.approx(data.xpos[b], abs=2e-6)
        assert T[:3, :3].ravel() == pytest.approx(data.xmat[b], abs=2e-6)


def test_urdf_rests_alike_once_it_has_springs(folder):
    """URDF has no springs; with the design's put in, MuJoCo's own reader of it finds the equilibrium's shape."""
    design = presets.get("spirob-15")
    model = mujoco.MjModel.from_xml_path(str(folder / "spirob-15" / "trunk.urdf"))
    for i in range(design.n_joint):
        for name in hinge_names(i):
            joint = model.joint(name)
            model.jnt_stiffness[joint.id] = design.joint_stiffness[i]
            model.dof_damping[joint.dofadr[0]] = 0.04 * design.joint_stiffness[i]
            model.dof_armature[joint.dofadr[0]] = 1e-5
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT  # URDF cannot leave pairs out.
    wanted = np.abs(statics.solve(design, theta_0=0.0).joint_angle)
    assert settle(model) == pytest.approx(wanted, abs=2e-4)


def test_one_format_alone_writes_no_other(tmp_path):
    small = replace(presets.get("spirob-15"), name="../<out> & away")
    written = write_models(small, tmp_path, ("urdf",))
    assert sorted(path.suffix for path in written if path.suffix != ".stl") == [".urdf", ".urdf"]
    assert all(tmp_path in path.parents for path in written)


def test_an_arm_of_a_users_meshes_is_written_with_them(tmp_path):
    (tmp_path / "own").mkdir()
    trimesh.creation.box((0.05, 0.05, 0.2)).export(tmp_path / "own" / "link.stl")
    trimesh.creation.box((0.08, 0.08, 0.4)).export(tmp_path / "own" / "cover.obj")
    Image.new("RGB", (8, 8), (200, 10, 10)).save(tmp_path / "own" / "skin.png")
    (tmp_path / "arm.xml").write_text("""
        <mujoco>
          <compiler meshdir="own" texturedir="own"/>
          <asset>
            <mesh file="link.stl"/>
            <mesh file="cover.obj" scale="0.5 0.5 0.5"/>
            <texture name="skin" type="2d" file="skin.png"/>
            <material name="skin" texture="skin"/>
          </asset>
          <worldbody>
            <body name="one" pos="0 0 0.3">
              <joint name="turn" axis="0 1 0" range="-1 1"/>
              <geom type="mesh" mesh="link" material="skin"/>
              <geom type="mesh" mesh="cover"/>
              <site name="end" pos="0 0 0.1"/>
            </body>
          </worldbody>
          <actuator><position joint="turn" kp="100" ctrlrange="-1 1"/></actuator>
        </mujoco>""")
    design = replace(presets.PAPER, arm=ArmDesign(model=str(tmp_path / "arm.xml"), mount_site="end", home=(0.1,)))
    write_models(design, tmp_path / "out", ("mjcf", "urdf"))
    own, arm = arm_spec(design.arm).compile(), tmp_path / "arm.xml"
    shutil.rmtree(tmp_path / "own")
    arm.unlink()
    shutil.move(tmp_path / "out", tmp_path / "moved")
    for name, prefix, n_texture in (("hybrid.xml", "arm/", 1), ("hybrid.urdf", "", 0)):
        model = mujoco.MjModel.from_xml_path(str(tmp_path / "moved" / name))
        assert model.ntex == n_texture
        assert model.body_mass.sum() == pytest.approx(own.body_mass.sum() + expected_mass(design), rel=2e-6)
        for mesh in ("link", "cover") if prefix else ("0_arm_link", "1_arm_cover"):
            index = model.mesh(f"{prefix}{mesh}").id
            first, count = model.mesh_vertadr[index], model.mesh_vertnum[index]
            np.testing.assert_allclose(np.ptp(model.mesh_vert[first : first + count], axis=0).max(), 0.2, rtol=1e-5)
