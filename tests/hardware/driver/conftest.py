"""Robots whose driver is tried."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.motors.sts import line as sts_line


def _load(name: str) -> ModuleType:
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, Path(__file__).parent / "fakes" / f"{name}.py")
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        spec.loader.exec_module(module)
    return sys.modules[name]


@pytest.fixture(scope="session")
def prepared():
    """Copies of prepared robots: `copy_robot` and `prepare_once`."""
    return _load("prepared")


@pytest.fixture
def build_sts(monkeypatch, prepared):
    """Builds a robot of STS servos; all are closed at the end."""
    robots = []

    def build_sts(**options):
        # A thread answers on the terminal, on a computer that may be busy; in memory an answer is there at once.
        monkeypatch.setattr(sts_line, "ANSWER_TIME", 2.0 if options.get("has_terminal") else 0.01)
        try:
            robots.append(_load("sts_robot").Robot(**options))
        except DriveError as error:
            if "pseudo-terminal" in str(error):
                pytest.skip(str(error))
            raise
        return robots[-1]

    yield build_sts
    for robot in robots:
        robot.close()
