"""Meshes and poses for viewers are those of the compiled model."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from spiraltrunk.sim.body_meshes import BodyPoses, build_meshes
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.scene.options import SceneOptions

SHAPES = """
<mujoco><worldbody>
  <geom name="floor" type="plane" size="0 0 1" rgba="1 1 1 1"/>
  <body name="a" pos="0.1 0.2 0.3" quat="0.6 0.8 0 0">
    <freejoint/>
    <geom type="capsule" size="0.02 0.05" pos="0.1 0 0" quat="0.6 0 0.8 0" rgba="1 0 0 1"/>
    <geom type="cylinder" size="0.03 0.04" pos="0 0.2 0" rgba="0 1 0 1"/>
    <geom type="box" size="0.01 0.02 0.03" pos="0 0 0.3" rgba="0 0 1 1"/>
    <geom type="sphere" size="0.05" pos="-0.3 0 0" rgba="1 1 0 1"/>
    <geom type="ellipsoid" size="0.05 0.02 0.01" pos="0 -0.4 0" rgba="1 0 1 1"/>
    <geom type="box" size="1 1 1" group="3" rgba="0 1 1 1"/>
  </body>
</worldbody></mujoco>
"""


def test_the_surface_of_each_form_has_the_extents_of_its_geom() -> None:
    model = mujoco.MjModel.from_xml_string(SHAPES)
    found = {mesh.color: mesh for mesh in build_meshes(model).meshes if mesh.body == 1}
    assert len(found) == 5, "one that only collides is not drawn"
    for g in range(1, 6):
        mesh = found[tuple(round(255 * v) for v in model.geom_rgba[g, :3])]
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, model.geom_quat[g])
        own = (mesh.vertices - model.geom_pos[g]) @ turn.reshape(3, 3)
        half = model.geom_aabb[g, 3:]
        assert np.abs(own).max(axis=0) == pytest.approx(half, rel=0.01)
        assert own.max(axis=0) == pytest.approx(-own.min(axis=0), rel=0.01)


def test_triangles_face_outwards() -> None:
    model = mujoco.MjModel.from_xml_string(SHAPES)
    for mesh in build_meshes(model).meshes:
        corners = mesh.vertices.astype(float)[mesh.faces] - mesh.vertices.mean(axis=0)
        assert np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) > 0.0


@pytest.fixture(scope="module")
def plant() -> SimPlant:
    plant = SimPlant(None, SceneOptions())
    plant.reset()
    return plant


def test_robot_and_object_are_there_with_their_strings(plant: SimPlant) -> None:
    meshes, model = build_meshes(plant.model), plant.model
    drawn = {model.body(mesh.body).name for mesh in meshes.meshes}
    assert {"world", "housing", "neck", "section_01", "section_18", "object", "arm/link0", "arm/link7"} <= drawn
    assert any(name.startswith("finger_") for name in drawn)
    assert meshes.n_body == model.nbody
    assert meshes.string_radius == pytest.approx(0.0015)
    by_body = {model.body(mesh.body).name: mesh for mesh in meshes.meshes}
    extents = np.ptp(by_body["object"].vertices, axis=0)
    assert extents == pytest.approx(plant.options.shape.size, rel=0.01)


def test_a_surface_lies_where_the_simulation_has_its_geom(plant: SimPlant) -> None:
    model, rng = plant.model, np.random.default_rng(0)
    qpos = plant.data.qpos + rng.uniform(-0.1, 0.1, model.nq)
    pose, string = BodyPoses(model).compute(qpos)
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    body = model.body("section_09").id
    mesh = next(mesh for mesh in build_meshes(model).meshes if mesh.body == body)
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, pose[body, 3:])
    placed = mesh.vertices @ turn.reshape(3, 3).T + pose[body, :3]
    geom = model.geom("section_09").id
    own = (placed - data.geom_xpos[geom]) @ data.geom_xmat[geom].reshape(3, 3)
    center, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
    assert own.max(axis=0) == pytest.approx(center + half, abs=1e-5)
    assert own.min(axis=0) == pytest.approx(center - half, abs=1e-5)
    lengths = np.linalg.norm(string[:, 0] - string[:, 1], axis=1)
    strings = [t for t in range(model.ntendon) if model.tendon(t).name.startswith("string_")]
    assert lengths == pytest.approx(data.ten_length[strings])
