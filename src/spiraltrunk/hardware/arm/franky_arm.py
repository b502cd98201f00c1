"""Franka Research 3 through franky 2.0 (PyPI: franky-control).

Each target is a joint motion that replaces the one before; the library plans it at 1 kHz in C++ (Ruckig, time-optimal
within limits of speed, acceleration and jerk) and holds the last target. Tried on `franky-sim` 1.0.4, which enforces no
limits and reports no errors; never on a real arm.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, final

import numpy as np

from spiraltrunk.control.arm_limits import ArmLimits
from spiraltrunk.errors import DriveError, MissingPackage
from spiraltrunk.hardware.arm.arm_port import ArmLoad, ArmState
from spiraltrunk.hardware.arm.checks import ArmSettings, CollisionThresholds, intersect_limits
from spiraltrunk.hardware.arm.guarded_arm import GuardedArm
from spiraltrunk.hardware.arm.libfranka_state import read_libfranka_state
from spiraltrunk.hardware.arm.open_within import CONNECT_TIME, open_within
from spiraltrunk.hardware.clock import Clock

PLANNED = ("velocity", "acceleration", "jerk")
"""Limits that the library's planner keeps."""

STOP_TIME = 2.0
"""Longest wait for a stop [s] (ours; at full speed the FR3 needs under half of it)."""


@final
class FrankyArm(GuardedArm):
    """An FR3 at an address.

    Raises:
        MissingPackage: where franky-control is not installed.
        DriveError: where the arm cannot be reached in time, reports an error, or refuses its thresholds.
    """

    def __init__(
        self,
        address: str,
        settings: ArmSettings,
        clock: Clock,
        *,
        thresholds: CollisionThresholds | None = None,
        connect_time: float = CONNECT_TIME,
    ) -> None:
        self._franky = franky = _load_library()
        # Ignore: a kernel without real-time patches is allowed; the robot reports where packets come too late.
        self._robot: Any = open_within(
            connect_time,
            f"arm {address!r}",
            lambda: franky.Robot(address, realtime_config=franky.RealtimeConfig.Ignore),
        )
        limits = intersect_limits(settings.limits, _planner_limits(self._robot))
        super().__init__(replace(settings, limits=limits), clock)
        self._begin(CollisionThresholds() if thresholds is None else thresholds)
        for name in PLANNED:
            getattr(self._robot, f"joint_{name}_limit").set(getattr(limits, name).tolist())

    def _measure(self) -> ArmState:
        self._robot.poll_motion()
        state = self._robot.state
        return read_libfranka_state(state, state.ddq_est)

    def _follow(self, target: np.ndarray) -> None:
        motion = self._franky.JointMotion(target.tolist(), return_when_finished=False)
        self._robot.move(motion, asynchronous=True)

    def _halt(self) -> None:
        if self._robot.is_in_control:
            self._robot.move(self._franky.JointStopMotion(), asynchronous=True)

    def _load(self, load: ArmLoad) -> None:
        self._wait_for_stop()
        self._robot.set_load(float(load.mass), load.center.tolist(), load.inertia.T.ravel().tolist())

    def _release(self) -> None:
        try:
            self._wait_for_stop()
        finally:
            self._robot = None

    def _tool_mass(self) -> float:
        return float(self._robot.state.m_ee)

    def _set_thresholds(self, thresholds: CollisionThresholds) -> None:
        self._robot.set_collision_behavior(list(thresholds.torque), list(thresholds.force))

    def _wait_for_stop(self) -> None:
        if not self._robot.join_motion(timeout=STOP_TIME):
            self._robot.stop()
            raise DriveError(f"the arm did not stop within {STOP_TIME:g} s; its control was ended")


def _planner_limits(robot: Any) -> ArmLimits:
    """Largest speed, acceleration and jerk that the library plans: those of the Panda, below most of the FR3's."""
    velocity, acceleration, jerk = (np.array(getattr(robot, f"joint_{name}_limit").max, float) for name in PLANNED)
    return ArmLimits(position=None, velocity=velocity, acceleration=acceleration, jerk=jerk, torque=None)


def _load_library() -> Any:
    try:
        import franky
    except ImportError as error:
        raise MissingPackage("the FR3 needs franky-control: pip install 'franky-control>=2.0,<3'") from error
    return franky
