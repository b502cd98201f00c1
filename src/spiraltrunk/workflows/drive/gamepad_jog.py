"""Jogging the cables with a gamepad, and saving where they are as a pose."""

from __future__ import annotations

import math
from typing import Protocol

from spiraltrunk.design.drum import SPARE, size_drum
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.hardware.gamepad import GamepadInput, GamepadSettings, init_jog, step_jog
from spiraltrunk.hardware.setup.poses import PullLimits
from spiraltrunk.workflows.drive.move_defaults import SPEED
from spiraltrunk.workflows.drive.robot import RENEWAL, Robot

SLOW = 0.25
"""Speed without the fast button over that with it [-] (ours)."""


class GamepadReader(Protocol):
    """What is needed of a gamepad."""

    def read(self) -> GamepadInput:
        """What it reports now."""


def compute_pull_limits(design: TrunkDesign) -> PullLimits:
    """How far each cable may be wound in: the travel of its drum with its spare, as the winders have it [m]."""
    drum = size_drum(design)
    least, most = -(1 + SPARE) * drum.travel_out, (1 + SPARE) * drum.travel_in
    return PullLimits(least=(least,) * design.n_cable, most=(most,) * design.n_cable)


def jog_with_gamepad(
    robot: Robot, gamepad: GamepadReader, *, tension: float, speed: float = SPEED, longest: float = math.inf
) -> str:
    """Move the cables as the gamepad says until it stops, and return why.

    Args:
        robot: the robot, armed.
        gamepad: the gamepad.
        tension: largest tension of each cable [N].
        speed: speed of a cable at full deflection with the fast button [m/s]; `SLOW` of it without.
        longest: time after which jogging ends [s].

    Raises:
        DriveError: for a tension out of its range.
        DesignError: for a speed out of its range.
        RunError: where a fault ended it.
    """
    design = robot.design
    directions = tuple((math.sin(angle), math.cos(angle)) for angle in design.cable.angles)
    settings = GamepadSettings(directions=directions, speed_slow=SLOW * speed, speed_fast=speed)
    limits = compute_pull_limits(design)
    state, pulls = init_jog(settings), robot.read_pulls()
    end = robot.clock.now() + longest
    while robot.clock.now() < end:
        state = step_jog(settings, state, gamepad.read(), RENEWAL)
        if state.stop:
            return state.stop
        pulls = [
            min(max(pull + speed * RENEWAL, least), most)
            for pull, speed, least, most in zip(pulls, state.speeds, *limits, strict=True)
        ]
        robot.set_pulls([tension] * len(pulls), pulls)
        robot.run(RENEWAL)
        robot.raise_fault()
    return f"{longest:g} s are over"
