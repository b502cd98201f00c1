"""How fast the cables of a curled trunk swing against its joints, which bounds the time step."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.robot.trunk import TrunkOptions, cable_name, hinge_names, trunk_spec


def compute_cable_swing(design: TrunkDesign, timestep: float) -> float:
    """Time step times the largest angular frequency of a curled trunk whose cables are held by length [-].

    The winders' stiffness K acts against the inertia M of the joints. The integrator takes the damping D of the joints
    implicitly and the stiffness explicitly, (M + h D) v' = M v - h K q with the step h. It is stable where h^2 K is
    less than 4 (M + h D / 2): the product is less than 2. A little beyond, the winders' largest tension bounds the
    swing; further on joints chatter.

    Args:
        design: the trunk; every joint is at its ventral limit.
        timestep: of the physics [s].
    """
    model = trunk_spec(design).compile()
    data = mujoco.MjData(model)
    for i in range(design.n_joint):
        data.joint(hinge_names(i)[1]).qpos[0] = design.joint_limit
    mujoco.mj_forward(model, data)
    jacobian, inertia = np.zeros((model.ntendon, model.nv)), np.zeros((model.nv, model.nv))
    mujoco.mju_sparse2dense(jacobian, data.ten_J, model.ten_J_rownnz, model.ten_J_rowadr, model.ten_J_colind)
    mujoco.mj_fullM(model, data, inertia)
    levers = jacobian[[model.tendon(cable_name(c)).id for c in range(design.n_cable)]]
    inertia += timestep / 2 * np.diag(model.dof_damping)
    squares = np.linalg.eigvals(np.linalg.solve(inertia, TrunkOptions().cable_gain * levers.T @ levers)).real
    return timestep * math.sqrt(float(squares.max()))
