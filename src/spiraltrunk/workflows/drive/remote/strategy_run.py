"""A strategy on a twin in its scene, attended in every step."""

from __future__ import annotations

from collections.abc import Callable

from spiraltrunk.control.messages import Observation
from spiraltrunk.control.strategy import Status
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.workflows.drive.remote.requests import Run
from spiraltrunk.workflows.drive.trial import run_on_twin
from spiraltrunk.workflows.drive.twin.twin_robot import TwinRobot

Attend = Callable[[TwinRobot, str | None], None]
"""Called every 20 ms with the twin and the strategy's phase, None before there is one."""


def run_strategy(design: TrunkDesign, request: Run, attend: Attend) -> str:
    """Home, arm and run, as ``spiraltrunk drive run`` does, and describe the end in one line.

    Raises:
        ModelError: where the strategy cannot plan for the object.
        RunError: where a fault ended it before its first step.
    """
    robots: list[TwinRobot] = []

    def prepare(robot: TwinRobot) -> None:
        robots.append(robot)
        robot.watch = lambda _: attend(robot, None)

    def watch(_: Observation, status: Status) -> None:
        attend(robots[0], status.phase)

    done = run_on_twin(
        design, parse_object(request.shape), strategy=request.strategy, seed=request.seed, prepare=prepare, watch=watch
    )
    trial = done.trial
    if trial.log.gave_up:
        return f"{request.strategy} gave up: {trial.log.gave_up}"
    if trial.verdict.success:
        return f"{request.strategy} succeeded"
    return f"{request.strategy} failed: {trial.verdict.reason}"
