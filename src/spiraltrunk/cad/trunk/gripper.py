"""The gripper in one piece, plate with tenon and fingers with elastic joints and cable holes, and its seat in the tip.

A bayonet joins it to the trunk: a socket in the last section, a tenon with two lugs. Its plate replaces the end of that
section, so that the fingers are where the design has them. Each finger is a spiral of its own (b, angle per phalanx);
its phalanges are sections whose faces open by that angle. Strands pass each joint at `STRAND_LEVER` of the phalanx's
width, on the inner (ventral) side to close and on the outer (dorsal) side to open.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.geometry.csg import Common, Cut, Form, Revolved, Union, rod, shifted, tube, turned
from spiraltrunk.cad.geometry.part import Part, too_small
from spiraltrunk.design.gripper import STRAND_LEVER, GripperDesign
from spiraltrunk.design.materials import TPU
from spiraltrunk.design.trunk import TrunkDesign

STRAND = 0.6
"""Diameter of a strand's hole over that of a cable's [-]; a cable is unbraided into one strand a finger (ours)."""

LUG_ARC, ENTRY_ARC = math.radians(50.0), math.radians(60.0)
"""Angles of a lug and of its entry slot [rad]."""

TURN = math.pi / 2
"""Rotation from entry to lock [rad]."""


@final
@dataclass(frozen=True, kw_only=True)
class TipSeat:
    """Dimensions that socket and tenon share, in mm."""

    radius: float
    """Radius of the last section."""
    plate: float
    """Thickness of the gripper's plate."""
    knot: float
    """Depth of the groove under the plate for the knots of the trunk's cables."""
    ring: float
    """Radius of the circle of the cables."""
    inner: float
    """Radius of the socket's mouth."""
    outer: float
    """Radius of the undercut for the lugs."""
    lip: float
    """Thickness of the socket's lip."""
    lug: float
    """Height of a lug."""
    clearance: float
    """Clearance all round."""
    bore: float
    """Radius of the hole for the gripper's cables through the tenon."""

    @property
    def undercut(self) -> float:
        """Depth of the undercut's floor below the section's end."""
        return self.lip + self.lug + self.clearance

    @property
    def depth(self) -> float:
        """Depth of the socket, with room for the cables below the tenon."""
        return self.undercut + self.lip / 2


def find_seat(design: TrunkDesign, options: MakeOptions) -> TipSeat:
    """Size the joint to fit inside the circle of the last section's cable holes.

    Raises:
        DesignError: where the tip is too small for it.
    """
    ring = 1e3 * float(design.hole_position[-1, 0, 1])
    outer = ring - options.hole / 2 - options.wall
    inner = 0.7 * outer
    bore = inner - options.clearance - options.wall
    knot = 4 * options.cable
    seat = TipSeat(
        radius=1e3 * float(design.section_radius[-1]), plate=knot + options.hole + 2.2 * options.wall, knot=knot,
        ring=ring, inner=inner, outer=outer, lip=1.5 * options.wall, lug=1.5 * options.wall,
        clearance=options.clearance, bore=bore,
    )  # fmt: skip
    if seat.bore < options.hole / 2:
        hint = f"a wider tip, {options.remedies.nozzle} or {options.remedies.bare}"
        raise too_small("gripper: radius of the hole in its tenon", seat.bore, options.hole / 2, hint)
    solid, scale = design.solid, 1e3 * float(design.scale[-1])
    cone = seat.outer * math.tan(solid.lean_proximal)
    left = scale * solid.length - seat.plate - seat.depth - cone
    if left < options.wall:
        what = f"trunk, section {design.n_section}: floor under the gripper's socket"
        hint = f"a longer tip section, {options.remedies.nozzle} or {options.remedies.bare}"
        raise too_small(what, left, options.wall, hint)
    return seat


