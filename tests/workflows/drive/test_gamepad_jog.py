"""Jogging with a gamepad moves no cable faster than it is told to."""

from __future__ import annotations

import numpy as np
import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.hardware.gamepad import GamepadInput
from spiraltrunk.hardware.twin.clock import TwinClock
from spiraltrunk.workflows.drive.gamepad_jog import SLOW, jog_with_gamepad
from spiraltrunk.workflows.drive.robot import RENEWAL


class Followed:
    """A robot whose cables are where they are told to be."""

    design = PAPER

    def __init__(self) -> None:
        self.clock, self.pulls = TwinClock(), [[0.0] * PAPER.n_cable]

    def read_pulls(self) -> list[float]:
        return self.pulls[-1]

    def set_pulls(self, tensions: list[float], pulls: list[float]) -> None:
        self.pulls.append(pulls)

    def run(self, duration: float) -> None:
        self.clock.sleep_until(self.clock.now() + duration)

    def raise_fault(self) -> None: ...


class Pushed:
    """A gamepad whose right stick is pushed down after a moment in the middle."""

    def __init__(self, *, is_fast: bool) -> None:
        self.is_fast, self.n_read = is_fast, 0

    def read(self) -> GamepadInput:
        self.n_read += 1
        down = 1.0 if self.n_read > 3 else 0.0
        return GamepadInput(True, (0.0, 0.0, 0.0, down), (False,) * 5 + (self.is_fast,))


@pytest.mark.parametrize(("is_fast", "most"), [(True, 0.012), (False, SLOW * 0.012)])
def test_no_cable_is_faster_than_it_is_told_to(is_fast, most):
    robot = Followed()
    assert jog_with_gamepad(robot, Pushed(is_fast=is_fast), tension=5.0, speed=0.012, longest=2.0) == "2 s are over"
    speeds = np.diff(robot.pulls, axis=0) / RENEWAL
    assert speeds.max() == pytest.approx(most)
