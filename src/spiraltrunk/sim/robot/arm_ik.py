"""The arm's inverse kinematics: from a frame of the trunk's base to joint positions, step by step, within limits."""

from __future__ import annotations

from typing import final

import mink
import mujoco
import numpy as np
from scipy.linalg.lapack import dposv

from spiraltrunk.control.arm_limits import standstill_margin, velocity_bounds
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.robot.arm import arm_home, arm_limits, arm_spec
from spiraltrunk.sim.robot.trunk import add_housing

SPEED_SHARE = 0.8
"""Share of the arm's speed that the inverse kinematics may use [-]."""

_RETURN = 1e-3
"""Cost of a posture beside home [1/rad], against 1/m for the frame's place."""

_DAMPING = 1e-6
"""Cost of moving at all [1/rad^2]."""

_STILL = 1e-7
"""Step of the joints below which the arm has arrived [rad]."""

_REGULAR = 1e-9
"""Keeps the wrench finite in a singular posture, where the torques do not tell it [m^2]."""


@final
class ArmReach:
    """Differential inverse kinematics (mink) with a posture to return to; one small quadratic program per call.

    Where the program's limits do not bind, which is nearly always, its solution is that of a linear system of 7.
    """

    def __init__(self, design: TrunkDesign) -> None:
        self._model = build_arm_model(design)
        self._site = self._model.site("trunk_base").id
        self.home = arm_home(design.arm, self._model.nq)
        self.limits = arm_limits(design.arm)
        self._configuration = mink.Configuration(self._model, q=self.home)
        self._data = self._configuration.data
        self._arrived = (np.empty(0), np.empty(0))
        self._task = mink.FrameTask("trunk_base", "site", position_cost=1.0, orientation_cost=0.5, lm_damping=1e-3)
        self._posture = mink.PostureTask(self._model, cost=_RETURN)
        self._posture.set_target(self.home)
        self._limit = mink.ConfigurationLimit(self._model, min_distance_from_limits=0.01)
        # Not where a joint may only stand: one that may not move on would stop all others.
        margin = standstill_margin(self.limits)
        self._limit.lower, self._limit.upper = self._limit.lower + margin, self._limit.upper - margin
        self._jacobian = np.zeros((6, self._model.nv))
        self._speed = None if self.limits.velocity is None else SPEED_SHARE * self.limits.velocity

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
        self._data.qpos[:] = q
        mujoco.mj_kinematics(self._model, self._data)
        return self._frame_now()

    def _frame_now(self) -> np.ndarray:
        T = np.zeros((4, 4))
        T[:3, :3] = self._data.site_xmat[self._site].reshape(3, 3)
        T[:3, 3] = self._data.site_xpos[self._site]
        T[3, 3] = 1.0
        return T

    def feel_base(
        self, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray, torque: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Frame of the trunk's base, and the wrench on it that explains torques beyond arm's and housing's own.

        Franka's controller offers the same estimate (O_F_ext_hat_K). Joint states and torques have shape (n_arm,)
        [rad, rad/s, rad/s^2, N m]; the frame is as of `T_base`, the wrench has shape (6,), force then torque [N, N m],
        in the world.
        """
        data = self._data
        data.qpos[:], data.qvel[:], data.qacc[:] = q, dq, ddq
        mujoco.mj_inverse(self._model, data)
        jacobian = self._jacobian
        mujoco.mj_jacSite(self._model, data, jacobian[:3], jacobian[3:], self._site)
        square = jacobian @ jacobian.T
        square.flat[::7] += _REGULAR
        return self._frame_now(), _solve(square, jacobian @ (data.qfrc_inverse - torque))

    def follow(self, q: np.ndarray, T_world_base: np.ndarray, dt: float) -> np.ndarray:
        """Joint positions one period ``dt`` [s] later on the way from ``q`` to a frame."""
        if np.array_equal(q, self._arrived[0]) and np.array_equal(T_world_base, self._arrived[1]):
            return q  # Nothing moved at the last call with the same question.
        self._configuration.update(q)
        self._task.set_target(mink.SE3.from_matrix(T_world_base))
        step = self._free_step(q)
        if not self._is_within_limits(q, step):
            step = self._limited_step(dt)
        if self._speed is not None:  # Slower along the same way, so that the path is kept.
            step = step / max(1.0, float((np.abs(step) / self._speed_along(q, step, self._speed)).max()) / dt)
        reached = q + step
        if np.abs(step).max() < _STILL:
            self._arrived = (reached.copy(), T_world_base.copy())
        return reached

    def _speed_along(self, q: np.ndarray, step: np.ndarray, speed: np.ndarray) -> np.ndarray:
        """Speed that each joint may have on a step from ``q``, shape (n_arm,) [rad/s]."""
        if self.limits.braking is None:
            return speed
        low, high = velocity_bounds(self.limits, q)
        return np.maximum(SPEED_SHARE * np.where(step > 0, high, -low), _STILL)

    def _free_step(self, q: np.ndarray) -> np.ndarray:
        """Step of the joints that an arm without limits would take, shape (n_arm,) [rad]."""
        jacobian, error, damping = self._task.compute_qp_residual(self._configuration)
        hessian = jacobian.T @ jacobian
        hessian.flat[:: q.size + 1] += damping + _DAMPING + _RETURN**2
        return _solve(hessian, error @ jacobian + _RETURN**2 * (self.home - q))

    def _is_within_limits(self, q: np.ndarray, step: np.ndarray) -> bool:
        share, limit = self._limit.gain, self._limit
        return bool(((step <= share * (limit.upper - q)) & (step >= share * (limit.lower - q))).all())

    def _limited_step(self, dt: float) -> np.ndarray:
        tasks, limits = [self._task, self._posture], [self._limit]
        velocity = mink.solve_ik(self._configuration, tasks, dt, solver="daqp", damping=_DAMPING, limits=limits)
        return np.asarray(dt * velocity)


def _solve(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solution of a small system with a positive definite matrix; LAPACK at once, for the sake of time."""
    return np.asarray(dposv(matrix, right)[1])


def build_arm_model(design: TrunkDesign) -> mujoco.MjModel:
    """The arm with the housing and nothing else: what the arm's controller knows of itself."""
    world = mujoco.MjSpec()
    world.compiler.degree = False
    frame = world.worldbody.add_frame(pos=[0, 0, design.arm.base_height])
    world.attach(arm_spec(design.arm, is_light=True), prefix="arm/", frame=frame)
    mount = world.site(f"arm/{design.arm.mount_site}")
    add_housing(mount.parent, design, mount.pos, mount.quat)
    return world.compile()
