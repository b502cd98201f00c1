"""Joint limit: the same cone in every place that has it.

These are `model.kinematics.joint_limits` (arrays), `model.statics.kernels.laws.joint_limits` (active set in space),
`model.reference.gravity_rest` (active set in the plane) and `sim.ground_truth` (hinges of the simulation).
"""

from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.model import reference, statics
from spiraltrunk.model.kinematics.joint_limits import clip_bend, joint_angle
from spiraltrunk.model.statics.equilibrium import StaticsOptions, build_trunk
from spiraltrunk.model.statics.kernels.laws import joint_limits
from spiraltrunk.model.statics.kernels.laws.joint_rotation import bend_size, rotate
from spiraltrunk.sim.truth_kernel import joint_bends

LIMIT = PAPER.joint_limit


def put_inside(q, *, has_hinges=False):
    """The bends ``q`` (n_joint, 3), put back into their cones by the kernel, and the angles of their joints."""
    trunk = build_trunk(PAPER, StaticsOptions(has_hinges=has_hinges))
    q, rim, rotation = q.copy(), np.empty(3), np.empty((PAPER.n_joint, 3, 3))
    joint_limits.project_to_limits(q, trunk, rim)
    for i in range(PAPER.n_joint):
        rotate(q[i], trunk.kind[i], 2, rotation[i])
        if np.hypot(*q[i, :2]) > 0:
            assert bend_size(q[i], trunk.kind[i], rim) == pytest.approx(joint_angle(rotation[i]), abs=1e-12)
    return q, joint_angle(rotation)


@pytest.mark.parametrize("has_hinges", [False, True])
def test_bends_are_put_back_onto_the_cone_and_stay_there(has_hinges):
    q = np.random.default_rng(0).normal(0.0, LIMIT, (PAPER.n_joint, 3))
    inside, angle = put_inside(q, has_hinges=has_hinges)
    assert angle.max() == pytest.approx(LIMIT, rel=1e-14)
    assert (angle <= LIMIT * (1 + 1e-14)).all()
    again, _ = put_inside(inside, has_hinges=has_hinges)
    np.testing.assert_allclose(again, inside, rtol=0, atol=1e-15)


def test_planar_bends_are_clipped_alike():
    bend = np.linspace(-2 * LIMIT, 2 * LIMIT, PAPER.n_joint)
    inside, _ = put_inside(np.stack([0 * bend, bend, 0 * bend], axis=-1))
    np.testing.assert_allclose(inside[:, 1], clip_bend(bend, LIMIT), rtol=1e-15)


def test_hinges_of_the_simulation_open_as_far_as_those_of_the_model():
    q = np.random.default_rng(1).uniform(-0.3, 0.3, (PAPER.n_joint, 3))
    inside, angle = put_inside(q, has_hinges=True)
    addresses = np.arange(2 * PAPER.n_joint).reshape(-1, 2).T
    bend = np.zeros(PAPER.n_joint)
    assert joint_bends(addresses, inside[:, :2].ravel(), bend) == bend.max()
    np.testing.assert_allclose(bend, angle, rtol=0, atol=1e-8)


def test_a_limp_trunk_shuts_the_same_joints_by_statics_and_by_the_papers_model():
    limp = replace(
        PAPER, gripper=None, joint=replace(PAPER.joint, stiffness=tuple((0.05 * PAPER.joint_stiffness).tolist()))
    )
    planar, spatial = reference.rest(limp, 0.0), statics.solve(limp, theta_0=0.0)
    assert 0 < planar.is_shut.sum() < PAPER.n_joint
    np.testing.assert_array_equal(planar.is_shut, spatial.is_shut)
    np.testing.assert_allclose(planar.joint_angle[planar.is_shut], LIMIT, rtol=1e-12)
    np.testing.assert_allclose(spatial.joint_angle[spatial.is_shut], LIMIT, rtol=1e-12)
    assert joint_limits.is_shut(LIMIT, LIMIT)
    assert not joint_limits.is_shut(LIMIT - 1e-3, LIMIT)
