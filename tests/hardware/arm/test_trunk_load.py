"""The load on the flange against MuJoCo's scene of the same design."""

import dataclasses
import math

import mujoco
import numpy as np
import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.arm.arm_port import ArmLoad
from spiraltrunk.hardware.arm.checks import read_load
from spiraltrunk.hardware.arm.trunk_load import trunk_load
from spiraltrunk.sim.robot.arm import arm_payload
from spiraltrunk.sim.scene.build import build_model

DESIGNS = {
    "paper": PAPER,
    "rolled": dataclasses.replace(PAPER, arm=dataclasses.replace(PAPER.arm, roll=-2.1, model="fr3")),
    "no gripper": dataclasses.replace(PAPER, gripper=None),
    "weighed": dataclasses.replace(PAPER, housing=dataclasses.replace(PAPER.housing, mass=2.0, length=0.15)),
}


@pytest.fixture(params=DESIGNS, scope="module")
def design(request):
    return DESIGNS[request.param]


def measure_load(design):
    """Mass, centre and inertia of MuJoCo's bodies from the housing on, in the flange's frame."""
    model = build_model(design)
    data = mujoco.MjData(model)
    data.qpos[:7] = np.linspace(-0.7, 0.9, 7)  # Any pose of the arm.
    mujoco.mj_forward(model, data)
    housing = model.body("housing").id
    bodies = [b for b in range(model.nbody) if b >= housing and model.body_rootid[b] == model.body_rootid[housing]]
    mass = model.body_mass[bodies].sum()
    assert mass == pytest.approx(model.body_subtreemass[housing])
    center = data.subtree_com[housing]
    inertia = np.zeros((3, 3))
    for b in bodies:
        turn, d = data.ximat[b].reshape(3, 3), data.xipos[b] - center
        inertia += turn @ np.diag(model.body_inertia[b]) @ turn.T
        inertia += model.body_mass[b] * (d @ d * np.eye(3) - np.outer(d, d))
    site = data.site("arm/flange")
    flange = site.xmat.reshape(3, 3)
    return mass, flange.T @ (center - site.xpos), flange.T @ inertia @ flange


def test_load_is_mujocos_subtree(design):
    mass, center, inertia = measure_load(design)
    load = trunk_load(design)
    assert load.mass == pytest.approx(mass, rel=1e-9)
    np.testing.assert_allclose(load.center, center, atol=1e-9)
    np.testing.assert_allclose(load.inertia, inertia, atol=1e-9 * np.abs(inertia).max())


def test_roll_turns_the_load_about_the_flange():
    plain, turned = (
        trunk_load(dataclasses.replace(PAPER, arm=dataclasses.replace(PAPER.arm, roll=roll))) for roll in (0.0, 1.3)
    )
    c, s = math.cos(1.3), math.sin(1.3)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    np.testing.assert_allclose(turned.center, turn @ plain.center, atol=1e-12)
    np.testing.assert_allclose(turned.inertia, turn @ plain.inertia @ turn.T, atol=1e-12)


def test_the_papers_trunk_is_within_the_pandas_payload_and_a_heavy_one_is_not():
    payload = arm_payload(PAPER.arm)
    assert isinstance(read_load(trunk_load(PAPER), payload), ArmLoad)
    heavy = dataclasses.replace(PAPER, housing=dataclasses.replace(PAPER.housing, mass=3.5))
    with pytest.raises(DriveError, match=r"allowed: 3 kg in all: weigh housing and trunk"):
        read_load(trunk_load(heavy), payload)


def test_the_end_effector_that_the_arm_knows_counts():
    with pytest.raises(DriveError, match=r"1 kg of end effector"):
        read_load(trunk_load(PAPER), 3.0, tool_mass=1.0)
