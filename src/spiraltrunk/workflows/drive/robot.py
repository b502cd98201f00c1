"""A robot that is driven, hardware or twin: its loop, homing and arming, and moves of its cables."""

from __future__ import annotations

import math
from abc import ABC
from collections.abc import Callable, Sequence
from typing import Self

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DriveError, RunError
from spiraltrunk.hardware.clock import Clock
from spiraltrunk.hardware.driver.snapshot import Snapshot
from spiraltrunk.hardware.driver.threaded_driver import Driver
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.hardware.winder.slack import compensate_slack, remove_slack
from spiraltrunk.workflows.drive.move_defaults import SPEED

LONGEST_HOMING = 120.0
"""Time after which homing counts as hung [s] (ours): STS servos may take 75 s to wind in and 28 s to be stirred."""

RENEWAL = 0.02
"""Time between two targets of a move [s] (ours)."""

CLEARING = 0.2
"""Time in which a watchdog that is cleared answers [s] (ours)."""

LISTENING = 0.1
"""Time for which the motors' feedback is looked at, once it has come [s] (ours)."""

LONGEST_SILENCE = 2.0
"""Time for which the first feedback is awaited: motors boot when a relay closes their supply [s] (ours)."""

Watch = Callable[[Driver], None]
"""Called after every renewal, for screens and logs."""


