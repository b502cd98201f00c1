"""Differential inverse kinematics of the arm, within its limits."""

from __future__ import annotations

from collections.abc import Iterator
from typing import final

import mink
import mujoco
import numpy as np
from scipy.linalg.lapack import dposv

from spiraltrunk.control.arm_limits import speed_towards, standstill_margin
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.mujoco_log import compile_spec
from spiraltrunk.sim.robot.arm import add_arm, arm_home, arm_limits
from spiraltrunk.sim.robot.trunk import add_housing

SPEED_SHARE = 0.8
"""Share of the arm's speed that the inverse kinematics may use [-]."""

_RETURN = 1e-3
"""Cost of the posture's deviation from home [1/rad]; that of the frame's position is 1/m."""

_DAMPING = 1e-6
"""Damping: cost of the step [1/rad^2]."""

_STILL = 1e-7
"""Largest step of a joint at which the arm has arrived [rad]."""

_REGULAR = 1e-9
"""Tikhonov regularisation of the wrench, which singular postures do not determine [m^2]."""

_LAST_ROW = np.zeros((4, 4))
_LAST_ROW[3, 3] = 1.0


@final
class ArmReach:
    """Differential inverse kinematics (mink) with a posture task; one quadratic program per call.

    Where no limit of the program is active, which is nearly always, its solution is that of a linear system.
    """

    def __init__(self, design: TrunkDesign) -> None:
        self._model = build_arm_model(design)
        self._site = self._model.site("trunk_base").id
        self.home = arm_home(design.arm, self._model.nq)
        self.limits = arm_limits(design.arm)
        self._configuration = mink.Configuration(self._model, q=self.home)
        self._data = self._configuration.data
        self._rotation = self._data.site_xmat[self._site].reshape(3, 3)
        self._position = self._data.site_xpos[self._site]
        self.arrived = (np.empty(0), np.empty(0))
        """Joint positions and frame of the last call of `follow` that did not move."""
        self._task = mink.FrameTask("trunk_base", "site", position_cost=1.0, orientation_cost=0.5, lm_damping=1e-3)
        self._posture = mink.PostureTask(self._model, cost=_RETURN)
        self._posture.set_target(self.home)
        self._limit = mink.ConfigurationLimit(self._model, min_distance_from_limits=0.01)
        # Excludes positions where the allowed speed is 0: such a joint would stop all others.
        margin = standstill_margin(self.limits)
        self._limit.lower, self._limit.upper = self._limit.lower + margin, self._limit.upper - margin
        self._range = self._limit.lower.tolist(), self._limit.upper.tolist()
        self._jacobian, self._target = np.zeros((6, self._model.nv)), np.zeros(7)
        self._task.transform_target_to_world = mink.SE3(wxyz_xyz=self._target)  # `set_target` would copy it.
        self._halves = self._jacobian[:3], self._jacobian[3:]
        self._speed = None if self.limits.velocity is None else SPEED_SHARE * self.limits.velocity

        self.joint_names = tuple(self._model.joint(i).name for i in range(self._model.njnt))
        """Names of the joints, in order."""

    def T_base(self, q: np.ndarray) -> np.ndarray:
        """Frame of the trunk's base in the world at joint positions ``q``, shape (4, 4) [-, m]."""
        self._data.qpos[:] = q
        mujoco.mj_kinematics(self._model, self._data)
        return self._read_frame()

    def _read_frame(self) -> np.ndarray:
        T = _LAST_ROW.copy()
        T[:3, :3], T[:3, 3] = self._rotation, self._position
        return T

    def estimate_wrench(
        self, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray, torque: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Frame of the trunk's base, and the external wrench on it, estimated from the residual of the joint torques.

        The residual is the measured torque less that of the inverse dynamics of arm and housing. Franka's controller
        has the same estimate (O_F_ext_hat_K).

        Args:
            q: joint positions, shape (n_arm,) [rad].
            dq: joint velocities, shape (n_arm,) [rad/s].
            ddq: joint accelerations, shape (n_arm,) [rad/s^2].
            torque: joint torques, shape (n_arm,) [N m].

        Returns:
            The frame as of `T_base`, and the wrench in the world, force then torque, shape (6,) [N, N m].
        """
        data = self._data
        data.qpos[:], data.qvel[:], data.qacc[:] = q, dq, ddq
        mujoco.mj_inverse(self._model, data)
        jacobian = self._jacobian
        mujoco.mj_jacSite(self._model, data, *self._halves, self._site)
        square = jacobian @ jacobian.T
        square.reshape(-1)[::7] += _REGULAR
        return self._read_frame(), _solve(square, jacobian @ (data.qfrc_inverse - torque))

    def find_gearing(self, q: np.ndarray) -> float:
        """Largest share of its speed that a joint uses as the base moves at 1 m/s without turning [s/m].

        It is that of the worst direction, and grows towards the ends of the arm's reach. An arm without limits of speed
        has 0.
        """
        if self.limits.velocity is None:
            return 0.0
        self.T_base(q)
        mujoco.mj_comPos(self._model, self._data)
        jacobian = self._jacobian
        mujoco.mj_jacSite(self._model, self._data, jacobian[:3], jacobian[3:], self._site)
        return float((np.linalg.norm(np.linalg.pinv(jacobian)[:, :3], axis=1) / self.limits.velocity).max())

    def follow(self, q: np.ndarray, T_world_base: np.ndarray, dt: float) -> np.ndarray:
        """Joint positions after one period ``dt`` [s] on the way from ``q`` [rad] to a frame of the trunk's base."""
        if q.tolist() == self.arrived[0].tolist() and np.array_equal(T_world_base, self.arrived[1]):
            return q  # The last call with these arguments did not move.
        self._configuration.update(q)
        target = self._target
        mujoco.mju_mat2Quat(target[:4], T_world_base[:3, :3].ravel())
        target[4:] = T_world_base[:3, 3]
        step = self._free_step(q)
        if not self._is_within_limits(q, step):
            step = self._limited_step(dt)
        step = self._limit_speed(q, step, dt)
        reached = q + step
        if max(map(abs, step.tolist())) < _STILL:
            self.arrived = (reached.copy(), T_world_base.copy())
        return reached

    def steps(self, q: np.ndarray, T_world_base: np.ndarray, dt: float, most: int) -> Iterator[np.ndarray]:
        """Joint positions after each of ``most`` periods ``dt`` [s] of `follow` from ``q`` [rad] towards a frame."""
        for _ in range(most):
            q = self.follow(q, T_world_base, dt)
            yield q

    def approach(self, q: np.ndarray, target: np.ndarray, dt: float) -> np.ndarray:
        """Joint positions after one period ``dt`` [s] on the straight way from ``q`` to others, within speed and range.

        All have shape (n_arm,) [rad].
        """
        return q + self._limit_speed(q, np.clip(target, self._limit.lower, self._limit.upper) - q, dt)

    def _limit_speed(self, q: np.ndarray, step: np.ndarray, dt: float) -> np.ndarray:
        """The step scaled down to the allowed speeds, which keeps the path, shape (n_arm,) [rad]."""
        if self._speed is None:
            return step
        speed = self._speed_along(q, step, self._speed)
        # In plain numbers: on a few joints, arrays take three times as long. So it is below.
        fastest = max(abs(way) / most for way, most in zip(step.tolist(), speed.tolist(), strict=True))
        return step / max(1.0, fastest / dt)

    def _speed_along(self, q: np.ndarray, step: np.ndarray, speed: np.ndarray) -> np.ndarray:
        """Allowed speed of each joint on a step from ``q``, shape (n_arm,) [rad/s]."""
        if self.limits.braking is None:
            return speed
        return np.maximum(SPEED_SHARE * speed_towards(self.limits, q, step > 0), _STILL)

    def _free_step(self, q: np.ndarray) -> np.ndarray:
        """Step of the joints without limits, shape (n_arm,) [rad]."""
        jacobian, error, damping = self._task.compute_qp_residual(self._configuration)
        hessian = jacobian.T @ jacobian
        hessian.reshape(-1)[:: q.size + 1] += damping + _DAMPING + _RETURN**2
        return _solve(hessian, error @ jacobian + _RETURN**2 * (self.home - q))

    def _is_within_limits(self, q: np.ndarray, step: np.ndarray) -> bool:
        share, rows = self._limit.gain, zip(q.tolist(), step.tolist(), *self._range, strict=True)
        return all(share * (least - at) <= way <= share * (most - at) for at, way, least, most in rows)

    def _limited_step(self, dt: float) -> np.ndarray:
        tasks, limits = [self._task, self._posture], [self._limit]
        velocity = mink.solve_ik(self._configuration, tasks, dt, solver="daqp", damping=_DAMPING, limits=limits)
        return np.asarray(dt * velocity)


def _solve(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solution of a small positive definite system; LAPACK directly, which is faster than `scipy.linalg.solve`."""
    return np.asarray(dposv(matrix, right)[1])


def build_arm_model(design: TrunkDesign) -> mujoco.MjModel:
    """Model of the arm with the housing, as the arm's controller has it."""
    world = mujoco.MjSpec()
    world.compiler.degree = False
    mount = add_arm(world, design.arm, is_decimated=True)
    add_housing(mount.parent, design, mount.pos, mount.quat)
    return compile_spec(world)
