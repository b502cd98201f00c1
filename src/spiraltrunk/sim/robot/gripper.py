"""MuJoCo bodies of the tip gripper: fingers of phalanges on elastic hinges, a closing and an opening cable group.

A group's tension acts on the finger joints. Where the group runs in two legs, it acts on the trunk's solid joints too:
tendons follow the legs as they are printed, with half the tension each. What a single leg does to the trunk is not
modelled, nor are friction on the way and the axial compression of the joints.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import mujoco
import numpy as np

from spiraltrunk.design.gripper import STRAND_LEVER, GripperDesign
from spiraltrunk.design.strand_route import find_strand_route
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.robot.materials import FRICTION, SOLIMP, SOLREF

GROUPS = ("gripper_close", "gripper_open")
"""Tendon and actuator of the two cable groups, on the fingers' inner and outer sides."""

LEGS = ("gripper_close_legs", "gripper_open_legs")
"""Tendon and actuator of the legs of the two groups through the trunk; absent where a group has one leg."""

PLATE, PLATE_RIM = 5e-3, 1.2e-3
"""Thickness of the printed plate of a large gripper, and its rim beyond the outer strands [m] (ours)."""

DAMPING_TIME = 0.04
"""Damping over stiffness of a finger joint [s] (ours: the default of the trunk's joints, `JointDesign`)."""

FINGER_ARMATURE = 1e-6
"""Inertia that is added to a finger joint [kg m^2] (ours), for the integrator."""

SITE_SET_BACK = 0.08
"""Distance of a leg's sites behind the faces over its distance from the axis [-]; 0 would chatter in a shut gap."""

SOLIMP_LIMIT = [0.95, 0.999, 0.01, 0.5, 2.0]
"""Impedance of a finger joint's limit: full within half a degree, as of the phalanges' faces."""


def add_gripper(spec: mujoco.MjSpec, tip: mujoco.MjsBody, gripper: GripperDesign, end: float) -> None:
    """Add the gripper to the tip section's body, ``end`` beyond its joint [m]."""
    for f in range(gripper.n_finger):
        _add_finger(tip, gripper, f, end)
        _exclude_overlaps(spec, gripper, f)
    for group, side in zip(GROUPS, (-1.0, 1.0), strict=True):
        _add_group(spec, gripper, group, side)
    if gripper.n_leg > 1:
        _add_plate(tip, gripper, end)


def add_legs(spec: mujoco.MjSpec, design: TrunkDesign, sections: Sequence[str]) -> None:
    """Add the legs of both cable groups beside the solid joints of the trunk, whose bodies are ``sections``.

    Each group is one tendon of two branches with half its length each (MuJoCo's pulley with the divisor 2), so that
    both carry half its tension.
    """
    gripper, route = design.gripper, find_strand_route(design)
    if gripper is None or gripper.n_leg < 2 or route.first_solid >= design.n_joint:
        return
    for name, direction in zip(LEGS, route.leg_directions(), strict=True):
        tendon = spec.add_tendon(name=name, group=4)
        for branch, turn in (("a", 1.0), ("b", -1.0)):
            tendon.wrap_pulley(2.0)
            y, z = turn * route.aside * direction
            for n in range(route.first_solid, design.n_section):
                for end, x in zip("pd", _leg_ends(design, n, route.aside), strict=True):
                    site = f"{name}_{n + 1:02d}{branch}{end}"
                    spec.body(sections[n]).add_site(name=site, group=4, pos=[x, y, z])
                    tendon.wrap_site(site)
        _add_pull(spec, name, gripper.tension_max)


def _leg_ends(design: TrunkDesign, n: int, aside: float) -> tuple[float, float]:
    """Axial positions at which a leg enters and leaves section ``n`` [m]."""
    solid, back = design.solid, SITE_SET_BACK * aside
    begin, end = aside * math.tan(solid.lean_proximal), aside * math.tan(solid.lean_distal)
    return begin + back, float(design.section_length[n]) - end - back


def phalanx_name(finger: int, j: int) -> str:
    """Body of phalanx ``j`` of a finger, both counted from 0."""
    return f"finger_{finger + 1}_{j + 1}"


