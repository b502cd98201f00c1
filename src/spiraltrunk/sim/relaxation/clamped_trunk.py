"""The trunk as a MuJoCo spec with a fixed base at any orientation in the frame of `Shape`, and point masses."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import final

import mujoco
import numpy as np

from spiraltrunk.design.gripper import GripperDesign
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.model.kinematics.cables import lengths_from_rotations
from spiraltrunk.model.kinematics.joint_limits import joint_angle
from spiraltrunk.model.kinematics.shape import Shape, Status
from spiraltrunk.sim.robot.trunk import TrunkOptions, add_trunk, section_name, trunk_quat_wxyz

_RADIUS = 1e-3
"""Radius of the ball that represents a point mass [m]: MuJoCo requires a positive inertia."""


@final
@dataclass(frozen=True, kw_only=True)
class PointMass:
    """A point mass on a section's axis."""

    section: int
    """Section, counted from 0 at the base."""
    along: float
    """Distance from the section's proximal joint [m]."""
    mass: float
    """Mass [kg]."""


def clamped_spec(
    design: TrunkDesign, options: TrunkOptions, points: Iterable[PointMass], *, theta_0: float, roll: float
) -> mujoco.MjSpec:
    """The trunk with its base axis ``theta_0`` [rad] below +x, turned by ``roll`` [rad] about it; gravity along -y."""
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.compiler.autolimits = True
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE  # MuJoCo 4.0.0's sparse Cholesky factor is faulty.
    spec.option.gravity = [0, -GRAVITY, 0]
    mount, turn = np.zeros(4), trunk_quat_wxyz((1.0, 0.0, 0.0, 0.0), design.arm.roll)
    mujoco.mju_mulQuat(mount, _base_quat_wxyz(theta_0, roll), turn * [1, -1, -1, -1])
    add_trunk(spec, spec.worldbody, design, options, quat_wxyz=mount)
    for point in points:
        if point.mass > 0:
            _add_point(spec.body(section_name(point.section)), point)
    return spec


def read_shape(design: TrunkDesign, data: mujoco.MjData) -> Shape:
    """Shape of the trunk of `clamped_spec`, its cables through the true holes, without forces and status."""
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


def gripper_center(gripper: GripperDesign) -> float:
    """Distance of the straight fingers' centre of mass from their bases [m], each phalanx's at half its length."""
    share = gripper.phalanx_length * gripper.phalanx_width**2
    middle = np.cumsum(gripper.phalanx_length) - gripper.phalanx_length / 2
    return float(share @ middle / share.sum())


def _base_quat_wxyz(theta_0: float, roll: float) -> np.ndarray:
    """Orientation of the trunk's base in the frame of `Shape`: -theta_0 about z, then ``roll`` about the axis."""
    quat = np.zeros(4)
    tilt = np.array([math.cos(theta_0 / 2), 0.0, 0.0, -math.sin(theta_0 / 2)])
    mujoco.mju_mulQuat(quat, tilt, np.array([math.cos(roll / 2), math.sin(roll / 2), 0.0, 0.0]))
    return quat


def _add_point(body: mujoco.MjsBody, point: PointMass) -> None:
    load = body.add_body(pos=[point.along, 0, 0])
    load.explicitinertial = True
    load.mass = point.mass
    load.ipos = [0, 0, 0]
    load.inertia = [0.4 * point.mass * _RADIUS**2] * 3
