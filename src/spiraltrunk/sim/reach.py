"""The arm's inverse kinematics: from a frame of the trunk's base to joint positions, step by step, within its limits."""

from __future__ import annotations

from typing import final

import mink
import mujoco
import numpy as np

from spiraltrunk.design.mount import ArmDesign
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.arm_spec import arm_home, arm_limits, arm_spec
from spiraltrunk.sim.trunk_spec import add_housing

SPEED_SHARE = 0.8
"""Share of the arm's speed that the inverse kinematics may use [-]."""


@final
class ArmReach:
    """Differential inverse kinematics (mink) with a posture to return to; one small quadratic program per call."""

    def __init__(self, design: TrunkDesign) -> None:
        self._model = build_arm_model(design)
        self._data = mujoco.MjData(self._model)
        self._site = self._model.site("trunk_base").id
        self.home = arm_home(design.arm, self._model.nq)
        self._configuration = mink.Configuration(self._model, q=self.home)
        self._frame = mink.FrameTask("trunk_base", "site", position_cost=1.0, orientation_cost=0.5, lm_damping=1e-3)
        self._posture = mink.PostureTask(self._model, cost=1e-3)
        self._posture.set_target(self.home)
        self._limits = _build_limits(self._model, design.arm)

    @property
    def n_joint(self) -> int:
        """Joints of the arm."""
        return int(self._model.nq)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, in order."""
        return tuple(self._model.joint(i).name for i in range(self._model.njnt))

    def T_base(self, q: np.ndarray) -> np.ndarray:
        """Frame of the trunk's base for joint positions ``q``, in the world, shape (4, 4) [-, m]."""
        self._configuration.update(q)
        return np.asarray(self._configuration.get_transform_frame_to_world("trunk_base", "site").as_matrix())

    def base_wrench(self, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Wrench on the trunk's base that explains the torques beyond those that arm and housing need to move as they do.

        Franka's controller offers the same estimate (O_F_ext_hat_K). Joint states and torques have shape (n_arm,)
        [rad, rad/s, rad/s^2, N m]; the wrench has shape (6,), force then torque [N, N m], in the world.
        """
        data = self._data
        data.qpos[:], data.qvel[:], data.qacc[:] = q, dq, ddq
        mujoco.mj_inverse(self._model, data)
        jacobian = np.zeros((6, self._model.nv))
        mujoco.mj_jacSite(self._model, data, jacobian[:3], jacobian[3:], self._site)
        return np.asarray(np.linalg.lstsq(jacobian.T, data.qfrc_inverse - torque, rcond=None)[0])

    def follow(self, q: np.ndarray, T_world_base: np.ndarray, dt: float) -> np.ndarray:
        """Joint positions one period ``dt`` [s] later on the way from ``q`` to a frame."""
        self._configuration.update(q)
        return self._advance(T_world_base, dt)

    def _advance(self, T_world_base: np.ndarray, dt: float) -> np.ndarray:
        self._frame.set_target(mink.SE3.from_matrix(T_world_base))
        tasks = [self._frame, self._posture]
        velocity = mink.solve_ik(self._configuration, tasks, dt, solver="daqp", damping=1e-6, limits=self._limits)
        self._configuration.integrate_inplace(velocity, dt)
        return np.array(self._configuration.q)


def build_arm_model(design: TrunkDesign) -> mujoco.MjModel:
    """The arm with the housing and nothing else: what the arm's controller knows of itself."""
    world = mujoco.MjSpec()
    world.compiler.degree = False
    frame = world.worldbody.add_frame(pos=[0, 0, design.arm.base_height])
    world.attach(arm_spec(design.arm), prefix="arm/", frame=frame)
    mount = world.site(f"arm/{design.arm.mount_site}")
    add_housing(mount.parent, design, mount.pos, mount.quat)
    return world.compile()


def _build_limits(model: mujoco.MjModel, arm: ArmDesign) -> list[mink.Limit]:
    limits: list[mink.Limit] = [mink.ConfigurationLimit(model, min_distance_from_limits=0.01)]
    speed = arm_limits(arm).velocity
    if speed is not None:
        names = [model.joint(i).name for i in range(model.njnt)]
        limits.append(mink.VelocityLimit(model, dict(zip(names, SPEED_SHARE * speed, strict=True))))
    return limits
