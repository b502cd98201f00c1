"""A bench of arms without hardware: a clock, the joints' motion, and stand-ins for the drivers' libraries.

Classes and signatures are those of panda-python 1.1.1 and franky-control 2.0.0, read from the installed wheels; where a
wheel is installed, `test_stand_ins.py` compares the names. The stand-ins record what they are told.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import IntEnum
from types import ModuleType, SimpleNamespace

import numpy as np

from spiraltrunk.control.arm_limits import ArmLimits
from spiraltrunk.hardware.arm.arm_port import ArmLoad, ArmPort, ArmState
from spiraltrunk.hardware.arm.checks import ArmSettings
from spiraltrunk.hardware.arm.guarded_arm import GuardedArm
from spiraltrunk.hardware.clock import Clock

HOME = np.array([0.0, -0.7854, 0.0, -2.3562, 0.0, 1.5708, 0.7854])
SPEED = np.array([2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61])
LOW = np.array([-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973])
HIGH = np.array([2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973])
LIMITS = ArmLimits(position=(LOW, HIGH), velocity=SPEED, acceleration=np.full(7, 7.5), jerk=np.full(7, 3750.0),
                   torque=np.array([87.0] * 4 + [12.0] * 3))  # fmt: skip
SETTINGS = ArmSettings(limits=LIMITS, payload=3.0)


class HandClock(Clock):
    """Time that only the test advances."""

    def __init__(self) -> None:
        self.time = 100.0

    def now(self) -> float:
        return self.time

    def sleep_until(self, moment: float) -> None:
        self.time = max(self.time, moment)


@dataclass
class Joints:
    """Joints that follow their target at limited speed, with their controller's reports."""

    q: np.ndarray = field(default_factory=HOME.copy)
    target: np.ndarray = field(default_factory=HOME.copy)
    dq: np.ndarray = field(default_factory=lambda: np.zeros(7))
    time: float = 0.0
    sent: list[np.ndarray] = field(default_factory=list)
    calls: list[tuple[object, ...]] = field(default_factory=list)
    load_mass: float = 0.0
    is_gone: bool = False
    errors: set[str] = field(default_factory=set)
    mode: int = 1
    tool_mass: float = 0.0
    open_connections: int = 0

    def advance(self, seconds: float) -> None:
        step = np.clip(self.target - self.q, -SPEED * seconds, SPEED * seconds)
        self.q, self.dq, self.time = self.q + step, step / seconds, self.time + seconds

    def follow(self, target: object) -> None:
        self.check()
        self.target = np.array(target, float)
        self.sent.append(self.target)

    def stop(self) -> None:
        self.target = self.q.copy()

    def check(self) -> None:
        if self.is_gone:
            raise RuntimeError("libfranka: UDP receive: Timeout")

    def state(self) -> SimpleNamespace:
        """`franka::RobotState` with the fields that the drivers read."""
        self.check()
        flags = {name: name in self.errors for name in ("joint_reflex", "cartesian_reflex", "power_limit_violation")}
        errors, moment = SimpleNamespace(**flags), self.time
        return SimpleNamespace(
            q=self.q.copy(), dq=self.dq.copy(), tau_J=np.zeros(7), ddq_est=None, robot_mode=self.mode,
            time=SimpleNamespace(to_sec=lambda: moment), m_ee=self.tool_mass,
            current_errors=errors, last_motion_errors=errors,
        )  # fmt: skip


class KinematicArm(GuardedArm):
    """The joints alone."""

    def __init__(self, settings: ArmSettings, clock: Clock, joints: Joints) -> None:
        super().__init__(settings, clock)
        self._joints = joints
        joints.open_connections += 1

    def _measure(self) -> ArmState:
        state = self._joints.state()
        set_flags = [name for name, is_set in vars(state.current_errors).items() if is_set]
        return ArmState(time=self._joints.time, position=state.q, velocity=state.dq, acceleration=np.zeros(7),
                        torque=state.tau_J, error=", ".join(set_flags) or None)  # fmt: skip

    def _follow(self, target: np.ndarray) -> None:
        self._joints.follow(target)

    def _halt(self) -> None:
        self._joints.stop()

    def _load(self, load: ArmLoad) -> None:
        self._joints.load_mass = load.mass

    def _release(self) -> None:
        self._joints.open_connections -= 1


def make_panda_py(joints: Joints) -> dict[str, ModuleType]:
    """Modules that stand in for panda-python 1.1.1."""

    class JointPosition:
        def __init__(self, stiffness: object = None, damping: object = None, filter_coeff: float = 1.0) -> None:
            joints.calls.append(("JointPosition", filter_coeff))

        def set_control(self, position: object, velocity: object = None) -> None:
            joints.follow(position)

    class LibfrankaRobot:
        def set_collision_behavior(self, *thresholds: list[float]) -> None:
            # Lower and upper, accelerating and nominal: four of torque, four of force.
            assert [len(one) for one in thresholds] == [7] * 4 + [6] * 4
            joints.calls.append(("collision", thresholds[3], thresholds[7]))

        def set_load(self, load_mass: float, F_x_Cload: list[float], load_inertia: list[float]) -> None:
            assert len(F_x_Cload) == 3
            assert len(load_inertia) == 9
            joints.load_mass = load_mass

    class Panda:
        def __init__(self, hostname: str, name: str = "panda", realtime_config: object = None) -> None:
            joints.check()
            joints.open_connections += 1
            self.controller: object = None

        def __del__(self) -> None:
            joints.open_connections -= 1

        def get_robot(self) -> LibfrankaRobot:
            return LibfrankaRobot()

        def get_state(self) -> SimpleNamespace:
            return joints.state()

        def get_joint_limits_lower(self) -> np.ndarray:
            return LOW

        def get_joint_limits_upper(self) -> np.ndarray:
            return HIGH

        def raise_error(self) -> None:
            joints.check()

        def start_controller(self, controller: object) -> None:
            self.controller = controller
            joints.calls.append(("start",))

        def stop_controller(self) -> None:
            joints.stop()
            joints.calls.append(("stop",))

    package, controllers = ModuleType("panda_py"), ModuleType("panda_py.controllers")
    package.Panda, package.controllers, controllers.JointPosition = Panda, controllers, JointPosition
    return {"panda_py": package, "panda_py.controllers": controllers}


