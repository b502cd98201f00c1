"""MuJoCo bodies of a design: housing, sections, elastic joints, cables and tip gripper.

Every length, mass and stiffness is read from the design; the constants here belong to the simulation alone. Axes are
the design's: x along the trunk, y dorsal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, final

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.checks import check_number, check_type
from spiraltrunk.design.gripper import GripperDesign
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.sim.robot.gripper import add_gripper, add_legs, phalanx_name
from spiraltrunk.sim.robot.materials import FRICTION, SOLIMP, SOLREF, TRUNK_COLORS

_QUAT_MOUNT_TRUNK_WXYZ = (0.5, -0.5, -0.5, -0.5)
"""Rotation of the trunk in the mount: x along the mount's z axis, dorsal along the mount's x axis."""

N_SIDE = 16
"""Sides of the prism that represents a round section."""

NEIGHBOURS = 4
"""Bodies of the chain up to this far apart do not collide; the joint limits represent the contact of their faces."""

FINGER_ROOM = 0.25
"""Least room between a section and a first phalanx that collide, in the straight trunk, over a finger's width [-]."""

LIMIT_LEVER = 0.075 * math.sin(math.radians(15.0)) * math.radians(30.0)
"""Lever of the tendon that limits a joint's angle, at the limit, times the limit [m rad] (ours): it sets how soft the
limit is. Its two sites are 75 mm from a joint that is limited to 30 deg. Sections whose faces have met are compressed
in proportion to their length. So a joint gives way by the same share of its limit, whatever that is, and a curled trunk
by the same angle, with many sections or few."""

ARMATURE = 1e-5
"""Least inertia that is added about each axis of a joint of 30 deg [kg m^2] (ours), for the integrator: cables that are
held by length swing fast against the joints of a curled trunk (`cable_swing.compute_cable_swing`). Fine sections have
more joints, and lighter ones, and each gets more: those of 20 deg chattered at their limits."""

SCALED_ARMATURE = 2e-4
"""Inertia that is added about each axis of a joint of 30 deg and scale 1 [kg m^2] (ours). It goes with the fifth power
of the scale, as the inertia of a section; the larger of it and `ARMATURE` counts."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class TrunkOptions:
    """Parameters of the simulated trunk that are not in the design."""

    hole_set_back: float = 0.08
    """Distance of the holes behind the face over its half-width [-]; at 0, cables chatter when a gap shuts."""
    cable_gain: float = 2e4
    """Stiffness of the winder's position control [N/m]."""
    stiffness_factor: float = 1.0
    """Joint stiffness over the design's [-]."""

    def __post_init__(self) -> None:
        check_number("trunk.hole_set_back", self.hole_set_back, least=0.0, below=1.0)
        check_number("trunk.cable_gain", self.cable_gain, above=0.0)
        check_number("trunk.stiffness_factor", self.stiffness_factor, above=0.0)


def trunk_spec(design: TrunkDesign, options: TrunkOptions | None = None) -> mujoco.MjSpec:
    """The trunk with its housing as a separate spec, mounted at the origin, along the world's +z.

    Raises:
        DesignError: for a value of another type.
    """
    options = TrunkOptions() if options is None else options
    check_type("design", design, TrunkDesign)
    check_type("options", options, TrunkOptions)
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    add_trunk(spec, spec.worldbody, design, options)
    return spec


def add_trunk(
    spec: mujoco.MjSpec,
    parent: mujoco.MjsBody,
    design: TrunkDesign,
    options: TrunkOptions,
    *,
    pos: ArrayLike = (0.0, 0.0, 0.0),
    quat_wxyz: ArrayLike = (1.0, 0.0, 0.0, 0.0),
) -> None:
    """Add housing and trunk to a body, along +z of the mount frame given by ``pos`` [m] and ``quat_wxyz``."""
    body = add_housing(parent, design, np.asarray(pos, float), np.asarray(quat_wxyz, float))
    for n in range(design.n_section):
        body = _add_section(spec, body, design, n, options)
    for i in range(design.n_joint):
        _add_limit(spec, design, i)
    for c in range(design.n_cable):
        _add_cable(spec, design, c, options)
    if design.gripper is not None:
        add_gripper(spec, body, design.gripper, float(design.section_length[-1]))
        add_legs(spec, design, [section_name(n) for n in range(design.n_section)])
        _exclude_fingers(spec, design, design.gripper)
    _exclude_neighbours(spec, design)


