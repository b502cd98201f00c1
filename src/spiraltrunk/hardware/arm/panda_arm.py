"""Franka's Panda (FER) through panda-python 1.1, whose wheel holds libfranka 0.9.2 for robot server 5.

The joints are moved by the library's JointPosition controller, a PD law on torques at 1 kHz in its C++ thread, with the
targets low-pass filtered. Written against the library's signatures; never tried on a real arm.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, final

import numpy as np

from spiraltrunk.control.arm_limits import ArmLimits
from spiraltrunk.errors import MissingPackage
from spiraltrunk.hardware.arm.arm_port import ArmLoad, ArmState
from spiraltrunk.hardware.arm.checks import ArmSettings, CollisionThresholds, intersect_limits
from spiraltrunk.hardware.arm.guarded_arm import GuardedArm
from spiraltrunk.hardware.arm.libfranka_state import read_libfranka_state
from spiraltrunk.hardware.arm.open_within import CONNECT_TIME, open_within
from spiraltrunk.hardware.clock import Clock

FILTER = 0.05
"""Coefficient of the controller's exponential filter at 1 kHz [-] (ours: a time constant of 20 ms, one period)."""


@final
class PandaArm(GuardedArm):
    """A Panda at an address.

    While the arm stands, `read` waits for the next packet of the robot, 1 ms; when the connection breaks, once for
    libfranka's timeout (unconfirmed: about 1 s).

    Raises:
        MissingPackage: where panda-python is not installed.
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
        panda_py, controllers = _load_library()
        self._panda: Any = open_within(connect_time, f"arm {address!r}", lambda: panda_py.Panda(address))
        super().__init__(replace(settings, limits=intersect_limits(settings.limits, _own_limits(self._panda))), clock)
        self._make_controller = controllers.JointPosition
        self._robot: Any = self._panda.get_robot()
        self._controller: Any = None
        self._begin(CollisionThresholds() if thresholds is None else thresholds)

    def _measure(self) -> ArmState:
        if self._controller is not None:
            self._panda.raise_error()
        return read_libfranka_state(self._panda.get_state())

    def _follow(self, target: np.ndarray) -> None:
        if self._controller is None:
            # Only without an error: the library clears errors by itself when a controller starts.
            controller = self._make_controller(filter_coeff=FILTER)
            self._panda.start_controller(controller)
            self._controller = controller
        self._controller.set_control(target)

    def _halt(self) -> None:
        if self._controller is not None:
            self._controller.set_control(np.array(self._panda.get_state().q, float))

    def _load(self, load: ArmLoad) -> None:
        self._end_controller()
        self._robot.set_load(float(load.mass), load.center.tolist(), load.inertia.T.ravel().tolist())

    def _release(self) -> None:
        self._end_controller()
        self._panda = self._robot = None

    def _tool_mass(self) -> float:
        return float(self._panda.get_state().m_ee)

    def _set_thresholds(self, thresholds: CollisionThresholds) -> None:
        torque, force = list(thresholds.torque), list(thresholds.force)
        # Lower and upper thresholds alike: contact and collision, while accelerating and at constant speed.
        self._robot.set_collision_behavior(torque, torque, torque, torque, force, force, force, force)

    def _end_controller(self) -> None:
        controller, self._controller = self._controller, None
        if controller is not None:
            self._panda.stop_controller()


def _own_limits(panda: Any) -> ArmLimits:
    """Joint ranges by the version of the robot's server: of a Panda, or of an FR3 that answers instead."""
    position = np.array(panda.get_joint_limits_lower(), float), np.array(panda.get_joint_limits_upper(), float)
    return ArmLimits(position=position, velocity=None, acceleration=None, jerk=None, torque=None)


def _load_library() -> tuple[Any, Any]:
    try:
        import panda_py
        import panda_py.controllers
    except ImportError as error:
        raise MissingPackage("the Panda needs panda-python: pip install 'panda-python>=1.1,<2'") from error
    return panda_py, panda_py.controllers
