"""The real robot, or its twin, as a plant with the interface of the simulated one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol, final

import numpy as np

from spiraltrunk.control.command_check import read_command
from spiraltrunk.control.messages import CameraObservation, Command, Observation, Task
from spiraltrunk.control.plant import CONTROL_PERIOD, Plant
from spiraltrunk.errors import DriveError, RunError
from spiraltrunk.hardware.arm.arm_port import ArmState
from spiraltrunk.hardware.driver.threaded_driver import Driver
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.hardware.winder.slack import compensate_slack, remove_slack

MOVING = 0.02
"""Speed of a joint above which the arm counts as moving [rad/s] (ours)."""

BESIDE = np.radians(2.0)
"""Largest distance of a joint from its home position at the start of a run [rad] (ours)."""

SETTLING = 1.0
"""Time in which that distance goes to zero [s] (ours): of `BESIDE`, at most 0.07 rad/s and 0.2 rad/s^2 beside the
motion that is commanded, a thirtieth of a Panda's limits and less."""

THINKING = 1.0
"""Time for which a strategy may think while the robot holds still [s] (ours): three times what `sweep` takes to plan
its grasp. It is the longest validity of a command, `DriverOptions.validity_most`."""

REST = 0.2
"""Time for which commands must not have changed for that [s] (ours)."""

_STILL = (2e-3, 0.5, 1e-3, 0.02)
"""Changes up to which a command counts as unchanged: joints [rad], tension [N], pull [m], gripper [-] (ours)."""


class ArmReader(Protocol):
    """What the plant needs of the arm; the driver commands it."""

    def read(self) -> ArmState:
        """See `arm.arm_port.ArmPort.read`."""


