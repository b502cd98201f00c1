"""Derivatives of the equilibrium's kernels by finite differences, and their code on disc."""

import pickle
from pathlib import Path

import numpy as np
import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.model.jit import hash_files
from spiraltrunk.model.kinematics.cables import hole_positions
from spiraltrunk.model.kinematics.frames import bend_rotation
from spiraltrunk.model.statics import kernels
from spiraltrunk.model.statics.kernels import batch
from spiraltrunk.model.statics.kernels.laws import cable_gaps, energy, gravity_load, joint_rotation
from spiraltrunk.model.statics.kernels.laws.energy import Case, Control, Friction, Trunk, room_for_work

KINDS = [
    pytest.param(joint_rotation.VECTOR, 2, id="vector"), pytest.param(joint_rotation.VECTOR, 3, id="vector-torsion"),
    pytest.param(joint_rotation.Z_FIRST, 2, id="z-first"), pytest.param(joint_rotation.Y_FIRST, 2, id="y-first"),
]  # fmt: skip
SIZES = [1e-9, 1e-3, 0.2, 0.2235, 0.2237, 0.6, 3.0]
"""Bends from none to most of a turn; between the fourth and the fifth the series ends (u = 0.05)."""
STEP = 1e-5


def turn(q, kind, nd):
    out = np.empty((3, 3))
    joint_rotation.rotate(np.asarray(q, float), kind, nd, out)
    return out


def derivatives(q, kind, nd):
    first, second = np.zeros((nd, 3, 3)), np.zeros((nd, nd, 3, 3))
    joint_rotation.differentiate(np.asarray(q, float), kind, nd, first, second)
    return first, second


def central(function, q, axis, step=STEP):
    shift = np.zeros_like(q)
    shift[axis] = step
    return (function(q + shift) - function(q - shift)) / (2 * step)


def bends(size):
    rng = np.random.default_rng(3)
    return [np.array([size * np.cos(a), size * np.sin(a), rng.uniform(-0.5, 0.5)]) for a in rng.uniform(0, 6.3, 4)]


@pytest.mark.parametrize(("kind", "nd"), KINDS)
@pytest.mark.parametrize("size", SIZES)
def test_derivatives_of_a_joints_turn(kind, nd, size):
    for q in bends(size):
        first, second = derivatives(q, kind, nd)
        for a in range(nd):
            np.testing.assert_allclose(first[a], central(lambda x: turn(x, kind, nd), q, a), rtol=0, atol=1e-9)
            for b in range(a + 1):
                by_b = central(lambda x, a=a: derivatives(x, kind, nd)[0][a], q, b)
                np.testing.assert_allclose(second[a, b], by_b, rtol=0, atol=1e-9)


@pytest.mark.parametrize("size", SIZES)
def test_a_joint_without_torsion_turns_by_the_rotation_vector(size):
    for q in bends(size):
        np.testing.assert_allclose(turn(q, joint_rotation.VECTOR, 2), bend_rotation(q[:2]), rtol=0, atol=1e-14)
        roll = turn([0, 0, q[2]], joint_rotation.VECTOR, 3)
        np.testing.assert_allclose(turn(q, joint_rotation.VECTOR, 3), bend_rotation(q[:2]) @ roll, rtol=0, atol=1e-14)
        np.testing.assert_allclose(roll @ [1, 0, 0], [1, 0, 0], rtol=0, atol=0)


def test_hinges_turn_one_after_the_other():
    y, z = turn([0.4, 0, 0], joint_rotation.Z_FIRST, 2), turn([0, -0.7, 0], joint_rotation.Z_FIRST, 2)
    np.testing.assert_allclose(y @ [0, 1, 0], [0, 1, 0], rtol=0, atol=1e-16)
    np.testing.assert_allclose(z @ [0, 0, 1], [0, 0, 1], rtol=0, atol=1e-16)
    np.testing.assert_allclose(turn([0.4, -0.7, 0], joint_rotation.Z_FIRST, 2), z @ y, rtol=0, atol=1e-15)
    np.testing.assert_allclose(turn([0.4, -0.7, 0], joint_rotation.Y_FIRST, 2), y @ z, rtol=0, atol=1e-15)


@pytest.mark.parametrize("kind", [joint_rotation.VECTOR, joint_rotation.Z_FIRST, joint_rotation.Y_FIRST])
@pytest.mark.parametrize("size", [0.2, 0.52, 1.0])
def test_the_rim_is_where_the_axes_stay_at_one_angle(kind, size):
    def angle(q):
        return np.arccos(turn(q, kind, 2)[0, 0])

    for q in bends(size):
        rim = np.empty(3)
        assert joint_rotation.bend_size(q, kind, rim) == pytest.approx(angle(q), abs=1e-12)
        slope = np.array([central(angle, q, a) for a in (0, 1)])
        np.testing.assert_allclose(rim[:2], slope, rtol=0, atol=1e-9)
        along = np.array([-slope[1], slope[0], 0]) / np.linalg.norm(slope)
        step = 1e-4
        curve = (angle(q + step * along) - 2 * angle(q) + angle(q - step * along)) / step**2
        assert rim[2] == pytest.approx(curve, abs=1e-6)


