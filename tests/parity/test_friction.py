"""The friction's own cable geometry against the model's and against MuJoCo's."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.model.kinematics.cables import gap_vectors
from spiraltrunk.model.statics.equilibrium import StaticsOptions, build_trunk
from spiraltrunk.model.statics.kernels.laws.cable_gaps import NARROW, measure_turns
from spiraltrunk.model.statics.kernels.laws.energy import room_for_work
from spiraltrunk.sim import TrunkOptions, trunk_spec
from spiraltrunk.sim.robot.cable_friction import CableFriction
from spiraltrunk.sim.robot.cable_friction_kernel import measure_gaps
from spiraltrunk.sim.robot.trunk import cable_name, hinge_order


@pytest.fixture(params=presets.NAMES)
def design(request):
    return presets.get(request.param)


def _bent(design, options, seed):
    """Model, data and friction of a trunk bent at random within its joints' limits."""
    model = trunk_spec(design, options).compile()
    data, rng = mujoco.MjData(model), np.random.default_rng(seed)
    for i in range(design.n_joint):
        angle, towards = design.joint_limit * math.sqrt(rng.uniform()), rng.uniform(0, 2 * math.pi)
        for name, part in zip(hinge_order(i), (math.cos(towards), math.sin(towards)), strict=True):
            data.qpos[model.joint(name).qposadr[0]] = angle * part
    mujoco.mj_forward(model, data)
    return model, data, CableFriction(model, design, options)


def _measure(friction, qpos):
    shape = friction.turn.shape
    gap, gradient, turn = np.zeros(shape), np.zeros((*shape, 2)), np.zeros(shape)
    measure_gaps(friction._geometry, qpos, gap, gradient, turn)
    return gap, gradient, turn


def _rotation(model, data, design, qpos):
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    turn = np.array([data.body(f"section_{n + 1:02d}").xmat.reshape(3, 3) for n in range(design.n_section)])
    return np.swapaxes(turn[:-1], -1, -2) @ turn[1:]


@pytest.mark.parametrize("seed", range(3))
def test_gaps_and_their_gradients_are_the_models(design, seed):
    """True holes: lengths to rounding, gradients by central differences."""
    model, data, friction = _bent(design, TrunkOptions(hole_set_back=0.0), seed)
    start = data.qpos.copy()
    gap, gradient, _ = _measure(friction, start)
    rotation = _rotation(model, data, design, start)
    np.testing.assert_allclose(gap.T, np.linalg.norm(gap_vectors(design, rotation), axis=-1), rtol=0, atol=1e-12)
    for i in range(design.n_joint):
        for h, name in enumerate(hinge_order(i)):
            ends = []
            for side in (-1e-6, 1e-6):
                qpos = start.copy()
                qpos[model.joint(name).qposadr[0]] += side
                ends.append(np.linalg.norm(gap_vectors(design, _rotation(model, data, design, qpos)), axis=-1)[i])
            np.testing.assert_allclose(gradient[:, i, h], (ends[1] - ends[0]) / 2e-6, rtol=0, atol=1e-7)


@pytest.mark.parametrize("set_back", [0.0, 0.08, 0.2])
def test_the_whole_cable_is_mujocos(design, set_back):
    model, data, friction = _bent(design, TrunkOptions(hole_set_back=set_back), 7)
    gap, gradient, _ = _measure(friction, data.qpos)
    geometry = friction._geometry
    for c in range(design.n_cable):
        tendon = model.tendon(cable_name(c)).id
        assert geometry.inside[0] + gap[c].sum() == pytest.approx(data.ten_length[tendon], abs=1e-12)
        row = np.zeros(model.nv)
        first, count = model.ten_J_rowadr[tendon], model.ten_J_rownnz[tendon]
        row[model.ten_J_colind[first : first + count]] = data.ten_J[first : first + count]
        np.testing.assert_allclose(gradient[c], row[geometry.dof], rtol=0, atol=1e-10)


def test_the_turns_are_those_of_the_polyline_through_the_true_holes(design):
    """Whatever the set-back: angles between gap and hole at every hole but the first."""
    _, data, friction = _bent(design, TrunkOptions(hole_set_back=0.08), 3)
    _, _, turn = _measure(friction, data.qpos)
    true = trunk_spec(design, TrunkOptions(hole_set_back=0.0)).compile()
    other = mujoco.MjData(true)
    other.qpos[:] = data.qpos
    mujoco.mj_forward(true, other)
    for c in range(design.n_cable):
        holes = [other.site(f"hole_{n + 1:02d}_{c + 1}{side}").xpos for n in range(design.n_section) for side in "pd"]
        way = np.diff(holes, axis=0)
        way /= np.linalg.norm(way, axis=1)[:, None]
        angle = np.arccos(np.clip((way[1:] * way[:-1]).sum(axis=1), -1, 1))[:-1]
        expected = [angle[0], *(angle[1::2] + angle[2::2])]
        np.testing.assert_allclose(turn[c], expected, rtol=0, atol=1e-6)


def test_the_turns_are_those_of_the_equilibrium(design):
    """Where no gap is about to shut: there the equilibrium blends in the direction of the sections."""
    model, data, friction = _bent(design, TrunkOptions(hole_set_back=0.0), 5)
    gap, _, turn = _measure(friction, data.qpos)
    rotation = _rotation(model, data, design, data.qpos.copy())
    work = room_for_work(design.n_joint, design.n_cable, 2)
    work.rotation[:] = rotation
    measure_turns(build_trunk(design, StaticsOptions()), work)
    is_open = gap.T > 5 * NARROW
    is_open[1:] &= is_open[:-1].copy()
    assert is_open.mean() > 0.8
    np.testing.assert_allclose(turn.T[is_open], work.turn[is_open], rtol=0, atol=1e-6)


def test_friction_grows_with_the_coefficient_alone(design):
    """The law takes the design's number: at twice the coefficient, twice the logarithm of the tension left."""
    left = []
    for mu in (0.1, 0.2):
        rubbing = replace(design, cable=replace(design.cable, friction=mu))
        model, data, friction = _bent(rubbing, TrunkOptions(), 4)
        friction.reset(data)
        friction._state.force[:] = 1e6  # Yields to the capstan's bound at once.
        data.ctrl[:], model.actuator_forcerange[:, 0] = 0.0, -5.0
        friction.apply(data)
        left.append(np.log(friction.tension[:, -1] / friction.tension[:, 0]))
    np.testing.assert_allclose(left[1], 2 * left[0], rtol=1e-9)
    assert (left[0] < 0).all()