def trunk_quat_wxyz(mount_quat_wxyz: ArrayLike, roll: float = 0.0) -> np.ndarray:
    """Rotation of the trunk in the mount's parent, shape (4,) [-].

    The trunk's x axis is the mount's z axis; its dorsal side is the mount's x axis rotated about z by ``roll`` [rad].
    """
    turn, quat = np.array([math.cos(roll / 2), 0, 0, math.sin(roll / 2)]), np.zeros(4)
    mujoco.mju_mulQuat(quat, np.array(mount_quat_wxyz, float), turn)
    mujoco.mju_mulQuat(quat, quat.copy(), np.array(_QUAT_MOUNT_TRUNK_WXYZ))
    return quat


def section_name(n: int) -> str:
    """Body of section ``n``, counted from 0 at the base."""
    return f"section_{n + 1:02d}"


def cable_name(c: int) -> str:
    """Tendon and actuator of cable ``c``, counted from 0."""
    return f"cable_{c + 1}"


def hinge_names(i: int) -> tuple[str, str]:
    """The two hinges of joint ``i``, counted from 0: about y, about z."""
    return f"joint_{i + 1:02d}_y", f"joint_{i + 1:02d}_z"


def hinge_order(i: int) -> tuple[str, str]:
    """The hinges of joint ``i``, proximal first; the order alternates, so that bending about both does not twist."""
    about_y, about_z = hinge_names(i)
    return (about_z, about_y) if i % 2 == 0 else (about_y, about_z)


def tune_joint_limits(model: mujoco.MjModel, design: TrunkDesign) -> None:
    """Set the inverse inertia of the joint limits to its value at the limit.

    MuJoCo computes it for the straight trunk, where the limited distance is stationary and its Jacobian is 0. The limit
    would be infinitely stiff, and a free curl from a horizontal base would diverge.
    """
    data = mujoco.MjData(model)
    for i in range(design.n_joint):
        data.qpos[model.joint(hinge_names(i)[1]).qposadr[0]] = design.joint_limit
    mujoco.mj_forward(model, data)
    jacobian = np.zeros((model.ntendon, model.nv))
    mujoco.mju_sparse2dense(jacobian, data.ten_J, model.ten_J_rownnz, model.ten_J_rowadr, model.ten_J_colind)
    solved = np.zeros_like(jacobian)
    mujoco.mj_solveM(model, data, solved, jacobian)
    for i in range(design.n_joint):
        tendon = model.tendon(f"limit_{i + 1:02d}").id
        model.tendon_invweight0[tendon] = float(jacobian[tendon] @ solved[tendon])


def add_housing(parent: mujoco.MjsBody, design: TrunkDesign, pos: np.ndarray, quat_wxyz: np.ndarray) -> mujoco.MjsBody:
    """Add motor housing and neck, along +z of the mount frame; the site "trunk_base" is the end of the neck."""
    housing, radius = design.housing, float(design.section_radius[0])
    body = parent.add_body(name="housing", pos=pos, quat=trunk_quat_wxyz(quat_wxyz, design.arm.roll))
    neck = body.add_body(name="neck", pos=[housing.length, 0, 0])
    for part, mass, size, length, color in (
        (body, housing.total_mass, housing.radius, housing.length, [0.16, 0.18, 0.21, 1]),
        (neck, housing.total_neck_mass, radius, housing.neck_length, TRUNK_COLORS[1]),
    ):
        _set_inertia(part, mass, length / 2, (mass * size**2 / 2, mass * (3 * size**2 + length**2) / 12))
        part.gravcomp = 1.0  # The arm's controller compensates this load (Franka: set_load).
        part.add_geom(
            name=part.name, type=mujoco.mjtGeom.mjGEOM_CYLINDER, fromto=[0, 0, 0, length, 0, 0], size=[size, 0, 0],
            rgba=color, solref=SOLREF, solimp=SOLIMP,
        )  # fmt: skip
    neck.add_site(name="trunk_base", group=4, pos=[housing.neck_length, 0, 0])
    return neck


