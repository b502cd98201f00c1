"""The simulated trunk on the twin's motors."""

from __future__ import annotations

import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DesignError
from spiraltrunk.sim.machine import SimMachine
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.workflows.drive.twin.machine_load import MachineLoad


def test_a_scene_with_another_step_is_refused() -> None:
    """The motors' clock would else advance the physics by nothing, or by half a step."""
    with pytest.raises(DesignError, match=r"scene.timestep is 0.002; allowed: 0.001 s on the twin"):
        MachineLoad(SimMachine(PAPER, SceneOptions(timestep=2e-3)))
