from __future__ import annotations

import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DriveError
from spiraltrunk.workflows.drive.twin.twin_robot import TwinOptions, TwinRobot


def test_a_board_that_has_tripped_passes_torque_when_a_person_cleared_it():
    with TwinRobot(PAPER, options=TwinOptions(seed=0)) as robot:
        robot.listen()
        with pytest.raises(DriveError, match="there is nothing to clear"):
            robot.clear("Ada")
        robot.clock.sleep_until(robot.clock.now() + 0.1)  # Nothing feeds the board.
        robot.run(0.02)
        with pytest.raises(DriveError, match="cannot home: no watchdog is present: it has tripped"):
            robot.home()
        robot.clear("Ada")
        assert robot.driver.snapshot().absence == ""
        with pytest.raises(DriveError, match="there is nothing to clear"):
            robot.clear("Ada")