def _add_section(
    spec: mujoco.MjSpec, parent: mujoco.MjsBody, design: TrunkDesign, n: int, options: TrunkOptions
) -> mujoco.MjsBody:
    along = design.housing.neck_length if n == 0 else design.section_length[n - 1]
    body = parent.add_body(name=section_name(n), pos=[along, 0, 0])
    axial, transverse = design.section_inertia[n]
    _set_inertia(body, design.section_mass[n], design.section_center[n], (axial, transverse))
    if n > 0:
        _add_hinges(body, design, n - 1, options)
    _add_skin(spec, body, design, n)
    body.add_site(name=f"end_{n + 1:02d}", group=4, pos=[design.section_length[n], 0, 0])
    _add_holes(body, design, n, options)
    return body


def _add_skin(spec: mujoco.MjSpec, body: mujoco.MjsBody, design: TrunkDesign, n: int) -> None:
    """Add the section's mesh, which is drawn, and a capsule through its outer surface, which collides.

    The capsule's round ends bridge the open side of the gaps, as the silicone shell does. The last section collides as
    its mesh, as the palm of the gripper.
    """
    mesh = spec.add_mesh(name=section_name(n), uservert=_section_vertices(design, n).ravel())
    is_last = n == design.n_section - 1
    contact: dict[str, Any] = {"solref": SOLREF, "solimp": SOLIMP, "condim": 3, "friction": FRICTION}
    seen = contact if is_last else {"contype": 0, "conaffinity": 0, "group": 2}
    body.add_geom(
        name=section_name(n), type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh.name, rgba=TRUNK_COLORS[n % 2], **seen
    )
    if not is_last:
        solid, scale = design.solid, design.scale[n]
        body.add_geom(
            name=f"skin_{n + 1:02d}", type=mujoco.mjtGeom.mjGEOM_CAPSULE, group=3, size=[solid.radius * scale, 0, 0],
            fromto=[solid.rim_start * scale, 0, 0, solid.rim_end * scale, 0, 0], **contact,
        )  # fmt: skip


def _add_hinges(body: mujoco.MjsBody, design: TrunkDesign, i: int, options: TrunkOptions) -> None:
    stiffness = options.stiffness_factor * float(design.joint_stiffness[i])
    fineness = max(1.0, math.radians(30.0) / design.joint_limit)
    armature = max(ARMATURE, SCALED_ARMATURE * float(design.scale[i]) ** 5) * fineness**2
    for name in hinge_order(i):
        joint = body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, armature=armature)
        joint.axis = [0, 1, 0] if name.endswith("_y") else [0, 0, 1]
        joint.stiffness[0] = stiffness
        joint.damping[0] = stiffness * design.joint.damping_time


def _add_holes(body: mujoco.MjsBody, design: TrunkDesign, n: int, options: TrunkOptions) -> None:
    back = options.hole_set_back * design.face_half_width * design.scale[n]
    for c, direction in enumerate(design.cable_direction):
        for (axial, ring), name, shift in zip(design.hole_position[n], "pd", (back, -back), strict=True):
            body.add_site(name=f"hole_{n + 1:02d}_{c + 1}{name}", group=4, pos=[axial + shift, 0, 0] + ring * direction)