@pytest.mark.parametrize(("kind", "nd"), KINDS)
def test_slope_and_curve_of_a_gap(kind, nd):
    beyond, before = hole_positions(PAPER)
    p, m, v = before[4, 1], beyond[4, 1], np.empty(3)

    def measure(q):
        (first, second), slope, curve = derivatives(q, kind, nd), np.zeros(nd), np.zeros((nd, nd))
        length = cable_gaps.gap_length(turn(q, kind, nd), p, m, 1e-6, v)
        cable_gaps.differentiate_gap(first, second, p, m, length, v, slope, curve)
        return length, slope, curve

    for q in bends(0.3):
        length, slope, curve = measure(q)
        assert length == pytest.approx(np.linalg.norm(turn(q, kind, nd) @ m - p), rel=1e-7)
        for a in range(nd):
            assert slope[a] == pytest.approx(central(lambda x: measure(x)[0], q, a), abs=1e-10)
            for b in range(a + 1):
                by_b = central(lambda x, a=a: measure(x)[1][a], q, b)
                assert curve[a, b] == pytest.approx(by_b, abs=1e-9)


def test_a_gap_keeps_its_digits_where_it_shuts():
    beyond, before = hole_positions(PAPER)
    p, m, v = before[0, 0], beyond[0, 0], np.empty(3)
    for less in (1e-4, 1e-6, 1e-8):
        length = cable_gaps.gap_length(turn([0, PAPER.joint_limit - less, 0], joint_rotation.VECTOR, 2), p, m, 0.0, v)
        assert length == pytest.approx(2 * PAPER.hole_to_joint[0] * np.sin(less / 2), rel=1e-6)


def test_the_turns_at_the_holes_are_those_of_the_planar_figure():
    """Straight, the cable turns by 17.77 deg at the two holes together, and as much until the joint bends as far."""
    beyond, before = hole_positions(PAPER)
    v = np.empty(3)
    for bend in (0.0, 0.1, 0.3):
        at = cable_gaps.hole_turns(turn([0, bend, 0], joint_rotation.VECTOR, 2), before[3, 0], beyond[3, 0], v)
        assert sum(at) == pytest.approx(_planar_turn(before[3, 0], beyond[3, 0], bend), abs=1e-12)
        assert sum(at) == pytest.approx(2 * np.arcsin(0.6 * 44 * (1 - PAPER.k_p) / 13.744), abs=1e-3)


def _planar_turn(p, m, bend):
    far = np.array([np.cos(bend) * m[0] - np.sin(bend) * m[1], np.sin(bend) * m[0] + np.cos(bend) * m[1]])
    heading = np.arctan2(*(far - p[:2])[::-1])
    return abs(heading) + abs(bend - heading)


# The whole chain, on five joints so that differences stay cheap.

N = 5


def case_of(kind, nd, friction=0.0, by_tension=(False, True, False), seed=0):
    """A bent trunk with masses and a tip force, one cable of each sort, holes that stick and slide."""
    rng = np.random.default_rng(seed)
    beyond, before = hole_positions(PAPER)
    kinds = np.full(N, kind)
    if kind != joint_rotation.VECTOR:
        kinds[1::2] = joint_rotation.Z_FIRST + joint_rotation.Y_FIRST - kind
    stiffness = np.repeat(PAPER.joint_stiffness[:N, None], 3, axis=1) * [1, 1.3, 0.7]
    trunk = Trunk(
        kinds, stiffness, np.full((N, 3), 0.05), PAPER.joint_limit, PAPER.section_length[: N + 1].copy(),
        before[:N].copy(), beyond[:N].copy(), before[:N].copy(), beyond[:N].copy(), 1e-6,
    )  # fmt: skip
    mass = 5 * PAPER.section_mass[: N + 1]
    end = np.zeros(N + 1)
    end[3] = 1.0
    field = (
        np.array([[0.0, -9.81, 0.0], [1.0, 2.0, -3.0]]), np.stack([mass, end]),
        np.stack([mass * PAPER.section_center[: N + 1], end * trunk.length]),
    )  # fmt: skip
    q = np.zeros((N, 3))
    q[:, :nd] = rng.uniform(-0.3, 0.3, (N, nd))
    control = Control(np.array(by_tension), np.full(3, 0.05), np.full(3, 60.0), np.array([0.0, 0.0, 1e-4]))
    hold = np.zeros((N, 3))
    base = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    case = Case(base, trunk, field, control, Friction(hold, hold.copy(), hold.copy(), friction))
    return q, case, room_for_work(N, 3, nd)


def check_derivatives(q, nd, value, derive):
    """Gradient and lower Hessian that ``derive`` leaves against differences of ``value`` and of the gradient."""
    gradient, hessian = (array.copy() for array in derive(q))
    flat = q[:, :nd].ravel()

    def put(x):
        full = q.copy()
        full[:, :nd] = x.reshape(N, nd)
        return full

    for row in range(flat.size):
        slope = central(lambda x: value(put(x)), flat, row, 1e-5)
        assert gradient.ravel()[row] == pytest.approx(slope, abs=1e-8)
        curve = central(lambda x: derive(put(x))[0].ravel().copy(), flat, row, 1e-5)
        np.testing.assert_allclose(hessian[row:, row], curve[row:], rtol=1e-7, atol=1e-6)


