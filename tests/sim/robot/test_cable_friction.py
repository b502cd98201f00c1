"""Cables rub at their holes: the capstan's law, what it does to energy, and that nothing rattles or creeps."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from spiraltrunk.control.messages import Command
from spiraltrunk.design import presets
from spiraltrunk.design.presets import PAPER
from spiraltrunk.sim import SimPlant, trunk_spec
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.relaxation.relax import LoadStep, RelaxationOptions, RelaxationRig
from spiraltrunk.sim.robot.cable_friction import COARSE_SHARE, STEP_SHARE
from spiraltrunk.sim.robot.cable_friction_kernel import measure_gaps
from spiraltrunk.sim.robot.trunk import TrunkOptions
from spiraltrunk.workflows.grasp.trial import run_trial

SLACK = math.nan
FAST = RelaxationOptions(pull_speed=0.02)
TWIST = [LoadStep(pull=(0.06, SLACK, SLACK)), LoadStep(pull=(0.06, 0.0034, SLACK))]
"""Cable 1 by 60 mm, then cable 2, which has run out by 26.6 mm, by 30 mm."""


def rub(mu, design=PAPER):
    return replace(design, cable=replace(design.cable, friction=mu))


def start(rig):
    mujoco.mj_resetData(rig.model, rig.data)
    rig.friction.reset(rig.data)


def set_tension(rig, tension):
    """Motors that pull in without end, at most so hard."""
    motors = [rig.model.actuator(f"cable_{c + 1}").id for c in range(len(tension))]
    rig.data.ctrl[motors] = 0.0
    rig.model.actuator_forcerange[motors, 0] = -np.array(tension)


def gaps(rig):
    """Lengths of the gaps as simulated."""
    shape = rig.friction.turn.shape
    gap = np.zeros(shape)
    measure_gaps(rig.friction._geometry, rig.data.qpos, gap, np.zeros((*shape, 2)), np.zeros(shape))
    return gap


# The law.


def test_the_straight_cable_turns_at_33_holes_by_the_taper():
    """8.88 deg at every hole, 293 deg in all: none at the first section's proximal hole, where the cable enters."""
    rig = RelaxationRig(rub(0.1))
    (axial, ring), (beyond, narrower) = PAPER.hole_position[0, 1], PAPER.hole_position[1, 0]
    each = math.atan2(ring - narrower, PAPER.section_length[0] - axial + beyond)
    expected = each * np.array([1] + 16 * [2])
    np.testing.assert_allclose(rig.friction.turn, np.tile(expected, (3, 1)), rtol=1e-9)
    assert math.degrees(rig.friction.turn[0].sum()) == pytest.approx(293, abs=0.2)


@pytest.mark.parametrize("angle", [5.0, 15.0, 25.0])
def test_a_bent_cable_turns_by_the_taper_or_by_the_bend(angle):
    """Towards the cable, joint by joint: twice 8.88 deg until the joint bends further, then as the joint does."""
    rig = RelaxationRig(rub(0.1))
    each = math.degrees(rig.friction.turn[0, 0])
    for i in range(PAPER.n_joint):
        rig.data.qpos[rig.model.joint(f"joint_{i + 1:02d}_z").qposadr[0]] = math.radians(angle)
    rig.friction.apply(rig.data)
    turn = np.degrees(rig.friction.turn[0])
    np.testing.assert_allclose(turn[1:], max(2 * each, angle), rtol=1e-9)
    assert turn[0] == pytest.approx(abs(each - angle / 2), rel=1e-9)