def add_socket(seat: TipSeat, end: float) -> list[Form]:
    """Cuts of the last section, which ends at ``end`` on the axis [mm]."""
    tools: list[Form] = [rod(seat.inner, (0, 0, end - seat.depth), (0, 0, end + 1.0))]
    floor, roof, top = end - seat.undercut, end - seat.lip, end + 1.0
    for k in range(2):
        entry = math.pi / 2 + math.pi * k - ENTRY_ARC / 2
        tools.append(tube(seat.inner - 0.5, seat.outer, floor, roof, start=entry, arc=ENTRY_ARC + TURN))
        tools.append(tube(seat.inner - 0.5, seat.outer, roof - 0.5, top, start=entry, arc=ENTRY_ARC))
    return tools


def _build_tenon(seat: TipSeat) -> list[Form]:
    """The tenon in its locked position, below z = 0; the first form reaches into the plate."""
    neck, bottom = seat.inner - seat.clearance, -(seat.lip + seat.lug)
    forms: list[Form] = [rod(neck, (0, 0, bottom), (0, 0, seat.knot / 2))]
    roof = -seat.lip - seat.clearance / 2
    for k in range(2):
        start = math.pi / 2 + math.pi * k + TURN - LUG_ARC / 2
        forms.append(tube(neck - 0.5, seat.outer - seat.clearance, bottom, roof, start=start, arc=LUG_ARC))
    return forms


@final
@dataclass(frozen=True, kw_only=True)
class Finger:
    """Dimensions of a finger in mm, base first; its axis along z, its outer side along x."""

    lengths: tuple[float, ...]
    """Lengths of the phalanges."""
    radii: tuple[float, ...]
    """Half their widths."""
    joints: tuple[float, ...]
    """Radii of the elastic joints."""
    slopes: tuple[float, float]
    """Tangents of the leans of proximal and distal faces; the angles add up to the angle per phalanx."""
    strand: float
    """Radius of a strand's hole."""
    bead: float
    """Radius of the bead round it."""

    def lever(self, j: int) -> float:
        """Distance of the strands from the axis in phalanx ``j``."""
        return 2 * STRAND_LEVER * self.radii[j]

    def reach(self, j: int) -> float:
        """Largest radius of phalanx ``j`` with its beads."""
        return max(self.radii[j], self.lever(j) + self.bead)


def build_finger(design: GripperDesign, modulus: float, options: MakeOptions) -> Finger:
    """Dimensions of a finger; its joints have stiffness E I / L = E pi r^4 / (4 r (t1 + t2)), E in Pa.

    Raises:
        DesignError: where a phalanx has no room between its faces, or fingers touch.
    """
    turn, k_p = design.delta_theta, design.k_p
    lean = math.pi / 2 - math.atan2(k_p * math.sin(turn), 1 - k_p * math.cos(turn))
    slopes = (math.tan(lean), math.tan(turn - lean))
    strand = STRAND * options.hole / 2
    finger = Finger(
        lengths=tuple(1e3 * float(value) for value in design.phalanx_length),
        radii=tuple(500 * float(value) for value in design.phalanx_width),
        joints=tuple(
            1e3 * (4 * float(value) * sum(slopes) / (math.pi * modulus)) ** (1 / 3) for value in design.joint_stiffness
        ),
        slopes=slopes, strand=strand, bead=strand + options.wall,
    )  # fmt: skip
    for j, length in enumerate(finger.lengths):
        rim = length - finger.reach(j) * sum(finger.slopes)
        if rim < 0.05 * length:
            hint = "a longer gripper.finger_length_mm or a narrower finger"
            raise too_small(f"gripper, phalanx {j + 1}: length of its outer surface", rim, 0.05 * length, hint)
    apart = 2e3 * design.mount_radius * math.sin(math.pi / design.n_finger)
    if apart < 2 * finger.reach(0):
        hint = "their width with cable beads; a larger gripper.mount_radius_mm"
        raise too_small("gripper: distance between fingers", apart, 2 * finger.reach(0), hint)
    return finger


