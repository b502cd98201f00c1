"""The gripper in one piece: plate with tenon, and fingers of phalanges with elastic joints and cable holes.

Each finger is a spiral of its own (b, angle per phalanx); its phalanges are sections whose faces open by that angle.
Strands pass each joint at `STRAND_LEVER` of the phalanx's width, on the inner (ventral) side to close and on the outer
(dorsal) side to open.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.geometry.csg import Common, Cut, Form, Revolved, Union, rod, shifted, turned
from spiraltrunk.cad.geometry.part import TPU, Part
from spiraltrunk.cad.trunk.gripper_socket import build_tenon, find_seat
from spiraltrunk.design.gripper import STRAND_LEVER, GripperDesign
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, Unquoted

STRAND = 0.6
"""Diameter of a strand's hole over that of a cable's [-]; a cable is unbraided into one strand a finger (ours)."""


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
    _check_room(design, finger)
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
    disc = Revolved(profile=((0.0, 0.0), (widest, 0.0), (widest, top), (0.0, top)))
    bodies, spoke = [disc, *build_tenon(seat)], top - options.wall - options.hole / 2
    inner, outer = seat.ring - 2.5 * options.cable, seat.ring + 2.5 * options.cable
    tools: list[Form] = [
        rod(seat.bore, (0, 0, -seat.lip - seat.lug - 1.0), (0, 0, spoke)),  # Through the tenon up to the spokes.
        Revolved(profile=((inner, -1.0), (outer, -1.0), (outer, seat.knot), (inner, seat.knot))),  # For knots.
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
        thinnest="a finer --nozzle-mm, or a larger gripper.finger_width_mm or gripper.stiffness_nm_per_rad",
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


def _check_room(design: GripperDesign, finger: Finger) -> None:
    for j, length in enumerate(finger.lengths):
        rim = length - finger.reach(j) * sum(finger.slopes)
        if rim < 0.05 * length:
            raise DesignError(
                f"part gripper, phalanx {j + 1}: length of its outer surface", got=Unquoted(f"{rim:.2f} mm"),
                allowed=f"at least {0.05 * length:.2f} mm: a longer gripper.finger_length_mm or a narrower finger",
            )  # fmt: skip
    apart = 2e3 * design.mount_radius * math.sin(math.pi / design.n_finger)
    if apart < 2 * finger.reach(0):
        raise DesignError(
            "part gripper: distance between fingers", got=Unquoted(f"{apart:.2f} mm"),
            allowed=f"at least {2 * finger.reach(0):.2f} mm, with their cable beads: a larger gripper.mount_radius_mm",
        )  # fmt: skip