@pytest.mark.parametrize("mu", [*(pytest.param(mu, marks=pytest.mark.slow) for mu in (0.1, 0.2)), 0.4])
def test_a_cable_pulled_in_slowly_loses_tension_as_a_capstan(mu):
    """Joints as stiff as the tension left: all bend alike and little, and the cable slides at all holes."""
    left = np.exp(-mu * np.cumsum(RelaxationRig(rub(mu)).friction.turn[0]))
    stiffness = tuple(2.0 * left * PAPER.scale[:-1])
    rig = RelaxationRig(rub(mu, replace(PAPER, joint=replace(PAPER.joint, stiffness=stiffness))))
    rig.model.opt.gravity[:] = 0.0
    start(rig)
    mujoco.mj_forward(rig.model, rig.data)
    set_tension(rig, (60.0, 0.0, 0.0))
    motor, straight = rig.model.actuator("cable_1").id, rig.data.ten_length[rig.model.tendon("cable_1").id]
    for n in range(5000):
        rig.data.ctrl[motor] = straight - 1e-6 * n
        rig.friction.step(rig.data)
    assert np.degrees(np.abs(rig.data.qpos).max()) < 1.5
    assert rig.friction.tension[0, 0] > 1.0
    ratio = rig.friction.tension[0, -1] / rig.friction.tension[0, 0]
    assert ratio == pytest.approx(math.exp(-5.11 * mu), rel=0.005)


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.slow) if name == "spirob-1m" else name for name in presets.NAMES],
)
def test_tension_never_changes_at_a_hole_by_more_than_the_capstans(name):
    design = rub(0.15, presets.get(name))
    rig, rng = RelaxationRig(design), np.random.default_rng(1)
    start(rig)
    for _ in range(40):
        set_tension(rig, rng.uniform(0, 20, design.n_cable) * (rng.uniform(size=design.n_cable) > 0.3))
        for _ in range(10):
            rig.friction.step(rig.data, 5)
            before, beyond = rig.friction.tension[:, :-1], rig.friction.tension[:, 1:]
            grip = np.exp(0.15 * rig.friction.turn)
            assert (beyond <= before * grip * (1 + 1e-12)).all()
            assert (beyond >= before / grip * (1 - 1e-12)).all()


def test_the_forces_on_the_hinges_are_those_of_the_gaps_tensions():
    """Friction and motors together: -sum T_k grad L_k, the gradients by MuJoCo's own lengths, by differences."""
    rig, rng = RelaxationRig(rub(0.2)), np.random.default_rng(2)
    start(rig)
    set_tension(rig, (12.0, 3.0, 7.0))
    rig.friction.step(rig.data, 400)
    rig.friction.apply(rig.data)
    mujoco.mj_forward(rig.model, rig.data)
    total = rig.data.qfrc_applied + rig.data.qfrc_actuator
    position, tension = rig.data.qpos.copy(), rig.friction.tension
    np.testing.assert_allclose(tension[:, 0], [12.0, 3.0, 7.0])
    for _ in range(10):
        direction = rng.normal(size=rig.model.nq)
        ends = []
        for side in (-1e-6, 1e-6):
            rig.data.qpos[:] = position + side * direction
            ends.append(gaps(rig))
        power = -(tension[:, 1:] * (ends[1] - ends[0]) / 2e-6).sum()
        assert total @ direction == pytest.approx(power, rel=1e-6, abs=1e-8)


# Nothing without friction.


def test_the_model_is_the_same_with_and_without_friction():
    assert trunk_spec(rub(0.3)).to_xml() == trunk_spec(PAPER).to_xml()


def test_a_trunk_without_friction_has_no_part_in_it():
    rig = RelaxationRig(PAPER)
    rig.relax([LoadStep(pull=(0.03, SLACK, SLACK))])
    assert not rig.data.qfrc_applied.any()


@pytest.mark.slow
def test_hardly_any_friction_is_as_good_as_none():
    none, hardly = (RelaxationRig(rub(mu), theta_0=1.0, options=FAST).relax(TWIST) for mu in (0.0, 1e-7))
    np.testing.assert_allclose(hardly.shape.points, none.shape.points, rtol=0, atol=2e-5)


# Energy.


def test_a_pull_and_release_loses_energy_and_never_gains_any():
    """Work of the friction on the trunk, from an unloaded start: never positive; the motor pays for it."""
    rig = RelaxationRig(rub(0.15))
    start(rig)
    lost, paid, work = 0.0, 0.0, []
    before, force = gaps(rig), np.zeros_like(rig.friction.turn)
    for n in range(8000):
        set_tension(rig, (12.0 * (1 - abs(1 - n / 4000)), 0.0, 0.0))
        rig.friction.step(rig.data)
        now = gaps(rig)
        tension = rig.friction.tension
        force = tension[:, :-1] - tension[:, 1:]
        slid = np.cumsum((now - before)[:, ::-1], axis=1)[:, ::-1]
        lost += float((force * slid).sum())
        paid -= float(tension[0, 0] * slid[0, 0])
        work.append(lost)
        before = now
    assert max(work) <= 1e-6
    assert lost < -0.05
    assert paid > 0.9 * -lost


@pytest.mark.slow
def test_release_needs_less_tension_than_the_pull():
    rig = RelaxationRig(rub(0.15), options=FAST)
    pulled = rig.relax([LoadStep(pull=(0.06, SLACK, SLACK))])
    released = rig.relax([LoadStep(pull=(0.08, SLACK, SLACK)), LoadStep(pull=(0.06, SLACK, SLACK))])
    assert released.cable_tension[0] < 0.8 * pulled.cable_tension[0]


