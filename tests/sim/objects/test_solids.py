"""Geometric solids: exact mass distributions against closed forms, numerical and MuJoCo's own integrals."""

import math

import mujoco
import numpy as np
import pytest

from spiraltrunk.sim.objects.catalogue import CATALOGUE, ObjectSpec, add_object, parse_object
from spiraltrunk.sim.objects.geoms import compute_bounds
from spiraltrunk.sim.objects.solids import NECK_SHARE, RING_PARTS
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.sim.scene.supports import add_ground

SOLIDS = {
    "sphere": ObjectSpec(kind="sphere", size=(0.1, 0.1, 0.1), mass=0.3),
    "cylinder": ObjectSpec(kind="cylinder", size=(0.24, 0.06, 0.06), mass=0.3),
    "disc": ObjectSpec(kind="cylinder", size=(0.02, 0.08, 0.08), mass=0.3),
    "box": ObjectSpec(kind="box", size=(0.24, 0.05, 0.09), mass=0.3),
    "cone": ObjectSpec(kind="cone", size=(0.12, 0.08, 0.08), mass=0.3),
    "ring": ObjectSpec(kind="ring", size=(0.02, 0.09, 0.09), mass=0.3),
    "bottle": ObjectSpec(kind="bottle", size=(0.22, 0.07, 0.07), neck=0.03, mass=0.3),
}


def is_inside(shape, points):
    """Which points of the box round a solid are in it."""
    length, width, _ = shape.size
    x, y, z = (2 * points / np.array(shape.size)).T
    off_axis = np.hypot(y, z) * width / 2
    if shape.kind == "sphere":
        return x**2 + y**2 + z**2 <= 1
    if shape.kind == "cylinder":
        return y**2 + z**2 <= 1
    if shape.kind == "cone":
        return np.hypot(y, z) <= (1 - x) / 2
    if shape.kind == "ring":
        return (x * length / 2) ** 2 + (off_axis - (width - length) / 2) ** 2 <= (length / 2) ** 2
    if shape.kind == "bottle":
        return off_axis <= np.where((1 - x) / 2 < NECK_SHARE, shape.neck / 2, width / 2)
    return np.full(len(points), True)


def mujoco_inertia(body):
    """Inertia about the centre of mass, in the body's frame."""
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, body.iquat)
    return turn.reshape(3, 3) @ np.diag(body.inertia) @ turn.reshape(3, 3).T


@pytest.mark.parametrize("name", SOLIDS)
def test_centre_and_inertia_are_the_integrals_over_the_solid(name):
    shape = SOLIDS[name]
    axes = [extent * ((np.arange(120) + 0.5) / 120 - 0.5) for extent in shape.size]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    points = points[is_inside(shape, points)]
    np.testing.assert_allclose(shape.center(), points.mean(axis=0), atol=1e-3 * shape.length)
    points = points - points.mean(axis=0)
    squares = points.T @ points / len(points)
    expected = 0.3 * (np.trace(squares) * np.eye(3) - squares)
    np.testing.assert_allclose(shape.inertia(), expected, rtol=4e-3, atol=1e-9)


def test_the_closed_forms_are_the_textbooks():
    cone, ring = SOLIDS["cone"], SOLIDS["ring"]
    assert cone.center()[0] == pytest.approx(-0.12 / 4, rel=1e-12)
    assert cone.inertia()[0, 0] == pytest.approx(0.3 * 0.3 * 0.04**2, rel=1e-12)
    assert cone.inertia()[1, 1] == pytest.approx(0.3 * 3 / 80 * (0.08**2 + 0.12**2), rel=1e-12)
    assert ring.inertia()[0, 0] == pytest.approx(0.3 * (0.035**2 + 0.75 * 0.01**2), rel=1e-12)
    assert ring.inertia()[2, 2] == pytest.approx(0.3 * (0.035**2 / 2 + 0.625 * 0.01**2), rel=1e-12)


def test_a_bottle_without_a_shoulder_is_a_cylinder():
    bottle = ObjectSpec(kind="bottle", size=(0.2, 0.07, 0.07), neck=0.07 * (1 - 1e-12), mass=0.3)
    cylinder = ObjectSpec(kind="cylinder", size=(0.2, 0.07, 0.07), mass=0.3)
    np.testing.assert_allclose(bottle.inertia(), cylinder.inertia(), rtol=1e-9)
    np.testing.assert_allclose(bottle.center(), 0, atol=1e-12)


@pytest.mark.parametrize("name", SOLIDS)
def test_the_parts_fill_the_extents(name):
    shape = SOLIDS[name]
    low, high = compute_bounds(shape.solid.geoms)
    np.testing.assert_allclose(high, np.array(shape.size) / 2, rtol=1e-12)
    np.testing.assert_allclose(low, -np.array(shape.size) / 2, rtol=1e-12)


