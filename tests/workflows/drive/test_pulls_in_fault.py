"""A fault that is latched between two targets ends a move with its text."""

from __future__ import annotations

import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DriveError, RunError
from spiraltrunk.hardware.safety.fault import Fault, FaultKind
from spiraltrunk.workflows.drive.twin.twin_robot import TwinRobot

pytestmark = pytest.mark.usefixtures("prepared_once")

BUS = Fault(kind=FaultKind.BUS, time=0.0, cable=None, text="the board does not answer")


@pytest.mark.parametrize("is_latched", [True, False])
def test_targets_that_are_refused_in_a_fault_tell_the_fault(is_latched: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    with TwinRobot(PAPER) as robot:
        robot.prepare()

        def refuse(*_: object, **__: object) -> None:
            if is_latched:
                monkeypatch.setattr(type(robot.driver), "faults", property(lambda _: (BUS,)))
            raise DriveError("no targets are taken")

        monkeypatch.setattr(robot.driver, "set_targets", refuse)
        wanted, text = (RunError, "the board does not answer") if is_latched else (DriveError, "no targets are taken")
        with pytest.raises(wanted, match=text):
            robot.pull_to([0.01, 0.0, 0.0], tension=10.0)
        monkeypatch.undo()
