"""An arm whose every command is checked first: drivers only carry what passed.

What the arm itself reports, or its library raises, ends in `ArmState.error` and stays there: a person looks, and opens
the arm anew.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace
from typing import final

import numpy as np

from spiraltrunk.errors import DriveError, describe
from spiraltrunk.hardware.arm.arm_port import ArmLoad, ArmPort, ArmState
from spiraltrunk.hardware.arm.checks import (
    EARLY,
    STILL,
    ArmSettings,
    CollisionThresholds,
    check_acceleration,
    check_lead,
    check_pace,
    compute_travel_time,
    read_load,
    read_target,
)
from spiraltrunk.hardware.clock import Clock


class GuardedArm(ArmPort):
    """The checks and the states of an arm, over a driver that measures, follows, halts and releases it."""

    def __init__(self, settings: ArmSettings, clock: Clock) -> None:
        self.limits = settings.limits
        self.settings = settings
        """What commands are checked against."""
        self._clock = clock
        self._state: ArmState | None = None
        self._device_time: float | None = None
        self._error: str | None = None
        self._target: np.ndarray | None = None
        self._speed: np.ndarray | None = None
        """Speed from one target to the next; None before the second of a sequence."""
        self._sent = self._due = -np.inf
        self._is_held = False
        self._is_gone = False
        self._is_closed = False

    @final
    def read(self) -> ArmState:
        """Latest measured state; never waits longer than the driver's library for one packet.

        Its time is that of the driver's clock when the measurement was first seen. Errors are in `ArmState.error`; the
        numbers are then the last ones known.

        Raises:
            DriveError: after `close`, and where nothing was ever measured.
        """
        self._refuse_closed()
        self._refresh()
        if self._state is None:
            raise DriveError(f"the arm tells no state: {self._error}")
        return replace(self._state, error=self._error)

    @final
    def set_load(self, load: ArmLoad) -> None:
        """Tell the controller what hangs on the flange.

        Raises:
            DriveError: for a load that no body has or beyond the payload, while the arm moves or follows targets, and
                where the arm refuses.
        """
        state = self.read()
        if state.error is not None:
            raise DriveError(f"the arm takes no load: {state.error}")
        checked = read_load(load, self.settings.payload, self._tool_mass())
        speed = float(np.abs(state.velocity).max())
        if self._target is not None or not speed <= STILL:
            raise DriveError(
                f"the load cannot be set while the arm follows targets or moves ({speed:.3g} rad/s); allowed: hold it, "
                "and wait until it stands"
            )
        try:
            self._load(checked)
        except Exception as error:  # Drivers' libraries raise errors of many classes.
            raise DriveError(f"the arm refuses its load: {describe_failure(error)}") from error

    @final
    def send(self, position: np.ndarray) -> None:
        """Command joint positions, shape (n_arm,) [rad]; not sent where the arm reports an error, which `read` returns.

        Raises:
            DriveError: after `close`, and for a target that is not finite, of another shape, beyond a limit, faster
                than a joint, of a speed that changes faster than a joint accelerates, or too far from the measured
                position; nothing is sent then, and nothing is clamped. The first target after a stop counts as one at
                rest: a controller without an integral part may hold the arm a little off it.
        """
        target = read_target(self.settings, position)
        state = self.read()
        now, period = self._clock.now(), self.settings.period
        previous = state.position if self._target is None else self._target
        travel = compute_travel_time(self.settings, previous, target)
        due = max(self._due, now - period)
        check_pace(self.settings, travel, now + EARLY * period - due)
        time = max(period, now - self._sent)
        speed = np.zeros(target.shape) if self._target is None else (target - previous) / time
        if self._speed is not None:
            check_acceleration(self.settings, self._speed, speed, time)
        check_lead(self.settings, target, state.position)
        if state.error is not None:
            return
        self._is_held = False
        try:
            self._follow(target)
        except Exception as error:  # As above.
            self._latch(describe_failure(error))
            return
        self._target, self._speed, self._sent, self._due = target, speed, now, due + travel

    @final
    def hold(self) -> None:
        """Stop where the arm is and stay there; never refused.

        Called again it does nothing: an arm that gives way under a weight would otherwise sag a bit with each call.
        """
        self._target = self._speed = None
        if self._is_closed or self._is_held:
            return
        try:
            self._halt()
            self._is_held = True
        except Exception as error:  # As above; an arm that reported an error stands by its own controller.
            self._latch(describe_failure(error))

    @final
    def close(self) -> None:
        """Hold, and release the connection; harmless when called again."""
        if self._is_closed:
            return
        self.hold()
        self._is_closed = True
        try:
            self._release()
        except Exception as error:  # As above; the connection is given up.
            self._latch(describe_failure(error))

    def _begin(self, thresholds: CollisionThresholds) -> None:
        """Measure, and set the collision thresholds; a driver's last act of opening.

        Raises:
            DriveError: where the arm reports an error or refuses them; the connection is released then.
        """
        try:
            state = self.read()
            if state.error is not None:
                raise DriveError(f"{state.error}; allowed: an arm that stands ready: clear it in Desk, then open anew")
            self._set_thresholds(thresholds)
        except Exception as error:  # As above.
            self.close()
            if isinstance(error, DriveError):
                raise
            raise DriveError(f"the arm refuses its collision thresholds: {describe_failure(error)}") from error

    @abstractmethod
    def _measure(self) -> ArmState:
        """Latest state by the device, its time by the device's own clock."""

    @abstractmethod
    def _follow(self, target: np.ndarray) -> None:
        """Move towards a target that was checked, from now on."""

    @abstractmethod
    def _halt(self) -> None:
        """Stop as soon as the joints can, and stay; at once where the arm stands already."""

    @abstractmethod
    def _load(self, load: ArmLoad) -> None:
        """Tell the device what hangs on its flange; called while it stands."""

    @abstractmethod
    def _release(self) -> None:
        """End control and the connection; called once."""

    def _set_thresholds(self, thresholds: CollisionThresholds) -> None:
        """Set the external torques and forces at which the device stops by reflex; nothing where it has no reflex."""

    def _tool_mass(self) -> float:
        """Mass of the end effector that the device knows already [kg]."""
        return 0.0

    def _refuse_closed(self) -> None:
        if self._is_closed:
            raise DriveError("the arm is closed; allowed: open it anew")

    def _latch(self, error: str) -> None:
        """Keep the first error: what follows is its consequence."""
        self._error = self._error or error

    def _refresh(self) -> None:
        """Take over a new measurement, and note what the arm reports."""
        if self._is_gone:
            return  # It is not asked again: each try waits for the library's timeout.
        try:
            measured = self._measure()
        except Exception as error:  # As above.
            self._is_gone = True
            self._latch(describe_failure(error))
            return
        now = self._clock.now()
        parts = (measured.position, measured.velocity, measured.acceleration, measured.torque)
        if not all(np.isfinite(part).all() for part in parts):
            self._latch("the arm measures numbers that are not finite")
        elif measured.time != self._device_time or self._state is None:
            self._device_time, self._state = measured.time, replace(measured, time=now, error=None)
        elif not now - self._state.time <= self.settings.feedback_age:
            age, most = 1e3 * (now - self._state.time), 1e3 * self.settings.feedback_age
            self._latch(f"the arm's feedback is {age:.0f} ms old; allowed: {most:.0f} ms")
        if measured.error is not None:
            self._latch(measured.error)


def describe_failure(error: BaseException) -> str:
    """An error of a driver's library as one line."""
    return " ".join(str(error).split()) or describe(error)
