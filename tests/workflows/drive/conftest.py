"""What several tests of the twin share."""

from __future__ import annotations

import importlib.util
import sys
from functools import partial
from pathlib import Path

import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.workflows.drive.twin.twin_robot import TwinRobot

COPIES = Path(__file__).parents[2] / "hardware" / "driver" / "fakes" / "prepared.py"


@pytest.fixture
def prepared_once(monkeypatch):
    """A twin of motors alone, without a fault, is homed once for all tests: the others begin with a copy."""
    if COPIES.stem not in sys.modules:
        spec = importlib.util.spec_from_file_location(COPIES.stem, COPIES)
        sys.modules[COPIES.stem] = module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    prepare, copies = TwinRobot.prepare, sys.modules[COPIES.stem]

    def prepare_or_copy(robot):
        if robot.design is PAPER and robot.machine is None and not robot.faults._entries:
            copies.prepare_once(robot, ("twin", robot.options), partial(prepare, robot))
        else:
            prepare(robot)

    monkeypatch.setattr(TwinRobot, "prepare", prepare_or_copy)
