"""Franka Research 3 through franky 2.0 (PyPI: franky-control).

The joints are moved by the library's JointImpedanceTrackingMotion, a spring-damper law on torques at 1 kHz in its C++
thread. A JointMotion for each target, the library's time-optimal planner, was tried and left: on franky-sim it ended
now and then with "Motion planner failed with error code -111" (also franky's issue 76), which stops the arm at once.

Tried on `franky-sim` 1.0.4, which enforces no limits and reports no errors; never on a real arm.
"""

from __future__ import annotations

from typing import Any, final

import numpy as np

from spiraltrunk.errors import DriveError, MissingPackage
from spiraltrunk.hardware.arm.arm_port import ArmLoad, ArmState
from spiraltrunk.hardware.arm.checks import ArmSettings, CollisionThresholds, position_range
from spiraltrunk.hardware.arm.guarded_arm import GuardedArm
from spiraltrunk.hardware.arm.libfranka_state import read_libfranka_state
from spiraltrunk.hardware.arm.open_within import CONNECT_TIME, open_within
from spiraltrunk.hardware.clock import Clock

STIFFNESS = (600.0, 600.0, 600.0, 600.0, 250.0, 150.0, 50.0)
"""Stiffness of the joints [N m/rad] (default of panda-python's JointPosition); damped critically by the library."""

STOP_TIME = 4.0
"""Longest wait for a stop [s] (ours: twice the library's longest damping)."""


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
        super().__init__(settings, clock)
        self._motion: Any = None
        self._begin(CollisionThresholds() if thresholds is None else thresholds)

    def _measure(self) -> ArmState:
        self._robot.poll_motion()
        state = self._robot.state
        return read_libfranka_state(state, state.ddq_est)

    def _follow(self, target: np.ndarray) -> None:
        reference = self._franky.JointReference(q=target)
        if self._motion is not None:
            self._motion.set_reference(reference)
            return
        low, high = position_range(self.settings)
        motion = self._franky.JointImpedanceTrackingMotion(
            stiffness=np.array(STIFFNESS), lower_joint_limits=low, upper_joint_limits=high
        )
        motion.set_reference(reference)
        self._robot.move(motion, asynchronous=True)
        self._motion = motion

    def _halt(self) -> None:
        if self._motion is not None:
            self._motion.set_reference(self._franky.JointReference(q=np.array(self._robot.state.q, float)))

    def _load(self, load: ArmLoad) -> None:
        self._end_motion()
        self._robot.set_load(float(load.mass), load.center.tolist(), load.inertia.T.ravel().tolist())

    def _release(self) -> None:
        try:
            self._end_motion()
        finally:
            self._robot = None

    def _tool_mass(self) -> float:
        return float(self._robot.state.m_ee)

    def _set_thresholds(self, thresholds: CollisionThresholds) -> None:
        self._robot.set_collision_behavior(list(thresholds.torque), list(thresholds.force))

    def _end_motion(self) -> None:
        """Let the library damp the arm to rest and end its control; Franka's own controller holds it then."""
        motion, self._motion = self._motion, None
        if motion is None:
            return
        if self._robot.is_in_control:
            self._robot.move(self._franky.TorqueStopMotion(), asynchronous=True)
        if not self._robot.join_motion(timeout=STOP_TIME):
            self._robot.stop()
            raise DriveError(f"the arm did not stop within {STOP_TIME:g} s; its control was ended")


def _load_library() -> Any:
    try:
        import franky
    except ImportError as error:
        raise MissingPackage("the FR3 needs franky-control: pip install 'franky-control>=2.0,<3'") from error
    return franky