def _add_finger(tip: mujoco.MjsBody, gripper: GripperDesign, finger: int, end: float) -> None:
    angle = 2 * math.pi * finger / gripper.n_finger
    out = np.array([0.0, math.cos(angle), math.sin(angle)])
    share = gripper.phalanx_length * gripper.phalanx_width**2
    masses = gripper.mass / gripper.n_finger * share / share.sum()
    parent, position = tip, np.array([end, 0.0, 0.0]) + gripper.mount_radius * out
    turn = [math.cos(angle / 2), math.sin(angle / 2), 0.0, 0.0]
    for j in range(gripper.n_phalanx):
        body = parent.add_body(name=phalanx_name(finger, j), pos=position, quat=turn)
        _add_phalanx(body, gripper, j, masses[j])
        parent, position, turn = body, np.array([gripper.phalanx_length[j], 0, 0]), [1.0, 0, 0, 0]


def _add_phalanx(body: mujoco.MjsBody, gripper: GripperDesign, j: int, mass: float) -> None:
    length, width = gripper.phalanx_length[j], gripper.phalanx_width[j]
    stiffness = float(gripper.joint_stiffness[j])
    joint = body.add_joint(
        name=body.name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 0, -1], limited=True,
        range=[-gripper.delta_theta, gripper.delta_theta], armature=FINGER_ARMATURE,
        solref_limit=SOLREF, solimp_limit=SOLIMP_LIMIT,
    )  # fmt: skip
    joint.stiffness[0] = stiffness
    joint.damping[0] = DAMPING_TIME * stiffness
    radius = width / 2
    body.explicitinertial = True
    body.mass = mass
    body.ipos = [length / 2, 0, 0]
    body.inertia = [mass * radius**2 / 2] + [mass * (3 * radius**2 + length**2) / 12] * 2
    middle, half = length / 2, _capsule_half_length(gripper, j)
    body.add_geom(
        name=body.name, type=mujoco.mjtGeom.mjGEOM_CAPSULE, size=[radius, 0, 0],
        fromto=[middle - half, 0, 0, middle + half, 0, 0], rgba=[0.85, 0.45, 0.40, 1],
        solref=SOLREF, solimp=SOLIMP, condim=3, friction=FRICTION,
    )  # fmt: skip


def _add_plate(tip: mujoco.MjsBody, gripper: GripperDesign, end: float) -> None:
    """Add the plate that carries the fingers of a large gripper, wider than the tip; its mass is the fingers'."""
    radius = gripper.mount_radius + STRAND_LEVER * gripper.finger_width + PLATE_RIM
    tip.add_geom(
        name="gripper_plate", type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[radius, 0, 0],
        fromto=[end - PLATE, 0, 0, end, 0, 0], rgba=[0.85, 0.45, 0.40, 1],
        solref=SOLREF, solimp=SOLIMP, condim=3, friction=FRICTION,
    )  # fmt: skip


def _capsule_half_length(gripper: GripperDesign, j: int) -> float:
    """Half the length of a phalanx's capsule without its caps [m]; with them, it reaches from joint to joint."""
    length, width = float(gripper.phalanx_length[j]), float(gripper.phalanx_width[j])
    return max(length - width, 0.05 * width) / 2


def _add_group(spec: mujoco.MjSpec, gripper: GripperDesign, group: str, side: float) -> None:
    """Add one cable with a strand for each finger; its lever at a joint is STRAND_LEVER of the phalanx's width."""
    tendon = spec.add_tendon(name=group)
    for f in range(gripper.n_finger):
        for j in range(gripper.n_phalanx):
            tendon.wrap_joint(phalanx_name(f, j), side * STRAND_LEVER * float(gripper.phalanx_width[j]))
    _add_pull(spec, group, gripper.tension_max)


def _add_pull(spec: mujoco.MjSpec, tendon: str, tension_max: float) -> None:
    actuator = spec.add_actuator(
        name=tendon, target=tendon, trntype=mujoco.mjtTrn.mjTRN_TENDON, ctrllimited=True, ctrlrange=[0.0, tension_max]
    )
    actuator.gear[0] = -1.0


def _exclude_overlaps(spec: mujoco.MjSpec, gripper: GripperDesign, finger: int) -> None:
    """Exclude collisions of phalanges that overlap in the straight finger; MuJoCo excludes parent and child."""
    ends = np.cumsum(gripper.phalanx_length)
    middle = ends - gripper.phalanx_length / 2
    reach = gripper.phalanx_width / 2 + [_capsule_half_length(gripper, j) for j in range(gripper.n_phalanx)]
    for j in range(gripper.n_phalanx):
        for k in range(j + 2, gripper.n_phalanx):
            if middle[j] + reach[j] > middle[k] - reach[k]:
                spec.add_exclude(bodyname1=phalanx_name(finger, j), bodyname2=phalanx_name(finger, k))
