"""Relaxation in MuJoCo: the trunk with a fixed base, loaded quasi-statically and brought to rest.

The equilibrium models are compared with it: joints, masses and cables are the same.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal, final

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.model.kinematics.shape import Shape, Status
from spiraltrunk.sim.relaxation.clamped_trunk import PointMass, clamped_spec, gripper_center, read_shape
from spiraltrunk.sim.relaxation.options import RelaxationOptions
from spiraltrunk.sim.robot.cable_friction import CableFriction
from spiraltrunk.sim.robot.trunk import cable_name, hinge_names, section_name, tune_joint_limits

__all__ = ["LoadStep", "RelaxationOptions", "RelaxationRig", "Relaxed", "relax"]

_WATCH_STEPS = 10
"""Physics steps between two checks of the velocity."""

_SLOW = 1000.0
"""Ratio of hinge speed to that of rest below which the brake is released [-]."""

_STILL_TIME = 0.05
"""Time for which the velocity must stay below its bound [s], which excludes the turning points of oscillations."""


@final
@dataclass(frozen=True, kw_only=True)
class LoadStep:
    """Commands of the winders; nan is no command, and a cable without commands is slack."""

    pull: ArrayLike = math.nan
    """Length to pull in since the straight trunk, negative for cable paid out, shape (n_cable,) [m]."""
    tension: ArrayLike = math.nan
    """Tension to hold, or the largest one where a length is commanded too, shape (n_cable,) [N]."""


@final
@dataclass(frozen=True, kw_only=True)
class Relaxed:
    """Shape and forces at rest."""

    shape: Shape
    """The shape in the frame of `Shape`, its cables through the true holes."""
    cable_tension: np.ndarray
    """Tension at the motors, shape (n_cable,) [N]."""
    cable_pull: np.ndarray
    """Cable pulled in, through the simulated holes, shape (n_cable,) [m]."""
    speed: float
    """Largest speed of a hinge at the end [rad/s]."""
    time: float
    """Simulated time [s]."""


@final
class RelaxationRig:
    """A trunk with a fixed base, compiled once for any number of loadings.

    Args:
        design: the trunk.
        theta_0: angle of the base axis below the horizontal [rad].
        roll: rotation of the trunk about its base axis; at 0 its dorsal side is in the plane z = 0 [rad].
        loads: point mass at the end of each section, shape (n_section,) [kg].
        options: options of the relaxation.
    """

    def __init__(
        self,
        design: TrunkDesign,
        *,
        theta_0: float = math.pi / 2,
        roll: float = 0.0,
        loads: ArrayLike = 0.0,
        options: RelaxationOptions | None = None,
    ) -> None:
        self.design = design
        self.options = RelaxationOptions() if options is None else options
        self.loads = np.broadcast_to(np.asarray(loads, float), design.n_section)
        self.model = self._build(theta_0, roll)
        tune_joint_limits(self.model, design)
        # After tuning, which depends on the inertia.
        hinges = [self.model.joint(name).dofadr[0] for i in range(design.n_joint) for name in hinge_names(i)]
        self._hinges = np.array(hinges)
        self.model.dof_armature[self._hinges] *= self.options.armature_factor
        self._damping = self.model.dof_damping[self._hinges].copy()
        self.model.tendon_invweight0[self.model.tendon_limited > 0] /= self.options.limit_factor
        self.data = mujoco.MjData(self.model)
        self._cables = np.array([self.model.tendon(cable_name(c)).id for c in range(design.n_cable)])
        self._motors = np.array([self.model.actuator(cable_name(c)).id for c in range(design.n_cable)])
        self._bodies = np.array([self.model.body(section_name(n)).id for n in range(design.n_section)])
        has_friction = design.cable.friction > 0
        self.friction = CableFriction(self.model, design, self.options.trunk) if has_friction else None
        self._force = np.zeros(3)
        self._forward()
        self._straight = self.data.ten_length[self._cables].copy()

    @property
    def section_mass(self) -> np.ndarray:
        """Mass of each section with the gripper and the loads it carries, shape (n_section,) [kg]."""
        mass = self.design.section_mass + self.loads
        mass[-1] += self._gripper[0]
        return mass

    @property
    def section_center(self) -> np.ndarray:
        """Centre of these masses from each section's proximal joint, along its axis, shape (n_section,) [m]."""
        length, (mass, beyond) = self.design.section_length, self._gripper
        moment = self.design.section_mass * self.design.section_center + self.loads * length
        moment[-1] += mass * (length[-1] + beyond)
        return moment / self.section_mass

    def relax(self, steps: Sequence[LoadStep] = ()) -> Relaxed:
        """Rest under gravity with slack cables, then rest after each load step; the last shape.

        Raises:
            ModelError: where a command is negative or not one number per cable.
        """
        *_, last = self.iterate(steps)
        return last

    def iterate(self, steps: Sequence[LoadStep] = ()) -> Iterator[Relaxed]:
        """As `relax`, with the shape under gravity and after each load step."""
        commands = [self._read(step) for step in steps]
        mujoco.mj_resetData(self.model, self.data)
        self._force = np.zeros(3)
        if self.friction is not None:
            self.friction.reset(self.data)
        self._command(np.zeros(self.design.n_cable), np.zeros(self.design.n_cable))
        yield self._result(self._rest(), np.array(math.nan))
        for pull, tension in commands:
            self._ramp(pull, tension)
            yield self._result(self._rest(), pull)

    def push(self, force: ArrayLike, *, hold: Literal["length", "tension"] | None = None) -> Relaxed:
        """From the present state, rest under a force on the tip, with unchanged winder commands.

        Args:
            force: at the end of the last section until the next call, in the frame of `Shape`, shape (3,) [N].
            hold: quantity that winders of taut cables keep constant from now on; lengths up to the largest tension.

        Raises:
            ModelError: where the force is not three finite numbers.
        """
        self._force = np.asarray(force, float)
        if self._force.shape != (3,) or not np.isfinite(self._force).all():
            raise ModelError(f"force is {force!r}; allowed: 3 finite numbers")
        self._aim_force()
        if hold is not None:
            self._keep(hold == "length")
        return self._result(self._rest(), np.array(math.nan))

    # Building.

    @property
    def _gripper(self) -> tuple[float, float]:
        """Mass of the gripper [kg] and its centre's distance beyond the last section's end [m]."""
        gripper = self.design.gripper
        if gripper is None or not self.options.has_gripper:
            return 0.0, 0.0
        return gripper.mass, gripper_center(gripper)

    def _build(self, theta_0: float, roll: float) -> mujoco.MjModel:
        design, options, (mass, beyond) = self.design, self.options, self._gripper
        end = design.section_length
        points = [PointMass(section=n, along=float(end[n]), mass=float(self.loads[n])) for n in range(design.n_section)]
        points.append(PointMass(section=design.n_section - 1, along=float(end[-1]) + beyond, mass=mass))
        spec = clamped_spec(replace(design, gripper=None), options.trunk, points, theta_0=theta_0, roll=roll)
        spec.option.timestep = options.timestep
        for joint in spec.joints:
            joint.damping[0] *= options.damping_factor
        model = spec.compile()
        if not options.has_contact:
            model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
        return model

    # Moving.

    def _read(self, step: LoadStep) -> tuple[np.ndarray, np.ndarray]:
        out = []
        for name in ("pull", "tension"):
            value = np.asarray(getattr(step, name), float)
            least = -2 * self.design.cable_stroke if name == "pull" else 0.0
            if value.shape not in ((), (self.design.n_cable,)) or np.isinf(value).any() or (value < least).any():
                allowed = f"{self.design.n_cable} numbers, at least {least:.4g} or nan"
                raise ModelError(f"{name} is {getattr(step, name)!r}; allowed: {allowed}")
            out.append(np.broadcast_to(value, self.design.n_cable))
        return out[0], out[1]

    def _ramp(self, pull: np.ndarray, tension: np.ndarray) -> None:
        """Ramp the winders to the commanded lengths and tensions, all in the same time."""
        self._forward()
        now_pull, now_tension = self._pull(), self._tension()
        has_length, most = np.isfinite(pull), self.design.cable.tension_max
        first = np.where(has_length, now_pull + now_tension / self.options.trunk.cable_gain, self._straight)
        last = np.where(has_length, pull, self._straight)
        ceiling = np.minimum(np.where(np.isfinite(tension), tension, np.where(has_length, most, 0.0)), most)
        start = np.where(has_length, ceiling, now_tension)
        seconds = max(
            float(np.abs(last - first).max()) / self.options.pull_speed,
            float(np.abs(ceiling - start).max()) / self.options.tension_speed,
        )
        steps = max(1, math.ceil(seconds / self.options.timestep))
        parts = np.arange(1, steps + 1) / steps
        if self.options.has_smooth_ramps:
            parts = parts**3 * (10 - 15 * parts + 6 * parts**2)
        self._brake(True)
        for part in parts:
            self._command(first + part * (last - first), start + part * (ceiling - start))
            self._advance(1)

    def _rest(self) -> bool:
        """Simulate until all hinges are at rest; False if they are not in time."""
        period = _WATCH_STEPS * self.options.timestep
        still = 0.0
        for _ in range(round(self.options.time_most / period)):
            self._advance(_WATCH_STEPS)
            speed = self._speed()
            if speed < _SLOW * self.options.still:
                self._brake(False)
            is_slow = speed < self.options.still
            still = still + period if is_slow else 0.0
            if still > _STILL_TIME - 1e-9:
                return True
        return False

    def _brake(self, is_on: bool) -> None:
        self.model.dof_damping[self._hinges] = self._damping * (self.options.brake_factor if is_on else 1.0)

    def _advance(self, steps: int) -> None:
        if self._force.any():
            self._aim_force()
        if self.friction is None:
            mujoco.mj_step(self.model, self.data, steps)
        else:
            self.friction.step(self.data, steps)

    def _aim_force(self) -> None:
        tip, end = self._bodies[-1], self.data.site(f"end_{self.design.n_section:02d}").xpos
        self.data.xfrc_applied[tip] = *self._force, *np.cross(end - self.data.xipos[tip], self._force)

    def _keep(self, is_length: bool) -> None:
        self._forward()
        tension = self._tension()
        pull = self._pull() + tension / self.options.trunk.cable_gain if is_length else self._straight
        self._command(pull, np.where((tension > 0) & is_length, self.design.cable.tension_max, tension))

    def _forward(self) -> None:
        if self.friction is not None:
            self.friction.apply(self.data)
        mujoco.mj_forward(self.model, self.data)

    def _command(self, pull: np.ndarray, tension: np.ndarray) -> None:
        self.data.ctrl[self._motors] = np.maximum(self._straight - pull, 0.0)
        self.model.actuator_forcerange[self._motors, 0] = -tension

    def _pull(self) -> np.ndarray:
        return self._straight - self.data.ten_length[self._cables]

    def _tension(self) -> np.ndarray:
        return np.asarray(-self.data.actuator_force[self._motors])

    def _speed(self) -> float:
        return float(np.abs(self.data.qvel[self._hinges]).max())

    # Reading.

    def _result(self, is_still: bool, wanted: np.ndarray) -> Relaxed:
        self._forward()
        shape = read_shape(self.design, self.data)
        tension, pull = self._tension(), self._pull()
        most = -self.model.actuator_forcerange[self._motors, 0]
        is_sound = np.isfinite(self.data.qpos).all() and not any(w.number for w in self.data.warning)
        status = Status.CONVERGED
        if not (is_still and is_sound):
            status = Status.NOT_CONVERGED
        elif shape.is_shut.all():
            status = Status.ALL_SHUT
        elif (np.isfinite(wanted) & (most > 0) & (tension > 0.999 * most)).any():
            status = Status.STALLED
        return Relaxed(
            shape=replace(shape, status=np.array(int(status))), cable_tension=tension, cable_pull=pull,
            speed=self._speed(), time=float(self.data.time),
        )  # fmt: skip


def relax(
    design: TrunkDesign,
    steps: Sequence[LoadStep] = (),
    *,
    theta_0: float = math.pi / 2,
    roll: float = 0.0,
    loads: ArrayLike = 0.0,
    options: RelaxationOptions | None = None,
) -> Relaxed:
    """The shape after load steps, by simulation; see `RelaxationRig`."""
    return RelaxationRig(design, theta_0=theta_0, roll=roll, loads=loads, options=options).relax(steps)