# Rest.


@pytest.mark.parametrize("timestep", [1e-3, 2e-3])
@pytest.mark.parametrize("mu", [pytest.param(0.1, marks=pytest.mark.slow), 0.4])
def test_jumps_to_full_pull_neither_diverge_nor_rattle(mu, timestep):
    rig = RelaxationRig(rub(mu), options=RelaxationOptions(timestep=timestep, damping_factor=1.0))
    start(rig)
    hinges = np.array([rig.model.joint(f"joint_{i + 1:02d}_{a}").dofadr[0] for i in range(17) for a in "yz"])
    for tension in ((60, 0, 0), (0, 60, 60), (60, 0, 0), (60, 60, 0), (60, 60, 60)):
        set_tension(rig, np.array(tension, float))
        rig.friction.step(rig.data, round(1.5 / timestep))
        assert np.abs(rig.data.qvel[hinges]).max() < 0.01
    assert sum(warning.number for warning in rig.data.warning) == 0


@pytest.mark.parametrize("mu", [pytest.param(0.1, marks=pytest.mark.slow), 0.4])
def test_a_trunk_at_rest_stays(mu):
    rig = RelaxationRig(rub(mu), options=FAST)
    rig.relax(TWIST)
    tip = rig.data.site("end_18").xpos.copy()
    rig.friction.step(rig.data, 1000)
    mujoco.mj_forward(rig.model, rig.data)
    assert np.linalg.norm(rig.data.site("end_18").xpos - tip) < 5e-6


# What it does to the shape.


def out_of_plane(points):
    """Largest distance from the best plane [m]."""
    from_middle = points - points.mean(axis=0)
    return np.abs(from_middle @ np.linalg.svd(from_middle)[2][2]).max()


def test_pulling_in_sequence_twists_the_trunk_by_friction_alone():
    shapes = {mu: RelaxationRig(rub(mu), options=FAST).relax(TWIST).shape.points for mu in (0.0, 0.15)}
    assert out_of_plane(shapes[0.0]) < 3e-3
    assert out_of_plane(shapes[0.15]) > 15e-3


@pytest.mark.slow
def test_the_order_of_pulling_matters_by_friction_alone():
    orders = [
        [LoadStep(pull=(0.06, SLACK, SLACK)), LoadStep(pull=(0.06, 0.03, SLACK))],
        [LoadStep(pull=(SLACK, 0.03, SLACK)), LoadStep(pull=(0.06, 0.03, SLACK))],
    ]
    apart = {}
    for mu in (0.0, 0.15):
        first, second = (RelaxationRig(rub(mu), options=FAST).relax(order).shape.points for order in orders)
        apart[mu] = np.linalg.norm(first - second, axis=-1).max()
    assert apart[0.0] < 2e-4
    assert apart[0.15] > 20e-3


# In the plant.


def test_the_plant_rubs_and_forgets_at_reset():
    plant = SimPlant(rub(0.2))

    def run():
        seen = plant.reset()
        for n in range(40):
            tension = np.array([4.0, 0.0, 0.0]) if n < 20 else np.zeros(3)
            seen = plant.step(Command(T_world_base=seen.T_world_base, cable_tension=tension))
        return seen

    first, second = run(), run()
    np.testing.assert_array_equal(first.cable_pull, second.cable_pull)
    without = SimPlant()
    plant, rubbing = without, first
    assert abs(run().cable_pull[0] - rubbing.cable_pull[0]) > 1e-4


def test_a_rolled_trunk_of_held_lengths_does_not_chatter_at_2_ms():
    trial = run_trial(rub(0.15), parse_object("cylinder-120"), strategy="kick", seed=3070524702, timestep=2e-3)
    trace = trial.plant.trace
    jumps = np.abs(np.diff([sample.cable_tension for sample in trace], 2, axis=0)).max(axis=1)
    assert np.mean(jumps > 20.0) < 0.02  # 0.13 where it chatters.
    assert math.degrees(max(sample.bend_most for sample in trace)) < 31.5


def test_stiffness_of_a_hole_follows_step_and_trunk():
    coarse, fine = (
        RelaxationRig(rub(0.1), options=RelaxationOptions(timestep=dt)).friction.stiffness for dt in (2e-3, 1e-3)
    )
    assert fine == pytest.approx(4 * STEP_SHARE / COARSE_SHARE * coarse)
    soft = RelaxationRig(rub(0.1), options=RelaxationOptions(trunk=TrunkOptions(hole_set_back=0.01))).friction.stiffness
    assert soft == pytest.approx(fine, rel=0.3)
