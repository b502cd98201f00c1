"""Joint positions of recorded commands, of a real simulated plant whose commands take effect late."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.control.strategy import Status, Strategy
from spiraltrunk.design import presets
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.robot.arm_ik import ArmReach
from spiraltrunk.sim.sensors import SensorOptions
from spiraltrunk.workflows.demos.options import RecordingOptions
from spiraltrunk.workflows.demos.recording.record import Recorder, build_episode, list_arm_positions
from spiraltrunk.workflows.grasp.world import AS_ANNOUNCED, draw_scene

RISE = 4e-3
"""Rise of the base in a control period [m]."""


class Rise(Strategy[tuple[int, np.ndarray]]):
    """The base rises from where it is, at constant speed."""

    name, steps = "rise", 12

    def widths(self, design):
        return 0.0, 1.0

    def init(self, observation: Observation) -> tuple[int, np.ndarray]:
        return 0, ArmReach(presets.PAPER).T_base(observation.arm_position)

    def step(self, state, observation):
        count, frame = state[0] + 1, state[1].copy()
        frame[2, 3] += RISE * count
        return (count, state[1]), Command(T_world_base=frame, cable_tension=np.zeros(3))

    def status(self, state):
        return Status(phase="reach", action="rise", is_done=state[0] > self.steps)


@pytest.mark.parametrize("delay", [0.0, 0.02, 0.06, 1.0])
def test_recorded_joints_lead_to_the_recorded_pose(delay: float) -> None:
    scene = draw_scene(parse_object("cylinder-60"), 0, strategy=Rise(), spread=AS_ANNOUNCED)
    scene = replace(scene, sensors=SensorOptions(delay=delay))
    recorder = Recorder()
    trial = recorder.run(presets.PAPER, scene, strategy=Rise(), seed=0)
    extra = {"index": 0, "job": "grasp"}
    episode = build_episode(trial, recorder, "cylinder-60", RecordingOptions(mode="joint-tension"), extra)
    reach = ArmReach(presets.PAPER)
    led = np.array([reach.T_base(position) for position in episode.command_arm_position])
    assert len(led) == Rise.steps
    np.testing.assert_allclose(led[:, :3, 3], episode.T_world_base_command[:, :3, 3], atol=RISE / 20)


def test_what_commands_under_way_lead_to_is_what_they_lead_to() -> None:
    options = replace(draw_scene(parse_object("cylinder-60"), 0), sensors=SensorOptions(delay=0.06))
    plant, other = (SimPlant(presets.PAPER, options) for _ in range(2))
    frame, home = plant.reset().T_world_base.copy(), plant.reach.home
    other.reset()
    for i in range(12):
        frame[2, 3] += RISE
        command = Command(T_world_base=frame, cable_tension=np.zeros(3))
        for each in (plant, other):
            each.step_joints(home + 0.01 * i, command) if i % 5 == 4 else each.step(command)
        assert len(list_arm_positions(plant)) == i + 1
    ahead = plant.predict_arm()
    assert len(ahead) == 3
    for position in ahead:
        plant.step(command)
        other.step(command)
        assert np.array_equal(plant.trace[-1].arm_command, position)
        assert np.array_equal(plant.trace[-1].qpos, other.trace[-1].qpos)  # Asking changes nothing.
