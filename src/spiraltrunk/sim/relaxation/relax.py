"""Dynamic relaxation of the trunk alone in MuJoCo, its base clamped at any orientation, under quasi-static loading."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, final

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.checks import check_number, check_type, read_numbers
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.model.kinematics.shape import Shape, Status
from spiraltrunk.sim.relaxation.clamped_trunk import add_point_mass, clamped_spec, read_shape
from spiraltrunk.sim.robot.cable_friction import CableFriction
from spiraltrunk.sim.robot.trunk import TrunkOptions, cable_name, hinge_names, section_name, tune_joint_limits

_CHECK_STEPS = 10
"""Time steps between two evaluations of the rest criterion."""

_SLOW = 1000.0
"""The added damping ends below this multiple of the rest speed [-]."""

_STILL_TIME = 0.05
"""Time for which the rest criterion must hold [s]; at the turning point of an oscillation it holds for less."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class RelaxationOptions:
    """Options of the dynamic relaxation of a trunk with a clamped base."""

    timestep: float = 1e-3
    """Time step of the physics [s]."""
    pull_speed: float = 0.005
    """Speed of the winders [m/s]; infinite for a jump. With friction (0.15, ours) the shape depends on it: by 0.3 mm at
    0.005 and by 2 mm at 0.02."""
    has_smooth_ramps: bool = False
    """Whether winders follow a minimum-jerk polynomial of the same mean speed instead of a linear ramp. A sudden start
    or stop makes the trunk oscillate, which releases sticking cables."""
    tension_speed: float = 1.0
    """Rate of change of the tensions [N/s]; infinite for a jump."""
    damping_factor: float = 3.0
    """Joint damping over the design's [-]; changes the time to rest and not the equilibrium."""
    brake_factor: float = 1.0
    """Further factor of the joint damping while winders turn, and after it until every hinge is slower than 1000 times
    ``still`` [-]. A large factor removes the influence of inertia on which of several equilibria is reached."""
    armature_factor: float = 1.0
    """Armature of the joints over that of the grasp simulation [-]; changes the time to rest alone."""
    limit_factor: float = 1.0
    """Stiffness of the joint limits over that of the grasp simulation [-]; the overshoot is inversely proportional to
    it. At time steps of 1 ms, 1000 is stable with an armature factor of 100."""
    still: float = 1e-5
    """Rest criterion: largest speed of a hinge [rad/s]."""
    time_most: float = 60.0
    """Time limit for reaching rest after the end of a ramp [s]."""
    has_gripper: bool = True
    """Whether the tip carries the gripper's mass, with straight, rigid fingers."""
    trunk: TrunkOptions = field(default_factory=TrunkOptions)
    """Simulation options of the trunk."""

    def __post_init__(self) -> None:
        for name in ("timestep", "damping_factor", "brake_factor", "armature_factor", "limit_factor", "still"):
            check_number(f"relaxation.{name}", getattr(self, name), above=0.0)
        check_number("relaxation.time_most", self.time_most, least=0.0)
        for name in ("pull_speed", "tension_speed"):
            if getattr(self, name) != math.inf:
                check_number(f"relaxation.{name}", getattr(self, name), above=0.0)
        check_type("relaxation.trunk", self.trunk, TrunkOptions)


@final
@dataclass(frozen=True, kw_only=True)
class LoadStep:
    """Cable commands of one load step; a NaN is no command, and a cable without any command is slack."""

    pull: ArrayLike = math.nan
    """Cable pulled in from the straight trunk, negative where paid out, shape (n_cable,) [m]."""
    tension: ArrayLike = math.nan
    """Tension; the largest tension where a length is commanded too, shape (n_cable,) [N]."""