def make_franky(joints: Joints) -> dict[str, ModuleType]:
    """Module that stands in for franky-control 2.0.0."""

    class RealtimeConfig(IntEnum):
        Enforce = 0
        Ignore = 1

    class JointReference:
        def __init__(self, q: object = None, dq: object = None, tau_ff: object = None) -> None:
            self.q = q

    class JointImpedanceTrackingMotion:
        def __init__(
            self, *, stiffness: object, lower_joint_limits: object = None, upper_joint_limits: object = None
        ) -> None:
            joints.calls.append(("stiffness", stiffness))
            self.reference: JointReference | None = None
            self.is_started = False

        def set_reference(self, reference: JointReference) -> None:
            self.reference = reference
            if self.is_started:
                joints.follow(reference.q)

    class TorqueStopMotion:
        pass

    class Robot:
        def __init__(
            self, fci_hostname: str, relative_dynamics_factor: float = 1.0, *, realtime_config: object
        ) -> None:
            joints.check()
            joints.open_connections += 1
            self.is_in_control = False

        def __del__(self) -> None:
            joints.open_connections -= 1

        @property
        def state(self) -> SimpleNamespace:
            return joints.state()

        def poll_motion(self) -> bool:
            joints.check()
            return self.is_in_control

        def move(self, motion: object, asynchronous: bool = False) -> None:
            assert asynchronous
            if isinstance(motion, TorqueStopMotion):
                joints.stop()
                self.is_in_control = False
                return
            assert not self.is_in_control
            self.is_in_control = motion.is_started = True
            joints.follow(motion.reference.q)

        def join_motion(self, timeout: float | None = None) -> bool:
            assert timeout is not None
            return not self.is_in_control

        def stop(self) -> None:
            joints.stop()

        def set_collision_behavior(self, torque_thresholds: list[float], force_thresholds: list[float]) -> None:
            joints.calls.append(("collision", torque_thresholds, force_thresholds))

        def set_load(self, load_mass: float, F_x_Cload: list[float], load_inertia: list[float]) -> None:
            assert not self.is_in_control
            assert len(F_x_Cload) == 3
            assert len(load_inertia) == 9
            joints.load_mass = load_mass

    package = ModuleType("franky")
    package.Robot, package.RealtimeConfig = Robot, RealtimeConfig
    package.JointReference, package.TorqueStopMotion = JointReference, TorqueStopMotion
    package.JointImpedanceTrackingMotion = JointImpedanceTrackingMotion
    return {"franky": package}


@dataclass
class ArmBench:
    """An arm, its clock, and what the contract asks of the world around it."""

    arm: ArmPort
    clock: Clock
    advance: Callable[[float], None]
    """Lets time pass [s]; the joints follow."""
    sent: Callable[[], int]
    """Number of targets that reached the device."""
    loaded: Callable[[], float]
    """Mass that the device was told [kg]."""
    fail: Callable[[], None]
    """Breaks the connection."""
    settings: ArmSettings = SETTINGS

    def step(self, offset: np.ndarray, count: int) -> None:
        """Send ``count`` targets, from rest to rest, that end at ``offset`` [rad] from here."""
        start = self.arm.read().position
        for share in np.linspace(0.0, 1.0, count + 1)[1:]:
            self.arm.send(start + offset * share**3 * (10 - 15 * share + 6 * share**2))
            self.advance(self.settings.period)


def make_bench(name: str, patch: object, joints: Joints | None = None) -> ArmBench:
    """The arm ``name`` on its stand-in: kinematic, panda or franky."""
    joints, clock = Joints() if joints is None else joints, HandClock()
    if name == "kinematic":
        arm: ArmPort = KinematicArm(SETTINGS, clock, joints)
    elif name == "panda":
        for module, stand_in in make_panda_py(joints).items():
            patch.setitem(sys.modules, module, stand_in)
        from spiraltrunk.hardware.arm.panda_arm import PandaArm

        arm = PandaArm("robot", SETTINGS, clock)
    else:
        for module, stand_in in make_franky(joints).items():
            patch.setitem(sys.modules, module, stand_in)
        from spiraltrunk.hardware.arm.franky_arm import FrankyArm

        arm = FrankyArm("robot", SETTINGS, clock)

    def advance(seconds: float) -> None:
        for _ in range(max(1, round(seconds / 0.001))):
            joints.advance(0.001)
        clock.time += seconds

    return ArmBench(
        arm=arm, clock=clock, advance=advance, sent=lambda: len(joints.sent), loaded=lambda: joints.load_mass,
        fail=lambda: setattr(joints, "is_gone", True),
    )  # fmt: skip
