"""Scenes with another time step: what follows it, and what does not change."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from spiraltrunk.control.messages import Command
from spiraltrunk.design.presets import PAPER
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.scene.build import build_model
from spiraltrunk.sim.scene.options import SceneOptions

STEPS = (0.5e-3, 1e-3, 2e-3, 2.5e-3)

CONSTANTS = ("geom_solref", "jnt_solref", "tendon_solref_lim")


@pytest.mark.parametrize("step", STEPS)
def test_no_contact_and_no_limit_is_faster_than_two_steps(step: float) -> None:
    model = build_model(PAPER, SceneOptions(timestep=step))
    assert model.opt.timestep == step
    for name in CONSTANTS:
        constants = getattr(model, name)[:, 0]
        assert constants[constants > 0].min() >= 2 * step


def test_up_to_one_millisecond_the_model_stays_as_it_was_written() -> None:
    """The fastest time constant is the 3 ms of a joint limit."""
    models = [build_model(PAPER, SceneOptions(timestep=step)) for step in (0.5e-3, 1e-3)]
    for name in (*CONSTANTS, "tendon_invweight0"):
        assert np.array_equal(*(getattr(model, name) for model in models))
    limits = models[1].tendon_solref_lim[[models[1].tendon("limit_01").id, models[1].tendon("string_left").id], 0]
    assert list(limits) == [0.003, 0.01]


def test_two_milliseconds_change_what_mujoco_would_change() -> None:
    """With its own floor, flag ``refsafe``, off and on, the model steps to the same state."""
    states = []
    for flag in (0, mujoco.mjtDisableBit.mjDSBL_REFSAFE):
        model = build_model(PAPER, SceneOptions(timestep=2e-3))
        model.opt.disableflags |= flag
        data = mujoco.MjData(model)
        mujoco.mj_step(model, data, 50)
        states.append(data.qpos.copy())
    assert np.array_equal(*states)


@pytest.mark.parametrize("step", STEPS)
def test_a_control_period_is_twenty_milliseconds_with_any_step(step: float) -> None:
    plant = SimPlant(PAPER, SceneOptions(timestep=step))
    observation = plant.reset()
    hold = Command(T_world_base=observation.T_world_base, cable_tension=np.zeros(3))
    for _ in range(3):
        observation = plant.step(hold)
    assert observation.time == pytest.approx(0.06, abs=1e-9)
    assert plant.data.time == pytest.approx(0.06, abs=1e-9)
