"""What the robot's process does in each cycle: heed the page in control, renew the targets, run the loop."""

from __future__ import annotations

import math
from contextlib import suppress
from typing import final

from spiraltrunk.errors import DriveError, RunError
from spiraltrunk.hardware.driver.lateness import Lateness
from spiraltrunk.hardware.driver.snapshot import Snapshot
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.workflows.drive.gamepad_jog import compute_pull_limits
from spiraltrunk.workflows.drive.move_defaults import SPEED, TENSION
from spiraltrunk.workflows.drive.remote.requests import (
    Alive,
    Arm,
    Clear,
    Disarm,
    Home,
    Jog,
    Leave,
    Limit,
    Move,
    Request,
    Run,
    Stop,
    check_pulls,
    check_request,
)
from spiraltrunk.workflows.drive.remote.state import RobotState
from spiraltrunk.workflows.drive.robot import LONGEST_HOMING, RENEWAL, Robot
from spiraltrunk.workflows.drive.twin.twin_robot import TwinRobot

PATIENCE = 0.8
"""Time after which a page that does not answer counts as gone [s] (ours)."""

VALIDITY = 0.1
"""Validity of the targets, renewed every `RENEWAL` [s] (ours): a process that hangs for longer is a fault."""


@final
class RobotService:
    """A robot, who is in control of it, and where its cables are to go.

    Cables follow the trunk at the floor of tension until they are jogged or moved; from then on they hold their length.
    Torque needs a page that answers: one that does not for ``patience`` has its robot let go.
    """

    def __init__(self, robot: Robot, *, patience: float = PATIENCE) -> None:
        self.robot = robot
        """The robot; while a strategy runs, the twin in its scene."""
        self.run = ""
        """Phase of the strategy that runs; empty while none does."""
        self.result = ""
        """How the last one ended."""
        self._patience = patience
        self._limits = compute_pull_limits(robot.design)
        self._asked = -math.inf
        self._note = ""
        self._tension, self._speed = min(TENSION, robot.design.cable.tension_max), SPEED
        self._goals: list[float | None] = [None] * robot.design.n_cable
        self._aims: list[float] = [0.0] * robot.design.n_cable
        self._is_letting_go = False
        self._homing = 0.0

    def handle(self, request: Request, now: float) -> None:
        """Carry out a request.

        Args:
            request: the request.
            now: time by `time.monotonic` [s].

        Raises:
            DriveError: where its values, the robot's state or the silence of the page forbid it.
        """
        check_request(self.robot.design, request)
        driver = self.robot.driver
        match request:
            case Alive(asked):
                self._asked = max(self._asked, min(asked, now))
            case Home():
                self._require_page(now)
                self._homing, self._note = 0.0, ""
                driver.home()
            case Arm():
                self._require_page(now)
                driver.arm()
                self._note = ""
                self._is_letting_go = False
                self._goals = [None] * len(self._goals)
            case Disarm():
                self._let_go()
            case Stop():
                self._note = ""
                driver.stop()
            case Leave():
                self._asked = -math.inf
                self.watch_page(now)
            case Clear(person):
                driver.clear_fault(person)
            case Jog(cable, way):
                self._require_armed(now)
                self._jog(cable, float(way))
            case Move(pulls):
                self._require_armed(now)
                self._set_goals(pulls)
            case Limit(tension, speed):
                self._tension, self._speed = float(tension), float(speed)
            case Run():
                self._check_run(now)
                self._note = ""

    def step(self, now: float) -> None:
        """Heed the page, renew the targets, and run the driver's loop for `RENEWAL`."""
        self.watch_page(now)
        if self.robot.driver.mode is not Mode.ARMED:
            self._is_letting_go = False
        elif not self._is_letting_go:
            self._renew()
        self._homing = self._homing + RENEWAL if self.robot.driver.mode is Mode.HOMING else 0.0
        if self._homing > LONGEST_HOMING:
            self._say(f"homing did not end in {LONGEST_HOMING:g} s: stopped")
            self.robot.driver.stop()
        self.robot.run(RENEWAL)

    def watch_page(self, now: float) -> None:
        """Let the cables go where the page in control does not answer."""
        mode = self.robot.driver.mode
        has_torque = mode is Mode.HOMING or (mode is Mode.ARMED and not self._is_letting_go)
        if has_torque and now - self._asked > self._patience:
            silence = "is gone" if math.isinf(self._asked) else f"did not answer for {now - self._asked:.1f} s"
            self._say(f"the page in control {silence}: the cables were let go")
            self._let_go()

    def read_state(self, now: float, lateness: Lateness | None = None) -> RobotState:
        """State of the robot; ``lateness`` is shown in place of the driver's, which a twin's clock makes zero."""
        snapshot, robot = self.robot.driver.snapshot(), self.robot
        is_twin = isinstance(robot, TwinRobot)
        return RobotState(
            is_twin=is_twin, snapshot=snapshot, pulls=tuple(robot.compute_pulls(snapshot)),
            goals=self._read_goals(snapshot), page_age=now - self._asked,
            lateness=snapshot.lateness if lateness is None else lateness,
            note=self._note, run=self.run, result=self.result,
            true_torques=robot.read_torques() if isinstance(robot, TwinRobot) else (),
            frames=robot.read_frames() if isinstance(robot, TwinRobot) else None,
        )  # fmt: skip

    def _read_goals(self, snapshot: Snapshot) -> tuple[float | None, ...]:
        """Goals of the cables as the trunk sees them; a strategy has its own."""
        if not self.run:
            return tuple(self._goals)
        pulls = self.robot.remove_slack([cable.pull_target for cable in snapshot.cables])
        return tuple(pull if math.isfinite(pull) else None for pull in pulls)

    def _say(self, note: str) -> None:
        self._note = note

    def _require_page(self, now: float) -> None:
        if not now - self._asked <= self._patience:
            raise DriveError("no page in control answers; take control first")

    def _require_armed(self, now: float) -> None:
        self._require_page(now)
        if self.robot.driver.mode is not Mode.ARMED or self._is_letting_go:
            raise DriveError(f"cables do not move in {self.robot.driver.mode.value}; enable the robot first")

    def _check_run(self, now: float) -> None:
        """A strategy runs on a twin of its own, and begins with that safe."""
        self._require_page(now)
        if not isinstance(self.robot, TwinRobot):
            raise DriveError("a page runs strategies on the twin alone; on hardware: `spiraltrunk drive run`")
        if self.robot.driver.mode is not Mode.SAFE:
            raise DriveError(f"the robot is {self.robot.driver.mode.value}; a strategy begins with it safe")

    def _let_go(self) -> None:
        """Disarm by the slow ramp; homing and a strategy on the twin end by a stop."""
        driver = self.robot.driver
        if self.run or driver.mode is Mode.HOMING:
            driver.stop()
        elif driver.mode is Mode.ARMED and not self._is_letting_go:
            with suppress(DriveError):  # A fault came between; its ramp is faster.
                driver.disarm()
            self._is_letting_go = True

    def _jog(self, cable: int, way: float) -> None:
        at = self._goals[cable]
        goals = list(self._goals)
        goals[cable] = (self.robot.read_pulls()[cable] if at is None else at) + way
        self._set_goals(tuple(goals))

    def _set_goals(self, goals: tuple[float | None, ...]) -> None:
        check_pulls(self.robot.design, goals, self._limits)
        for cable, pull in enumerate(self.robot.read_pulls()):
            if self._goals[cable] is None:
                self._aims[cable] = pull
        self._goals = list(goals)

    def _renew(self) -> None:
        """Aim at the next point of the way to the goals."""
        way = self._speed * RENEWAL
        for cable, goal in enumerate(self._goals):
            if goal is not None:
                self._aims[cable] += min(max(goal - self._aims[cable], -way), way)
        tensions = [0.0 if goal is None else self._tension for goal in self._goals]
        pulls = [math.inf if goal is None else aim for goal, aim in zip(self._goals, self._aims, strict=True)]
        try:
            self.robot.set_pulls(tensions, pulls, valid_for=VALIDITY)
        except (DriveError, RunError):
            if self.robot.driver.mode is Mode.ARMED:  # Else a fault came between, and is shown as such.
                raise
