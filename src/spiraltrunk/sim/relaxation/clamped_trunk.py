"""MuJoCo spec of the trunk alone, its base clamped at any orientation in the frame of `Shape`."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.model.kinematics.cables import lengths_from_rotations
from spiraltrunk.model.kinematics.joint_limits import joint_angle
from spiraltrunk.model.kinematics.shape import Shape, Status
from spiraltrunk.sim.robot.trunk import TrunkOptions, add_trunk, section_name, trunk_quat_wxyz

_RADIUS = 1e-3
"""Radius of the ball that represents a point mass [m]; MuJoCo needs a moment of inertia above 0."""


def clamped_spec(design: TrunkDesign, options: TrunkOptions, *, theta_0: float, roll: float) -> mujoco.MjSpec:
    """The trunk with a clamped base; gravity along -y.

    The base axis points ``theta_0`` [rad] below +x; the trunk is rotated about it by ``roll`` [rad].
    """
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE  # MuJoCo 4.0.0's sparse Cholesky factor is at fault.
    spec.option.gravity = [0, -GRAVITY, 0]
    base, mount = np.zeros(4), np.zeros(4)
    tilt = np.array([math.cos(theta_0 / 2), 0.0, 0.0, -math.sin(theta_0 / 2)])
    mujoco.mju_mulQuat(base, tilt, np.array([math.cos(roll / 2), math.sin(roll / 2), 0.0, 0.0]))
    turn = trunk_quat_wxyz((1.0, 0.0, 0.0, 0.0), design.arm.roll)
    mujoco.mju_mulQuat(mount, base, turn * [1, -1, -1, -1])
    add_trunk(spec, spec.worldbody, design, options, quat_wxyz=mount)
    return spec


def add_point_mass(spec: mujoco.MjSpec, section: int, along: float, mass: float) -> None:
    """Add a mass [kg] to the axis of a section, ``along`` [m] from its proximal joint; nothing for a mass of 0."""
    if mass > 0:
        body = spec.body(section_name(section)).add_body(pos=[along, 0, 0])
        body.explicitinertial = True
        body.mass, body.ipos, body.inertia = mass, [0, 0, 0], [0.4 * mass * _RADIUS**2] * 3


def read_shape(design: TrunkDesign, data: mujoco.MjData) -> Shape:
    """Shape of the trunk of `clamped_spec`, its cables through the true holes; status and forces are not evaluated."""
    turn = np.array([data.body(section_name(n)).xmat.reshape(3, 3) for n in range(design.n_section)])
    base = data.site("trunk_base").xpos
    ends = np.array([data.site(f"end_{n + 1:02d}").xpos for n in range(design.n_section)])
    rotation = np.swapaxes(turn[:-1], -1, -2) @ turn[1:]
    cables = lengths_from_rotations(design, rotation)
    angle = joint_angle(rotation)
    return Shape(
        points=ends - base, joint_rotation=rotation, joint_angle=angle, gap=cables.gap, cable_change=cables.change,
        is_shut=angle >= design.joint_limit, status=np.array(int(Status.CONVERGED)),
    )  # fmt: skip
