"""What a robot's log holds of its motors."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.toml import format_design
from spiraltrunk.hardware.log import LogMetadata, LogWriter, load_log
from spiraltrunk.hardware.log.channels import MotorLog
from spiraltrunk.workflows.drive.recorder import Recorder
from spiraltrunk.workflows.drive.robot import RENEWAL
from spiraltrunk.workflows.drive.twin.twin_robot import TwinOptions, TwinRobot


def test_the_log_holds_the_motors_own_torque_and_the_one_that_was_sent(tmp_path: Path) -> None:
    """A motor of which something takes the current away still gets the torque that the winder wants."""
    path, metadata = tmp_path / "a.mcap", LogMetadata(design=format_design(PAPER), bus="virtual", is_twin=True)
    truth = []
    with TwinRobot(PAPER, options=TwinOptions(seed=0)) as robot, LogWriter(path, 0.0, metadata, waits=True) as log:
        robot.prepare()
        record = Recorder(log)
        for number in range(50):
            robot.driver.set_targets([5.0 + 0.3 * number] * 3, valid_for=RENEWAL)
            robot.run(RENEWAL)
            record(robot.driver)
            truth.append(robot.read_torques())
    motors = load_log(path)[MotorLog]
    np.testing.assert_allclose(motors.torque, truth, atol=2e-3)
    assert np.abs(motors.torque_sent - motors.torque).max() > 5e-4
    np.testing.assert_allclose(motors.torque_sent[1:], motors.torque[1:], atol=0.1)