class Robot(ABC):
    """The driver of a robot and what a person does with it.

    A context manager: at its end the driver lets go, see `finish`, and is closed. After an error, Ctrl-C or a signal it
    lets go as on a fault.
    """

    design: TrunkDesign
    """The robot's design."""
    driver: Driver
    """Motors, gripper and arm."""
    slack: Sequence[float] = ()
    """Residual slack of each cable, see `hardware.winder.slack` [m]; empty for none."""
    clock: Clock
    """The driver's clock."""
    watch: Watch | None = None
    """Called while the robot runs; None for nothing."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        try:
            if kind is None:
                self.finish()
        finally:
            self.close()

    def close(self) -> None:
        """Let go as on a fault where torque is on, and release what was opened; harmless when called again."""
        self.driver.close()

    def run(self, duration: float) -> None:
        """Run the driver's loop for some time [s]."""
        end = self.clock.now() + duration - 1e-9
        shown = -math.inf
        while self.clock.now() < end:
            self.driver.wait()
            self.driver.tick()
            if self.watch is not None and self.clock.now() >= shown + RENEWAL:
                shown = self.clock.now()
                self.watch(self.driver)

    def listen(self) -> None:
        """Run until every motor has answered, at most for `LONGEST_SILENCE`, and for `LISTENING` more."""
        end = self.clock.now() + LONGEST_SILENCE
        while any(math.isnan(cable.temperature) for cable in self.driver.snapshot().cables):
            if self.clock.now() >= end:
                return
            self.run(RENEWAL)
        self.run(LISTENING)

    def clear(self, person: str) -> None:
        """Let a watchdog that has tripped pass torque again, as a person decided.

        Args:
            person: who decided it.

        Raises:
            DriveError: where there is nothing to clear, for an empty name, and where the watchdog stays away.
        """
        self.listen()
        if not self.driver.snapshot().absence and self.driver.mode is Mode.SAFE:
            raise DriveError("there is nothing to clear: the watchdog is present, and there is no fault")
        self.driver.clear_fault(person)
        self.run(CLEARING)
        absence = self.driver.snapshot().absence
        if absence:
            raise DriveError(f"no watchdog is present: {absence}")

    def home(self) -> None:
        """Wait for feedback, and find the zeros of the drums.

        Raises:
            DriveError: where the motors do not answer, or there is no watchdog.
            RunError: where a fault ended it.
        """
        self.listen()
        self.driver.home()
        end = self.clock.now() + LONGEST_HOMING
        while self.driver.mode is Mode.HOMING and self.clock.now() < end:
            self.run(RENEWAL)
        self.raise_fault()
        if self.driver.mode is Mode.HOMING:
            raise RunError(f"homing did not end in {LONGEST_HOMING:g} s")

    def prepare(self) -> None:
        """Home where that was not done, and arm, as a person would.

        Raises:
            DriveError: as of `home`.
            RunError: as of `home`.
        """
        if not self.driver.is_homed:
            self.home()
        self.driver.arm()

    def pull_to(self, pulls: Sequence[float], *, tension: float, speed: float = SPEED, hold: float = 1.0) -> None:
        """Wind every cable to its pull, all arriving together, and hold it there.

        Args:
            pulls: cable pulled in since the straight trunk, one per cable [m]; NaN for a cable that is free, at the
                floor of tension.
            tension: largest tension of the others [N].
            speed: speed of the cable with the longest way [m/s].
            hold: time at the end [s].

        Raises:
            DriveError: for a target out of its range.
            RunError: where a fault ended it.
        """
        if not (math.isfinite(speed) and speed > 0.0):
            raise DriveError(f"speed of a cable is {speed:g} m/s; allowed: above 0")
        start = self.read_pulls()
        if len(pulls) != len(start) or any(math.isinf(pull) for pull in pulls):
            raise DriveError(f"pulls are {list(pulls)}; allowed: {len(start)} lengths in m, NaN for a free cable")
        tensions = [0.0 if math.isnan(pull) else tension for pull in pulls]
        duration = max([0.0, *(abs(pull - at) for pull, at in zip(pulls, start, strict=True) if pull == pull)]) / speed
        began = self.clock.now()
        while (elapsed := self.clock.now() - began) < duration + hold:
            share = min(1.0, elapsed / duration) if duration > 0.0 else 1.0
            wanted = [
                math.inf if math.isnan(pull) else at + share * (pull - at)
                for pull, at in zip(pulls, start, strict=True)
            ]
            self.set_pulls(tensions, wanted)
            self.run(RENEWAL)
            self.raise_fault()

    def read_pulls(self) -> list[float]:
        """Cable pulled in since the straight trunk, as the trunk sees it, one per cable [m]."""
        return self.compute_pulls(self.driver.snapshot())

    def compute_pulls(self, snapshot: Snapshot) -> list[float]:
        """Cable pulled in since the straight trunk, as the trunk sees it, in a state of the driver [m]."""
        return self.remove_slack([cable.pull for cable in snapshot.cables])

    def remove_slack(self, pulls: Sequence[float]) -> list[float]:
        """Pulls as the trunk sees them, of those of the winders [m]."""
        stroke = self.design.cable_stroke
        return [remove_slack(*pair, stroke) for pair in zip(pulls, self.slack, strict=True)] if self.slack else [*pulls]

    def set_pulls(self, tensions: Sequence[float], pulls: Sequence[float], *, valid_for: float = RENEWAL) -> None:
        """Aim at these pulls, with their slack added.

        Args:
            tensions: upper limit of each cable's tension [N].
            pulls: upper limit of the cable pulled in since the straight trunk [m].
            valid_for: time for which they hold without being renewed [s].

        Raises:
            DriveError: as of `TrunkDriver.set_targets`.
            RunError: where a fault is latched, which the driver's thread may do at any moment.
        """
        if self.slack:
            stroke = self.design.cable_stroke
            pulls = [compensate_slack(*pair, stroke) for pair in zip(pulls, self.slack, strict=True)]
        try:
            self.driver.set_targets(tensions, list(pulls), valid_for=valid_for)
        except DriveError:
            self.raise_fault()
            raise

    def let_go(self) -> None:
        """Disarm, and wait until the torque is off.

        Raises:
            DriveError: where the driver is not armed.
        """
        self.driver.disarm()
        while self.driver.mode is Mode.ARMED or self.driver.snapshot().is_letting_go:
            self.run(RENEWAL)

    def finish(self) -> Snapshot:
        """Let go at the end of the work where the driver is armed, and return its state from before.

        Nothing renews the targets any more: what takes long, such as writing files, comes after it.

        Raises:
            RunError: where a fault came while it let go.
        """
        before = self.driver.snapshot()
        if before.mode is Mode.ARMED:
            try:
                self.let_go()
            except DriveError:  # A fault came between, whose ramp is faster.
                self.raise_fault()
                raise
            self.raise_fault()
        return before

    def raise_fault(self) -> None:
        """Raise the first latched fault.

        Raises:
            RunError: with its text, where there is one.
        """
        for fault in self.driver.faults[:1]:
            where = "" if fault.cable is None else f" of cable {fault.cable + 1}"
            raise RunError(f"{fault.kind.value}{where}: {fault.text}")
