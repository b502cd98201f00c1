"""A trunk that holds still under constant tensions: no watch takes it for a fault."""

import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.workflows.drive.twin.twin_robot import TwinOptions, TwinRobot

PERIOD = 0.1


@pytest.mark.parametrize("minutes", [0.25, pytest.param(10.0, marks=pytest.mark.slow)])
def test_constant_tensions_raise_no_alarm(minutes):
    with TwinRobot(PAPER, options=TwinOptions(seed=0)) as robot:
        robot.prepare()
        for _ in range(round(60.0 * minutes / PERIOD)):
            robot.driver.set_targets([20.0] * PAPER.n_cable, valid_for=PERIOD)
            robot.run(PERIOD)
            assert robot.driver.mode is Mode.ARMED, robot.driver.faults
        print(f"{minutes:g} quiet minutes without an alarm")