class Reach(Protocol):
    """Kinematics and inverse dynamics of the arm with its housing, such as `spiraltrunk.sim` has."""

    home: np.ndarray
    """Joint positions at the start of a run, shape (n_arm,) [rad]."""

    def T_base(self, q: np.ndarray) -> np.ndarray:
        """Frame of the trunk's base in the world, shape (4, 4) [-, m]."""

    def follow(self, q: np.ndarray, T_world_base: np.ndarray, dt: float) -> np.ndarray:
        """Joint positions after one period on the way from ``q`` to a frame of the trunk's base."""

    def estimate_wrench(
        self, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray, torque: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Frame of the trunk's base, and the external wrench on it, shape (6,) [N, N m]."""


@final
class HardwarePlant(Plant):
    """Motors, servo and arm behind one driver.

    The driver must be armed by a person, or by the program that stands in for one on a twin, before `reset`; a fault
    ends the run with its text. Between two steps nothing refreshes the driver's target: a strategy that thinks for
    longer than the allowed age of a command makes it stale, and the driver stops. While the robot holds still, a
    command is valid for `THINKING`, so that a strategy may plan; the run's time stands still meanwhile, and no command
    is made up for.

    Args:
        driver: the driver, which was built with the arm.
        arm: the arm.
        reach: kinematics of the arm.
        task: what shall be done.
        camera: gives the latest observation of the object; None without a camera.
        slack: residual slack of each cable, see `winder.slack` [m]; empty for none.
    """

    control_period = CONTROL_PERIOD

    def __init__(
        self,
        driver: Driver,
        arm: ArmReader,
        reach: Reach,
        task: Task,
        *,
        camera: Callable[[], CameraObservation | None] | None = None,
        slack: Sequence[float] = (),
    ) -> None:
        self.driver, self.task = driver, task
        self._arm, self._clock, self._reach, self._camera = arm, driver.clock, reach, camera
        self._slack, self._stroke = tuple(slack), task.design.cable_stroke
        self._began: float | None = None
        self._count = 0

    def reset(self) -> Observation:
        """Start a run: time is 0 from here.

        The driver must be armed, and the arm at rest in its home posture: nothing moves by itself. Up to `BESIDE` a
        joint may stand beside it; the first target is where it stands, and the distance fades within `SETTLING`.

        Raises:
            RunError: where the driver is not armed, or the arm is elsewhere or moves.
        """
        if self.driver.mode is not Mode.ARMED:
            raise RunError(f"the driver is {self.driver.mode.value}; allowed: armed, after homing")
        state = self._arm.read()
        if np.abs(state.velocity).max() > MOVING:
            raise RunError("the arm moves; allowed: at rest in its home posture")
        beside = state.position - self._reach.home
        if not np.abs(beside).max() <= BESIDE:
            most = f"{np.degrees(BESIDE):g} deg"
            raise RunError(f"the arm is not in its home posture, within {most} of each joint; move it there first")
        self._began, self._count = self._clock.now(), 0
        self._position, self._beside = np.array(self._reach.home, float), beside
        self._held: tuple[np.ndarray, ...] | None = None
        self._since = self._began
        return self._observe()

    def step(self, command: Command) -> Observation:
        """Command for one control period: joints by inverse kinematics, winders with at most their tension and pull.

        Raises:
            RunError: before the first reset, for a command that is refused, and where a fault ended the run.
        """
        if self._began is None:
            raise RunError("the plant was stepped before its first reset; allowed: reset, then step")
        self._raise_fault()
        design = self.task.design
        command = read_command(command, design.n_cable, design.cable.tension_max)
        self._position = self._reach.follow(self._position, command.T_world_base, CONTROL_PERIOD)
        arm = self._position + self._beside * compute_share_left(self._count * CONTROL_PERIOD)
        pull = np.full(design.n_cable, np.inf) if command.cable_pull is None else command.cable_pull
        if self._slack:
            wound = [compensate_slack(one, loose, self._stroke) for one, loose in zip(pull, self._slack, strict=True)]
            pull = np.array(wound)
        gripper = max(-1.0, min(1.0, command.gripper))
        is_still = self._is_still(arm, command.cable_tension, pull, np.array(gripper))
        try:
            self.driver.set_targets(
                command.cable_tension, pull, arm_position=arm, gripper=gripper,
                valid_for=THINKING if is_still else CONTROL_PERIOD,
            )  # fmt: skip
        except DriveError as error:  # The driver's thread may have latched a fault since the check above.
            self._raise_fault()
            raise RunError(str(error)) from error
        late = self._clock.now() - self._began - self._count * CONTROL_PERIOD
        if late > CONTROL_PERIOD:
            self._began += late
        self._count += 1
        self._run_until(self._began + self._count * CONTROL_PERIOD)
        self._raise_fault()
        return self._observe()

    def _raise_fault(self) -> None:
        """Raise the first latched fault, with the run's time."""
        for first in self.driver.faults[:1]:
            time = self._count * CONTROL_PERIOD + min(0.0, first.time - self._clock.now())
            raise RunError(f"{first.kind.value} after {time:.2f} s: {first.text}")

    def _is_still(self, *targets: np.ndarray) -> bool:
        """Whether these targets have not changed for `REST`: joints, tension, pull and gripper, as in `_STILL`."""
        held, now = self._held, self._clock.now()
        if held is None or not all(
            np.allclose(new, old, rtol=0.0, atol=most) for new, old, most in zip(targets, held, _STILL, strict=True)
        ):
            self._held, self._since = tuple(np.array(one, float) for one in targets), now
        return now - self._since >= REST

    def _run_until(self, moment: float) -> None:
        """Run the driver's loop until it is ``moment`` [s]; a late loop runs once."""
        while True:
            self.driver.wait()
            self.driver.tick()
            if self._clock.now() >= moment - 1e-9:
                return

    def _observe(self) -> Observation:
        state = self._arm.read()
        T_base, wrench = self._reach.estimate_wrench(state.position, state.velocity, state.acceleration, state.torque)
        cables = self.driver.snapshot().cables
        assert self._began is not None
        return Observation(
            time=self._count * CONTROL_PERIOD,
            task=self.task,
            T_world_base=T_base,
            arm_position=state.position,
            arm_velocity=state.velocity,
            cable_pull=np.array(self._remove_slack([one.pull for one in cables])),
            cable_tension=np.array([max(0.0, one.tension) for one in cables]),
            base_force=wrench[:3],
            base_torque=wrench[3:],
            camera=None if self._camera is None else self._camera(),
        )

    def _remove_slack(self, pulls: list[float]) -> list[float]:
        """What the trunk sees of the cables wound in [m]."""
        if not self._slack:
            return pulls
        return [remove_slack(pull, one, self._stroke) for pull, one in zip(pulls, self._slack, strict=True)]


def compute_share_left(time: float) -> float:
    """Share of the distance from the home posture that is left at a time of the run [s], from 1 to 0.

    1 - 10 s^3 + 15 s^4 - 6 s^5 with s = t / T, T = `SETTLING`: the motion of least jerk from rest to rest (Flash and
    Hogan, "The coordination of arm movements", 1985), of at most 1.875 / T in speed and 5.77 / T^2 in acceleration.
    """
    s = min(1.0, max(0.0, time / SETTLING))
    return 1.0 - s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
