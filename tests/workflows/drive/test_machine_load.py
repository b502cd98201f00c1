"""The simulated trunk on the twin's motors."""

from __future__ import annotations

from typing import NoReturn

import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, RunError
from spiraltrunk.hardware.twin.clock import STEP
from spiraltrunk.sim.machine import SimMachine
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.workflows.drive import trial
from spiraltrunk.workflows.drive.twin.machine_load import MachineLoad
from spiraltrunk.workflows.drive.twin.twin_robot import TwinOptions


def test_a_scene_with_another_step_is_refused() -> None:
    """The motors' clock would else advance the physics by nothing, or by half a step."""
    with pytest.raises(DesignError, match=r"scene.timestep is 0.002; allowed: 0.001 s on the twin"):
        MachineLoad(SimMachine(PAPER, SceneOptions(timestep=2e-3)))


def test_a_trial_on_the_twin_asks_for_the_twins_step(monkeypatch: pytest.MonkeyPatch) -> None:
    scenes = []

    def build(design: TrunkDesign, scene: SceneOptions, options: TwinOptions) -> NoReturn:
        scenes.append(scene)
        raise RunError("enough")

    monkeypatch.setattr(trial, "TwinRobot", build)
    with pytest.raises(RunError, match="enough"):
        trial.run_on_twin(PAPER, parse_object("cylinder-60"))
    assert [scene.timestep for scene in scenes] == [STEP] == [1e-3]