def _add_limit(spec: mujoco.MjSpec, design: TrunkDesign, i: int) -> None:
    """Limit the angle between the axes of two sections, in any direction, by the length of a tendon.

    Two sites on the axes, an arm a before and behind the joint, have the distance 2 a cos(angle / 2). Its derivative,
    a sin(angle / 2), is the tendon's lever: that of `LIMIT_LEVER` at the limit.
    """
    arm = LIMIT_LEVER / design.joint_limit / math.sin(design.joint_limit / 2)
    before = spec.body(section_name(i)).add_site(
        name=f"limit_{i + 1:02d}_a", group=4, pos=[design.section_length[i] - arm, 0, 0]
    )
    behind = spec.body(section_name(i + 1)).add_site(name=f"limit_{i + 1:02d}_b", group=4, pos=[arm, 0, 0])
    tendon = spec.add_tendon(
        name=f"limit_{i + 1:02d}", limited=True, range=[2 * arm * math.cos(design.joint_limit / 2), 2 * arm + 1.0],
        solref_limit=[0.003, 1], solimp_limit=[0.95, 0.999, 0.0005, 0.5, 2], group=4,
    )  # fmt: skip
    tendon.wrap_site(before.name)
    tendon.wrap_site(behind.name)


def _add_cable(spec: mujoco.MjSpec, design: TrunkDesign, c: int, options: TrunkOptions) -> None:
    tendon = spec.add_tendon(name=cable_name(c), width=0.0012, rgba=[0.95, 0.75, 0.2, 1])
    for n in range(design.n_section):
        for side in "pd":
            tendon.wrap_site(f"hole_{n + 1:02d}_{c + 1}{side}")
    actuator = spec.add_actuator(
        name=cable_name(c), target=cable_name(c), trntype=mujoco.mjtTrn.mjTRN_TENDON,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED, biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        forcelimited=True, forcerange=[-design.cable.tension_max, 0.0],
    )  # fmt: skip
    actuator.gainprm[0] = options.cable_gain
    actuator.biasprm[1] = -options.cable_gain


def _exclude_neighbours(spec: mujoco.MjSpec, design: TrunkDesign) -> None:
    chain = ["housing", "neck", *(section_name(n) for n in range(design.n_section))]
    for i, first in enumerate(chain):
        for second in chain[i + 1 : i + 1 + NEIGHBOURS]:
            spec.add_exclude(bodyname1=first, bodyname2=second)


def _exclude_fingers(spec: mujoco.MjSpec, design: TrunkDesign, gripper: GripperDesign) -> None:
    """Exclude collisions of the fingers' first phalanges with sections whose capsules reach them in the straight trunk.

    Of a short section near the tip the round end of the capsule reaches beyond the last section; the section does not.
    """
    solid, first = design.solid, float(gripper.phalanx_width[0]) / 2
    for n in range(design.n_section - 1):
        ahead = float(design.section_length[n:].sum()) + first - solid.rim_end * float(design.scale[n])
        gap = math.hypot(max(0.0, ahead), gripper.mount_radius) - solid.radius * float(design.scale[n]) - first
        if gap < FINGER_ROOM * gripper.finger_width:
            for f in range(gripper.n_finger):
                spec.add_exclude(bodyname1=section_name(n), bodyname2=phalanx_name(f, 0))


def _section_vertices(design: TrunkDesign, n: int) -> np.ndarray:
    """Vertices of the prism of section ``n``: two rims of the circle's area, and the two joint centres."""
    solid = design.solid
    turn = 2 * math.pi / N_SIDE
    angle = turn * np.arange(N_SIDE)
    equal_area = math.sqrt(turn / math.sin(turn))
    ring = solid.radius * equal_area * np.stack([0 * angle, np.cos(angle), np.sin(angle)], axis=-1)
    along = np.array([1.0, 0.0, 0.0])
    corners = np.vstack([ring + solid.rim_start * along, ring + solid.rim_end * along, 0 * along, solid.length * along])
    return design.scale[n] * corners


def _set_inertia(body: mujoco.MjsBody, mass: float, center: float, moments: tuple[float, float]) -> None:
    body.explicitinertial = True
    body.mass = mass
    body.ipos = [center, 0, 0]
    body.inertia = [moments[0], moments[1], moments[1]]
