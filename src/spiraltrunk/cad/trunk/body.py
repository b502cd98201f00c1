"""The body of the trunk: sections on their elastic joints as one solid, in mm from the base."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, final

import numpy as np

from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.trunk.gripper import TipSeat, find_seat
from spiraltrunk.design.trunk import TrunkDesign

SPLIT = math.radians(28.0)
"""Angle between neighbouring holes where they part [rad] (ours): at less than 25 deg the wedge between counts as a
wall."""

RIM = 0.08
"""Width of the rims on both sides of a shell's seat over the section's radius [-] (ours)."""


@final
@dataclass(frozen=True, kw_only=True)
class Joint:
    """One printed elastic joint, in mm."""

    radius: float
    """Radius of the cylinder."""
    bore: float
    """Diameter of the channel through it, 0 for none."""
    length: float
    """Free length: the gap between the faces at the cylinder's surface."""


class ShellSeat(NamedTuple):
    """Seat of a section's shell, in mm."""

    inner: float
    """Inner radius."""
    outer: float
    """Radius of the section."""
    begin: float
    """Axial position of its proximal end."""
    end: float
    """Axial position of its distal end."""


@final
@dataclass(frozen=True, kw_only=True)
class Body:
    """Dimensions of the whole trunk, in mm."""

    starts: np.ndarray
    """Axial position of each section's proximal joint centre, shape (n_section,)."""
    profile: tuple[tuple[float, float], ...]
    """Outline (radius, z) from base to tip, without the points on the axis."""
    joints: tuple[Joint, ...]
    """Elastic joints, base to tip."""
    seats: tuple[ShellSeat | None, ...]
    """Seat of each section's shell; None where there is no room."""
    end: float
    """Axial position of the body's end."""
    tip: TipSeat | None
    """Joint with the gripper; None without one."""

    @property
    def n_hollow(self) -> int:
        """Number of hollow joints from the base on: the gripper's cables run through these."""
        return sum(joint.bore > 0 for joint in self.joints)

    def find_aside(self, options: MakeOptions) -> float:
        """Distance of the gripper's cables from the axis beside the solid joints: clear of the thickest."""
        widest = max((joint.radius for joint in self.joints[self.n_hollow :]), default=0.0)
        return widest + options.hole / 2 + options.clearance

    def find_legs(self, n_leg: int, options: MakeOptions) -> tuple[tuple[float, float], ...]:
        """Positions (dorsal, lateral) of the holes beside the solid joints: two of one leg each, or four, in mm."""
        aside = self.find_aside(options)
        if n_leg == 1:
            return ((0.0, aside), (0.0, -aside))
        x = aside / math.sqrt(2.0)
        return ((x, x), (-x, -x), (-x, x), (x, -x))

    def find_fork(self, n_joint: int, n_leg: int, options: MakeOptions) -> float:
        """Axial position at which the legs leave the axis: in the middle of the first section with a solid joint.

        Four holes leave it later, at `SPLIT` between neighbours, so that no thin wall is left between them.
        """
        begin = self.starts[self.n_hollow]
        end = self.starts[self.n_hollow + 1] if self.n_hollow < n_joint else self.end
        middle = 0.5 * (begin + end)
        if n_leg == 1:
            return float(middle)
        apart = math.sqrt(2.0) * self.find_aside(options)
        return float(max(middle, end - apart / (2 * math.tan(SPLIT / 2))))


def build_joint(design: TrunkDesign, i: int, options: MakeOptions) -> Joint:
    """Joint ``i`` (from 0) with the design's bending stiffness E I / L.

    The design's cylinder has I/L = pi r^4 / (4 l). The printed one is a tube of radius R and bore c with the length of
    the gap at its surface, L(R) = R (tan lean_proximal + tan lean_distal), so (R^4 - (c/2)^4) / L(R) = r^4 / l.
    Where the tube's wall would be thinner than two nozzles, the joint is solid.
    """
    slope = math.tan(design.solid.lean_proximal) + math.tan(design.solid.lean_distal)
    scale = 1e3 * float(design.scale[i])
    wanted = (design.joint.radius * scale) ** 4 / (design.joint.length * scale)
    full = (wanted * slope) ** (1 / 3)
    bore = options.pair_hole if design.gripper is not None else 0.0
    ring = full
    for _ in range(50):  # Fixed-point iteration; a contraction, as the bore's share of R^4 is small.
        ring = (wanted * slope * ring + (bore / 2) ** 4) ** 0.25
    if bore and ring - bore / 2 >= options.wall:
        return Joint(radius=ring, bore=bore, length=ring * slope)
    return Joint(radius=full, bore=0.0, length=full * slope)


def build_body(design: TrunkDesign, options: MakeOptions) -> Body:
    """Compute the dimensions of the whole trunk."""
    joints = tuple(build_joint(design, i, options) for i in range(design.n_joint))
    starts = 1e3 * np.concatenate([[0.0], np.cumsum(design.section_length)[:-1]])
    tip = None if design.gripper is None else find_seat(design, options)
    end = 1e3 * design.length - (0.0 if tip is None else tip.plate)
    seats = tuple(_find_shell(design, n, options, float(starts[n])) for n in range(design.n_section))
    profile: list[tuple[float, float]] = []
    for n in range(design.n_section):
        profile += _outline(design, n, joints, float(starts[n]), seats[n])
    profile = [(r, z) for r, z in profile if z <= end]
    if tip is not None:
        radius = 1e3 * float(design.section_radius[-1])
        profile.append((radius, end))
    return Body(starts=starts, profile=tuple(profile), joints=joints, seats=seats, end=end, tip=tip)


def _outline(
    design: TrunkDesign, n: int, joints: tuple[Joint, ...], start: float, seat: ShellSeat | None
) -> list[tuple[float, float]]:
    """Outline of section ``n`` between the surfaces of its two joints; at the trunk's ends it starts on the axis."""
    solid, scale = design.solid, 1e3 * float(design.scale[n])
    t1, t2 = math.tan(solid.lean_proximal), math.tan(solid.lean_distal)
    radius, length = solid.radius * scale, solid.length * scale
    near = joints[n - 1].radius if n > 0 else 0.0
    far = joints[n].radius if n < design.n_joint else 0.0
    points = [(near, start + near * t1), (radius, start + radius * t1)]
    if seat is not None:
        inner, _, begin, end = seat
        points += [(radius, begin), (inner, begin), (inner, end), (radius, end)]
    return [*points, (radius, start + length - radius * t2), (far, start + length - far * t2)]


def _find_shell(design: TrunkDesign, n: int, options: MakeOptions, start: float) -> ShellSeat | None:
    """Seat of a section's shell; None where it leaves too thin a wall at the holes, or rims, or carries the gripper."""
    solid, scale = design.solid, 1e3 * float(design.scale[n])
    radius = solid.radius * scale
    inner, rim = (1 - options.shell_depth) * radius, RIM * radius
    hole = 1e3 * float(design.hole_position[n, 0, 1]) + options.hole / 2
    begin, end = start + solid.rim_start * scale + rim, start + solid.rim_end * scale - rim
    is_last = n == design.n_section - 1 and design.gripper is not None
    if is_last or inner - hole < options.wall or rim < options.wall or end - begin < 4 * options.wall:
        return None
    return ShellSeat(inner, radius, begin, end)