@final
@dataclass(frozen=True, kw_only=True)
class Relaxed:
    """State of the trunk at the end of a relaxation."""

    shape: Shape
    """Shape, its cables through the true holes; its status says whether the trunk is at rest."""
    cable_tension: np.ndarray
    """Tension at the motors, shape (n_cable,) [N]."""
    cable_pull: np.ndarray
    """Cable pulled in, measured through the simulated holes, shape (n_cable,) [m]."""
    speed: float
    """Largest speed of a hinge [rad/s]."""
    time: float
    """Simulated time [s]."""


@final
class RelaxationRig:
    """A trunk with a clamped base, compiled once for any number of load steps.

    Args:
        design: the trunk.
        theta_0: angle of the base axis below the horizontal [rad].
        roll: rotation of the trunk about its base axis [rad]; 0 puts the dorsal side in the plane z = 0.
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
        self._gripper = _gripper_mass(design) if self.options.has_gripper else (0.0, 0.0)
        self.model = self._build(theta_0, roll)
        tune_joint_limits(self.model, design)
        # Only now: the tuning of the limits depends on the armature.
        hinges = [self.model.joint(name).dofadr[0] for i in range(design.n_joint) for name in hinge_names(i)]
        self._hinges = np.array(hinges)
        self.model.dof_armature[self._hinges] *= self.options.armature_factor
        self._damping = self.model.dof_damping[self._hinges].copy()
        self.model.tendon_invweight0[self.model.tendon_limited > 0] /= self.options.limit_factor
        self.data = mujoco.MjData(self.model)
        self._cables = np.array([self.model.tendon(cable_name(c)).id for c in range(design.n_cable)])
        self._motors = np.array([self.model.actuator(cable_name(c)).id for c in range(design.n_cable)])
        self._tip = self.model.body(section_name(design.n_section - 1)).id
        self._tip_end = self.data.site(f"end_{design.n_section:02d}")
        self.friction = CableFriction(self.model, design, self.options.trunk)
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
        """Centre of `section_mass` from each section's proximal joint, along its axis, shape (n_section,) [m]."""
        length, (mass, beyond) = self.design.section_length, self._gripper
        moment = self.design.section_mass * self.design.section_center + self.loads * length
        moment[-1] += mass * (length[-1] + beyond)
        return moment / self.section_mass

    def relax(self, steps: Sequence[LoadStep] = ()) -> Relaxed:
        """Relax under gravity with slack cables, then apply the load steps, relaxing after each.

        Raises:
            ModelError: where a command is negative or not one number per cable.
        """
        *_, last = self.iterate(steps)
        return last

    def iterate(self, steps: Sequence[LoadStep] = ()) -> Iterator[Relaxed]:
        """As `relax`; yields the state under gravity and then the state after each load step."""
        commands = [self._read_commands(step) for step in steps]
        mujoco.mj_resetData(self.model, self.data)
        self._force = np.zeros(3)
        self.friction.reset(self.data)
        self._command(np.zeros(self.design.n_cable), np.zeros(self.design.n_cable))
        yield self._wait_for_rest(np.array(math.nan))
        for pull, tension in commands:
            self._ramp(pull, tension)
            yield self._wait_for_rest(pull)

    def push(self, force: ArrayLike, *, hold: Literal["length", "tension"] | None = None) -> Relaxed:
        """Relax from the present state under a force on the tip.

        Args:
            force: at the end of the last section until the next call, in the frame of `Shape`, shape (3,) [N].
            hold: what winders of taut cables keep, a length up to the largest tension; None for what they kept before.

        Raises:
            ModelError: where the force is not three finite numbers.
        """
        self._force = read_numbers("force", force, shape=(3,))
        self._apply_force()
        if hold is not None:
            self._forward()
            tension, is_length = self._tension(), hold == "length"
            pull = self._pull() + tension / self.options.trunk.cable_gain if is_length else self._straight
            self._command(pull, np.where((tension > 0) & is_length, self.design.cable.tension_max, tension))
        return self._wait_for_rest(np.array(math.nan))

    def _build(self, theta_0: float, roll: float) -> mujoco.MjModel:
        design, options, (mass, beyond) = self.design, self.options, self._gripper
        spec = clamped_spec(replace(design, gripper=None), options.trunk, theta_0=theta_0, roll=roll)
        end = design.section_length.tolist()
        for n, load in enumerate(self.loads.tolist()):
            add_point_mass(spec, n, end[n], load)
        add_point_mass(spec, design.n_section - 1, end[-1] + beyond, mass)
        spec.option.timestep = options.timestep
        # The equilibrium models have joint limits and no contacts.
        spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
        for joint in spec.joints:
            joint.damping[0] *= options.damping_factor
        return spec.compile()

    def _read_commands(self, step: LoadStep) -> tuple[np.ndarray, np.ndarray]:
        def read(name: str, value: ArrayLike, least: float) -> np.ndarray:
            array = np.asarray(value, float)
            if array.shape not in ((), (self.design.n_cable,)) or np.isinf(array).any() or (array < least).any():
                allowed = f"{self.design.n_cable} numbers, at least {least:.4g} or nan"
                raise ModelError(f"{name} is {value!r}; allowed: {allowed}")
            return np.broadcast_to(array, self.design.n_cable)

        return read("pull", step.pull, -2 * self.design.cable_stroke), read("tension", step.tension, 0.0)

    def _ramp(self, pull: np.ndarray, tension: np.ndarray) -> None:
        """Ramp lengths and tensions from their present values to the commanded ones, all arriving together."""
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
        self.model.dof_damping[self._hinges] = self._damping * self.options.brake_factor
        for part in parts:
            self._command(first + part * (last - first), start + part * (ceiling - start))
            self._advance(1)

    def _wait_for_rest(self, pull: np.ndarray) -> Relaxed:
        """Integrate until the rest criterion holds, or up to the time limit; ``pull`` are the commanded lengths."""
        period, still = _CHECK_STEPS * self.options.timestep, 0.0
        for _ in range(round(self.options.time_most / period)):
            self._advance(_CHECK_STEPS)
            speed = self._speed()
            if speed < _SLOW * self.options.still:
                self.model.dof_damping[self._hinges] = self._damping
            still = still + period if speed < self.options.still else 0.0
            if still > _STILL_TIME - 1e-9:
                break
        self._forward()
        return self._read_state(still > _STILL_TIME - 1e-9, pull)

    def _advance(self, steps: int) -> None:
        if self._force.any():
            self._apply_force()
        self.friction.step(self.data, steps)

    def _apply_force(self) -> None:
        arm = self._tip_end.xpos - self.data.xipos[self._tip]
        self.data.xfrc_applied[self._tip] = *self._force, *np.cross(arm, self._force)

    def _forward(self) -> None:
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

    def _read_state(self, is_still: bool, pull: np.ndarray) -> Relaxed:
        shape = read_shape(self.design, self.data)
        tension, most = self._tension(), -self.model.actuator_forcerange[self._motors, 0]
        is_sound = np.isfinite(self.data.qpos).all() and not any(w.number for w in self.data.warning)
        status = Status.CONVERGED
        if not (is_still and is_sound):
            status = Status.NOT_CONVERGED
        elif shape.is_shut.all():
            status = Status.ALL_SHUT
        elif (np.isfinite(pull) & (most > 0) & (tension > 0.999 * most)).any():
            status = Status.STALLED
        return Relaxed(
            shape=replace(shape, status=np.array(int(status))), cable_tension=tension, cable_pull=self._pull(),
            speed=self._speed(), time=float(self.data.time),
        )  # fmt: skip


def _gripper_mass(design: TrunkDesign) -> tuple[float, float]:
    """Mass of the straight gripper [kg] and its centre's distance from the last section's end [m]."""
    gripper = design.gripper
    if gripper is None:
        return 0.0, 0.0
    share = gripper.phalanx_length * gripper.phalanx_width**2
    middle = np.cumsum(gripper.phalanx_length) - gripper.phalanx_length / 2
    return gripper.mass, float(share @ middle / share.sum())