@pytest.mark.parametrize(("kind", "nd"), KINDS)
def test_weight_and_a_force_have_their_gradient_and_hessian(kind, nd):
    q, case, work = case_of(kind, nd)

    def value(q):
        energy.place(q, case.base, case.trunk, work)
        return gravity_load.weight_energy(work.frames, case.trunk.length, case.field)

    def derive(q):
        energy.place(q, case.base, case.trunk, work)
        for i in range(N):
            joint_rotation.differentiate(q[i], case.trunk.kind[i], nd, work.first[i], work.second[i])
        work.gradient[:], work.hessian[:] = 0.0, 0.0
        gravity_load.add_weight(work, case.trunk.length, case.field)
        return work.gradient, work.hessian

    check_derivatives(q, nd, value, derive)


def test_weight_is_the_sum_over_the_masses():
    q, case, work = case_of(joint_rotation.VECTOR, 3)
    energy.place(q, case.base, case.trunk, work)
    points = np.empty((N + 1, 3))
    batch.find_ends(work.frames, case.trunk.length, points)
    direction, factor, moment = case.field
    starts = np.vstack([np.zeros(3), points[:-1]])
    along = work.frames[:, :, 0]
    expected = -sum(direction[f] @ (factor[f] @ starts + moment[f] @ along) for f in range(2))
    assert gravity_load.weight_energy(work.frames, case.trunk.length, case.field) == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize(("kind", "nd"), KINDS)
@pytest.mark.parametrize("stiffness", [0.0, 2e3])
def test_the_merit_has_its_gradient_and_hessian(kind, nd, stiffness):
    """Cables held by tension; with friction each hole is sliding one way, the other, or sticking."""
    q, case, work = case_of(kind, nd, stiffness, by_tension=(True, True, True))
    tension, rng = np.array([3.0, 0.0, 11.0]), np.random.default_rng(1)
    energy.place(q, case.base, case.trunk, work)
    beyond = np.cumsum(work.gap[::-1], axis=0)[::-1]
    case.friction.force[:], case.friction.force_back[:] = rng.uniform(0, 2, (N, 3)), rng.uniform(0, 3, (N, 3))
    case.friction.anchor[:] = beyond + rng.choice([-2e-3, -5e-4, 4e-4, 2e-3], (N, 3))

    def derive(q):
        energy.linearise(q, case, tension, work)
        return work.gradient, work.hessian

    check_derivatives(q, nd, lambda q: energy.merit(q, case, tension, 1e3, work), derive)


def test_a_held_cable_pulls_with_the_tension_of_its_augmented_lagrangian():
    """The merit's slope is that of the energy at the tensions it names, rigid winder or elastic, pulling or slack."""
    q, case, work = case_of(joint_rotation.VECTOR, 2, by_tension=(False, False, False))
    energy.place(q, case.base, case.trunk, work)
    total = work.gap.sum(axis=0)
    tension, penalty = np.array([2.0, 1.0, 4.0]), 500.0
    case.control.length[:] = [total[0] - 0.004, total[1] + 0.05, total[2] - 0.003]
    found = [energy.cable_tension(total[c], c, tension, case.control, penalty)[0] for c in range(3)]
    assert found[:2] == pytest.approx([2.0 + penalty * 0.004, 0.0])
    assert found[2] == pytest.approx((0.003 + 4.0 / penalty) / (1e-4 + 1 / penalty))
    energy.linearise(q, case, np.array(found), work)
    gradient = work.gradient.copy()
    for i in range(N):
        for a in range(2):
            slope = central(lambda x: energy.merit(x, case, tension, penalty, work), q, (i, a), 1e-6)
            assert gradient[i, a] == pytest.approx(slope, abs=1e-7)


# Code on disc.


def test_the_code_on_disc_is_stamped_with_all_sources():
    """Numba stores its index of machine code with this stamp and throws all of it away where it differs."""
    for kernel in (batch.solve_rows, energy.merit, joint_rotation.rotate):
        stored = kernel._cache._cache_file
        assert stored._source_stamp == kernels.STAMP
    joint_rotation.rotate(np.zeros(3), 0, 2, np.empty((3, 3)))
    with Path(joint_rotation.rotate._cache._cache_file._index_path).open("rb") as index:
        pickle.load(index)
        assert pickle.loads(index.read())[0] == kernels.STAMP


def test_the_stamp_follows_every_source(tmp_path):
    files = [tmp_path / "a.py", tmp_path / "b.py"]
    for file, text in zip(files, ("one", "two"), strict=True):
        file.write_text(text)
    stamp = hash_files(files)
    assert hash_files(reversed(files)) == stamp
    files[1].write_text("three")
    assert hash_files(files) != stamp
    assert hash_files(Path(kernels.__file__).parent.rglob("*.py")) == kernels.STAMP