@pytest.mark.parametrize("name", [name for name in CATALOGUE if "ring" not in name])
def test_what_collides_has_the_objects_inertia(name):
    """MuJoCo's own integral of the geometry at the density that gives the mass; a cone is a pyramid of 48 sides."""
    shape = parse_object(name)
    spec = mujoco.MjSpec()
    body = add_object(spec, shape)
    stated = spec.compile().body("object")
    body.explicitinertial = False
    for geom in body.geoms:
        geom.mass, geom.density = math.nan, 1.0
    model = spec.compile()
    model_mass = model.body("object").mass[0]
    exact = 5e-3 if shape.kind == "cone" else 1e-9
    np.testing.assert_allclose(model.body("object").ipos, shape.center(), rtol=1e-6, atol=1e-9)
    inertia = mujoco_inertia(model.body("object")) * shape.mass / model_mass
    np.testing.assert_allclose(inertia, shape.inertia(), rtol=exact, atol=1e-12)
    np.testing.assert_allclose(mujoco_inertia(stated), shape.inertia(), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(stated.ipos, shape.center(), atol=1e-12)


def test_a_ring_is_touched_on_its_torus():
    """No point of a capsule is outside the torus by more than rounding, none more than 0.9 % of the radius inside."""
    shape = parse_object("ring-90")
    around, radius = 0.0375, 0.0075
    for part in shape.solid.geoms:
        ends = part.position[:, None] + part.rotation[:, 2:] * np.linspace(-1, 1, 21) * part.size[1]
        distance = np.hypot(np.hypot(ends[1], ends[2]) - around, ends[0])
        assert distance.max() < (1 - math.cos(math.pi / RING_PARTS)) * around * (1 + 1e-9)
        assert part.size[0] == pytest.approx(radius)
    assert len(shape.solid.geoms) == RING_PARTS


def dropped(shape, quat=(1, 0, 0, 0), time=1.0, speed=0.0):
    """Object put on a box as the trials' ground is one; its data after ``time``."""
    spec = mujoco.MjSpec()
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.timestep = 1e-3
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[2, 2, 0.1], pos=[0, 0, -0.1])
    body = add_object(spec, shape)
    upright = abs(quat[0] - math.sqrt(0.5)) < 1e-9
    body.pos, body.quat = [0, 0, shape.size[0 if upright else 2] / 2 + 2e-4], quat
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qvel[1] = speed
    data.qvel[3] = -speed / (shape.size[2] / 2)
    while data.time < time:
        mujoco.mj_step(model, data)
    return data


UPRIGHT = (math.sqrt(0.5), 0, -math.sqrt(0.5), 0)


@pytest.mark.parametrize("name", ["cone-35", "cone-90", "ring-90", "bottle-70", "disc-80x20", "cylinder-32", "rod-20"])
def test_what_is_put_upright_stands(name):
    shape = parse_object(name)
    data = dropped(shape, UPRIGHT)
    turn = data.body("object").xmat.reshape(3, 3)
    assert math.degrees(math.acos(min(1.0, turn[2, 0]))) < 1.0
    assert data.body("object").xpos[2] == pytest.approx(shape.length / 2, abs=5e-4)
    assert np.abs(data.qvel[:3]).max() < 0.01


@pytest.mark.parametrize("name", ["ball-30", "ball-80", "ball-120"])
def test_a_rolling_ball_comes_to_rest_where_its_rolling_friction_says(name):
    """A ball at v decelerates by mu_r g / (r (1 + 2/5)): torque mu_r m g over the inertia about its contact."""
    shape = parse_object(name)
    speed, radius = 0.30, shape.width / 2
    way = speed**2 / 2 / (1e-3 * 9.81 / (1.4 * radius))
    data = dropped(shape, time=8.0, speed=speed)
    assert data.body("object").xpos[1] == pytest.approx(way, rel=0.02)
    assert np.abs(data.qvel).max() < 1e-5


def test_a_cylinder_on_the_ground_comes_to_rest_too():
    """As the ball, with an inertia of m r^2 / 2."""
    shape = parse_object("cylinder-60")
    spec = mujoco.MjSpec()
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.timestep = 1e-3
    spec.add_material(name="tiles")
    add_ground(spec, SceneOptions(shape=shape, support="ground", orientation="lying"))
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    start, speed, radius = data.body("object").xpos.copy(), 0.2, shape.width / 2
    across = data.body("object").xmat.reshape(3, 3)[:, 1].copy()
    data.qvel[:3], data.qvel[3] = speed * across, -speed / radius
    while data.time < 5.0:
        mujoco.mj_step(model, data)
    way = speed**2 / 2 / (1e-3 * 9.81 / (1.5 * radius))
    assert (data.body("object").xpos - start) @ across == pytest.approx(way, rel=0.02)
    assert np.abs(data.qvel).max() < 1e-5
