"""Capstan friction of the cables at every hole of the simulated trunk.

Between gap k - 1 and gap k a cable turns by w_k: at the proximal hole of section k, from the gap's direction to the
section's axis (none for k = 1), and at its distal hole, from the axis to the next gap's direction. The tensions T_(k-1)
and T_k on both sides obey `model.statics.kernels.capstan_law`. The generalised force -sum T_k grad L_k of the gaps L_k
equals that of the motor's T_0 on the whole cable and of F_k = T_(k-1) - T_k on S_k, the cable beyond hole k. So the
model needs nothing but forces on its hinges: each F_k is an elastic force that yields at the slip forces of the law, as
stiff as the time step allows. It holds at rest without creep; the solver's own dry friction, one row per hole, creeps
and costs three times as much.

Turns are those at the true holes; lengths and their gradients those of the holes as simulated (`TrunkOptions`), which
are set back because a gap that is exactly shut has no direction.
"""

from __future__ import annotations

from typing import final

import mujoco
import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.robot.cable_friction_kernel import Geometry, State, apply_friction, measure_gaps
from spiraltrunk.sim.robot.trunk import TrunkOptions, cable_name, hinge_order

STEP_SHARE = 0.2
"""Square of the fastest oscillation on sticking holes times the step [-]; above 0.5 shut joints chatter at 60 N."""

STIFFNESS_MOST = 1e4
"""Largest stiffness of a sticking hole [N/m], some that of a winder's position control."""


@final
class CableFriction:
    """The friction of a trunk's cables, to be advanced with its model.

    Args:
        model: any model with the trunk in it.
        design: the trunk; its ``cable.friction`` is the coefficient.
        options: the simulation that the model was built with.
    """

    def __init__(self, model: mujoco.MjModel, design: TrunkDesign, options: TrunkOptions) -> None:
        self._model = model
        self._geometry = _geometry(model, design, options)
        shape = (design.n_cable, design.n_joint)
        self._state = State(
            is_moving=np.zeros(1, bool), beyond=np.zeros(shape), force=np.zeros(shape), turn=np.zeros(shape),
            tension=np.zeros((shape[0], shape[1] + 1)),
        )  # fmt: skip
        self._law = float(design.cable.friction), self._stable_stiffness()
        self._motors = model.actuator_gainprm, model.actuator_forcerange

    @property
    def stiffness(self) -> float:
        """Force over sliding of a hole that sticks [N/m]."""
        return self._law[1]

    @property
    def tension(self) -> np.ndarray:
        """Tension of each cable at its motor and in each gap, shape (n_cable, n_joint + 1) [N]."""
        return self._state.tension.copy()

    @property
    def turn(self) -> np.ndarray:
        """Turn w_k of each cable, shape (n_cable, n_joint) [rad]."""
        return self._state.turn.copy()

    def reset(self, data: mujoco.MjData) -> None:
        """Forget all sliding: the holes hold nothing."""
        self._state.is_moving[0] = False
        self._state.force[:] = 0.0
        self.apply(data)

    def apply(self, data: mujoco.MjData) -> None:
        """Write the friction at the present hinge angles into ``qfrc_applied``."""
        motors = data.ctrl, *self._motors
        apply_friction(self._geometry, self._state, self._law, motors, (data.qpos, data.qfrc_applied))

    def step(self, data: mujoco.MjData, steps: int = 1) -> None:
        """Advance by so many steps of the physics."""
        for _ in range(steps):
            self.apply(data)
            mujoco.mj_step(self._model, data)

    def _stable_stiffness(self) -> float:
        """Stiffness at which all holes of the straight trunk, sticking, oscillate as fast as the step resolves."""
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
        return min(STIFFNESS_MOST, STEP_SHARE / (fastest * model.opt.timestep**2))


def _geometry(model: mujoco.MjModel, design: TrunkDesign, options: TrunkOptions) -> Geometry:
    holes, back = design.hole_position, options.hole_set_back * design.face_half_width * design.scale
    order = [hinge_order(i) for i in range(design.n_joint)]
    return Geometry(
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
