"""A trunk that holds still under constant tensions: no watch takes it for a fault, and no motor hums."""

import numpy as np
import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.workflows.drive.robot import RENEWAL
from spiraltrunk.workflows.drive.twin.twin_robot import TwinOptions, TwinRobot

PERIOD = 0.1

pytestmark = pytest.mark.usefixtures("prepared_once")


@pytest.mark.parametrize(
    "minutes",
    [
        pytest.param(0.1, marks=pytest.mark.slow),
        pytest.param(10.0, marks=[pytest.mark.slow, pytest.mark.timeout(7200)]),
    ],
)
def test_constant_tensions_raise_no_alarm(minutes):
    with TwinRobot(PAPER, options=TwinOptions(seed=0)) as robot:
        robot.prepare()
        for _ in range(round(60.0 * minutes / PERIOD)):
            robot.driver.set_targets([20.0] * PAPER.n_cable, valid_for=PERIOD)
            robot.run(PERIOD)
            assert robot.driver.mode is Mode.ARMED, robot.driver.faults
        print(f"{minutes:g} quiet minutes without an alarm")


def test_torques_at_rest_do_not_follow_the_last_digit_of_the_encoders():
    """Without a play before the friction's direction, that of 20 mN m turned by half from one count to the next."""
    with TwinRobot(PAPER, options=TwinOptions(seed=0)) as robot:
        robot.prepare()
        torques = []
        for number in range(round(3.0 / RENEWAL)):
            robot.driver.set_targets([20.0] * PAPER.n_cable, valid_for=PERIOD)
            robot.run(RENEWAL)
            if number * RENEWAL >= 2.0:
                torques.append([cable.torque_sent for cable in robot.driver.snapshot().cables])
    swings = np.ptp(torques, axis=0)
    print(f"torques at rest swing by {1e3 * swings.max():.2f} mN m")
    assert swings.max() < 1e-3
