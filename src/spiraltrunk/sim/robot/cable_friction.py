"""Capstan friction of the cables at every hole of the simulated trunk, as an elastic force that yields.

Section k turns a cable by the wrap angle w_k: at its proximal hole between the direction of gap k - 1 and its axis (0
for k = 1), and at its distal hole between its axis and the direction of gap k. The tensions T_(k-1) and T_k obey
`model.statics.kernels.laws.capstan_law`. The generalised force -sum T_k grad L_k of the gaps L_k equals that of the
motor's T_0 on the whole cable and of F_k = T_(k-1) - T_k on S_k, the cable beyond hole k. Each F_k is elastic, with the
largest stiffness that the time step allows, and yields at the slip forces of the law. It holds at rest without creep;
the dry friction of MuJoCo's solver, one row per hole, creeps and costs three times as much.

Wrap angles are those at the true holes. Lengths and their gradients are those of the simulated holes, which are set
back (`TrunkOptions`): a gap that is exactly shut has no direction.
"""

from __future__ import annotations

from typing import final

import mujoco
import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.robot.cable_friction_kernel import CableGeometry, FrictionState, apply_friction, measure_gaps
from spiraltrunk.sim.robot.trunk import TrunkOptions, cable_name, hinge_order

STEP_SHARE = 0.2
"""Square of the time step times the highest angular frequency of sticking holes [-] (ours); above 0.5 shut joints
chatter at 60 N."""

COARSE_SHARE = 0.1
"""The same at steps above 1 ms [-] (ours), where the stiffness of the winders has a larger share: at 0.2 the tensions
of a rolled trunk chatter between 0 and 54 N at 2 ms."""

STIFFNESS_MOST = 1e4
"""Largest stiffness of a sticking hole [N/m] (ours), of the order of a winder's position control."""


@final
class CableFriction:
    """Friction of a trunk's cables, which advances with the physics.

    Args:
        model: any model with the trunk in it.
        design: the trunk; its ``cable.friction`` is the coefficient, 0 for no friction.
        options: the options that the model was built with.
    """

    def __init__(self, model: mujoco.MjModel, design: TrunkDesign, options: TrunkOptions) -> None:
        self._model = model
        self._geometry = _build_geometry(model, design, options)
        shape = (design.n_cable, design.n_joint)
        self._state = FrictionState(
            is_moving=np.zeros(1, bool), beyond=np.zeros(shape), force=np.zeros(shape), turn=np.zeros(shape),
            tension=np.zeros((shape[0], shape[1] + 1)),
        )  # fmt: skip
        mu = float(design.cable.friction)
        self._law = mu, self._stable_stiffness() if mu > 0 else 0.0
        self._motors = model.actuator_gainprm, model.actuator_forcerange

    @property
    def stiffness(self) -> float:
        """Stiffness of a sticking hole, friction force over displacement of the cable [N/m]."""
        return self._law[1]

    @property
    def tension(self) -> np.ndarray:
        """Tension of each cable at its motor and in each gap, shape (n_cable, n_joint + 1) [N]."""
        return self._state.tension.copy()

    @property
    def turn(self) -> np.ndarray:
        """Wrap angle w_k of each cable, shape (n_cable, n_joint) [rad]."""
        return self._state.turn.copy()

    def get_state(self) -> tuple[np.ndarray, ...]:
        """State of the friction, as copies of `FrictionState`."""
        return tuple(part.copy() for part in self._state)

    def set_state(self, state: tuple[np.ndarray, ...]) -> None:
        """Restore a state."""
        for part, saved in zip(self._state, state, strict=True):
            part[:] = saved

    def reset(self, data: mujoco.MjData) -> None:
        """Set the friction force at every hole to 0."""
        self._state.is_moving[0] = False
        self._state.force[:] = 0.0
        self.apply(data)

    def apply(self, data: mujoco.MjData) -> None:
        """Write the friction forces at the present hinge angles into ``qfrc_applied``."""
        if self._law[0] == 0:
            return
        motors = data.ctrl, *self._motors
        apply_friction(self._geometry, self._state, self._law, motors, (data.qpos, data.qfrc_applied))

    def step(self, data: mujoco.MjData, steps: int = 1) -> None:
        """Advance friction and physics by a number of time steps."""
        if self._law[0] == 0:
            mujoco.mj_step(self._model, data, steps)
            return
        for _ in range(steps):
            self.apply(data)
            mujoco.mj_step(self._model, data)

    def _stable_stiffness(self) -> float:
        """Largest stiffness at which the time step resolves the oscillation of the straight, sticking trunk [N/m]."""
        model, geometry, shape = self._model, self._geometry, self._state.turn.shape
        data, gradient = mujoco.MjData(model), np.zeros((*shape, 2))
        measure_gaps(geometry, data.qpos, np.zeros(shape), gradient, np.zeros(shape))
        rows = np.zeros((*shape, model.nv))
        for c, k in np.ndindex(shape):
            rows[c, k, geometry.dof[k:].ravel()] = gradient[c, k:].ravel()
        rows = rows.reshape(-1, model.nv)
        solved = np.zeros_like(rows)
        mujoco.mj_forward(model, data)
        mujoco.mj_solveM(model, data, solved, rows)
        fastest = float(np.linalg.eigvalsh(rows @ solved.T)[-1])
        share = STEP_SHARE if model.opt.timestep <= 1e-3 else COARSE_SHARE
        return min(STIFFNESS_MOST, share / (fastest * model.opt.timestep**2))


def _build_geometry(model: mujoco.MjModel, design: TrunkDesign, options: TrunkOptions) -> CableGeometry:
    holes, back = design.hole_position, options.hole_set_back * design.face_half_width * design.scale
    order = [hinge_order(i) for i in range(design.n_joint)]
    return CableGeometry(
        beyond=np.ascontiguousarray(holes[1:, 0]),
        before=holes[:-1, 1] - np.stack([design.section_length[:-1], np.zeros(design.n_joint)], axis=-1),
        back=np.stack([back[1:], back[:-1]], axis=-1),
        direction=np.ascontiguousarray(design.cable_direction[:, 1:]),
        inside=np.array([design.cable_in_section.sum() - 2 * back.sum()]),
        z_first=np.array([first.endswith("_z") for first, _ in order]),
        qpos=np.array([[int(model.joint(name).qposadr[0]) for name in names] for names in order]),
        dof=np.array([[int(model.joint(name).dofadr[0]) for name in names] for names in order]),
        motor=np.array([model.actuator(cable_name(c)).id for c in range(design.n_cable)]),
    )
