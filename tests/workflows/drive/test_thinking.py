"""A strategy may think while the robot holds still, and not while it moves; afterwards nothing is made up for."""

from __future__ import annotations

import numpy as np
import pytest

from spiraltrunk.control.messages import Command
from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import RunError
from spiraltrunk.hardware.plant import REST, THINKING
from spiraltrunk.hardware.twin.clock import STEP
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.workflows.drive.twin.twin_robot import TwinRobot


class Run:
    """A plant on the twin; thinking is time in which the loop goes on, as in a thread of its own."""

    def __init__(self, robot):
        self.robot, self.plant = robot, robot.build_plant()
        self.T_base = self.plant.reset().T_world_base
        self.ends = []

    def step(self, tension, times=1):
        for _ in range(times):
            command = Command(T_world_base=self.T_base, cable_tension=np.array(tension))
            self.seen = self.plant.step(command)
            self.ends.append(self.robot.clock.now())

    def think(self, duration):
        self.robot.run(duration)


@pytest.fixture
def run():
    with TwinRobot(PAPER, SceneOptions(timestep=STEP)) as robot:
        robot.prepare()
        yield Run(robot)


@pytest.mark.slow
def test_thinking_at_rest_is_waited_for_and_in_motion_it_is_not(run):
    run.step([5.0, 2.0, 2.0], round(REST / CONTROL_PERIOD) + 2)
    before = run.seen.time
    run.think(0.4)
    run.step([5.0, 2.0, 2.0], 10)
    assert run.robot.driver.faults == ()
    assert run.seen.time == pytest.approx(before + 10 * CONTROL_PERIOD), "the run's time stands still"
    assert np.diff(run.ends[-10:]).min() == pytest.approx(CONTROL_PERIOD, abs=1e-6), "no command is hurried"
    run.step([9.0, 2.0, 2.0])
    run.think(0.1)
    with pytest.raises(RunError, match="stale command"):
        run.step([9.0, 2.0, 2.0])


@pytest.mark.slow
def test_thinking_for_ever_at_rest_stops_the_robot(run):
    run.step([5.0, 2.0, 2.0], round(REST / CONTROL_PERIOD) + 2)
    held = run.robot.clock.now()
    run.think(THINKING + 0.1)
    (fault,) = run.robot.driver.faults
    assert fault.kind.value == "stale command"
    assert fault.time - held == pytest.approx(THINKING, abs=0.03)