def build_gripper(design: TrunkDesign, options: MakeOptions) -> tuple[Part, ...]:
    """The gripper, printed on its tenon; nothing where the design has none."""
    if design.gripper is None:
        return ()
    seat = find_seat(design, options)
    gripper = design.gripper
    finger = build_finger(gripper, design.joint.youngs_modulus, options)
    mount, turn = 1e3 * gripper.mount_radius, 2 * math.pi / gripper.n_finger
    top = seat.plate - finger.joints[0] * finger.slopes[1]
    widest = max(seat.radius, mount + finger.lever(0) + finger.bead)
    bodies, spoke = [tube(0.0, widest, 0.0, top), *_build_tenon(seat)], top - options.wall - options.hole / 2
    tools: list[Form] = [
        rod(seat.bore, (0, 0, -seat.lip - seat.lug - 1.0), (0, 0, spoke)),  # Through the tenon up to the spokes.
        tube(seat.ring - 2.5 * options.cable, seat.ring + 2.5 * options.cable, -1.0, seat.knot),  # For knots.
    ]
    straight, strands = _finger_forms(finger, top - seat.plate)
    for f in range(gripper.n_finger):
        bodies += [turned(shifted(form, (mount, 0, seat.plate)), "z", f * turn) for form in straight]
    holes = [shifted(form, (mount, 0, seat.plate)) for form in strands]
    for x in (mount - finger.lever(0), mount + finger.lever(0)):
        holes.append(rod(finger.strand, (x, 0, spoke), (x, 0, top + 1.0)))
    holes.append(rod(options.hole / 2, (0.0, 0, spoke), (widest + 1.0, 0, spoke)))  # Strands are threaded through it.
    tools += [turned(form, "z", f * turn) for form in holes for f in range(gripper.n_finger)]
    form = Cut(form=Union(forms=tuple(bodies)), tools=tuple(tools))
    deep = seat.lip + seat.lug
    at = 1e3 * design.length - seat.plate
    ends = [at + seat.plate + sum(finger.lengths[:j]) for j in range(gripper.n_phalanx)]
    part = Part(
        name="gripper", group="gripper", what=f"plate with turning tenon and {gripper.n_finger} fingers", material=TPU,
        form=shifted(form, (0, 0, deep)), at=(0.0, 0.0, at - deep),
        landmarks=((at - deep, "tenon"), (at, "plate"), *((z, f"finger joint {j + 1}") for j, z in enumerate(ends))),
        thinnest=f"{options.remedies.nozzle}, or a larger gripper.finger_width_mm or gripper.stiffness_nm_per_rad",
    )  # fmt: skip
    return (part,)


def strand_travel(design: GripperDesign) -> float:
    """Travel of a cable group from straight to the limit of all finger joints [m]."""
    return float((STRAND_LEVER * design.phalanx_width * design.delta_theta).sum())


def _finger_forms(finger: Finger, floor: float) -> tuple[list[Form], list[Form]]:
    """Bodies and strand holes of one finger, from its first joint's centre up; that joint starts at ``floor``."""
    forms: list[Form] = []
    holes: list[Form] = []
    t1, t2 = finger.slopes
    z = 0.0
    for j, length in enumerate(finger.lengths):
        reach, r, joint = finger.reach(j), finger.radii[j], finger.joints[j]
        lens = Revolved(
            profile=((0.0, z), (reach, z + reach * t1), (reach, z + length - reach * t2), (0.0, z + length))
        )
        bottom, top = (0, 0, z - 1.0), (0, 0, z + length + 1.0)
        sides = [
            rod(finger.bead, (side * finger.lever(j), 0, bottom[2]), (side * finger.lever(j), 0, top[2]))
            for side in (-1.0, 1.0)
        ]
        forms.append(Common(form=lens, other=Union(forms=(rod(r, bottom, top), *sides))))
        below = floor - 0.5 if j == 0 else z - joint * t2 - 0.2
        forms.append(rod(joint, (0, 0, below), (0, 0, z + joint * t1 + 0.2)))
        low, high = z + finger.lever(j) * t1 - 1.0, z + length - finger.lever(j) * t2 + 0.4
        holes += [rod(finger.strand, (x, 0, low), (x, 0, high)) for x in (-finger.lever(j), finger.lever(j))]
        z += length
    return forms, holes
