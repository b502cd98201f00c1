"""The trunk's body: sections fused over elastic joints, revolved as one polygon, drilled, split for the bed.

A section at distance rho from the axis reaches from rho tan(lean_proximal) to length - rho tan(lean_distal); between
two of them the faces open by the angle of a section, and what stands in the gap near the axis is the elastic joint.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import final

import numpy as np

from spiraltrunk.cad.forms import Cut, Form, Revolved, compute_bounds, polar, rod, shifted, turned
from spiraltrunk.cad.neck_screws import cut_neck_screws
from spiraltrunk.cad.options import MakeOptions
from spiraltrunk.cad.part import TPU, Part
from spiraltrunk.cad.pins import find_pins
from spiraltrunk.cad.tip import TipSeat, add_socket, find_seat
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, Words

RIM = 0.08
"""Width of the rims beside a shell's seat over the section's radius [-] (ours)."""

LEAST_PIECE = 8.0
"""Least height of a piece of the trunk [mm] (ours)."""


@final
@dataclass(frozen=True, kw_only=True)
class Joint:
    """One elastic joint as it is printed, in mm."""

    radius: float
    """Radius of the cylinder."""
    bore: float
    """Diameter of the channel through it, 0 where there is none."""
    length: float
    """Free length: the gap between the faces at the cylinder's surface."""

    @property
    def wall(self) -> float:
        """Thickness of what bends: the ring round the bore, or the whole cylinder."""
        return self.radius - self.bore / 2 if self.bore else 2 * self.radius


@final
@dataclass(frozen=True, kw_only=True)
class Body:
    """What every part of the trunk is cut from, in mm."""

    starts: np.ndarray
    """Position of each section's proximal joint centre on the axis, shape (n_section,)."""
    profile: tuple[tuple[float, float], ...]
    """Outline (radius, z) from base to tip, without the points on the axis."""
    joints: tuple[Joint, ...]
    """Elastic joints, base to tip."""
    seats: tuple[tuple[float, float, float, float] | None, ...]
    """Of each section's shell: inner and outer radius, begin and end on the axis; None where there is no room."""
    end: float
    """Where the body ends on the axis."""
    tip: TipSeat | None
    """Seat of the gripper."""

    @property
    def n_hollow(self) -> int:
        """How many joints, from the base, the gripper's cables run inside of."""
        return sum(joint.bore > 0 for joint in self.joints)

    def find_aside(self, options: MakeOptions) -> float:
        """Distance of the gripper's cables from the axis where they pass beside the joints: clear of the thickest."""
        widest = max((joint.radius for joint in self.joints[self.n_hollow :]), default=0.0)
        return widest + options.hole / 2 + options.clearance


def build_joint(design: TrunkDesign, i: int, options: MakeOptions) -> Joint:
    """Joint ``i`` (from 0), as stiff in bending as the design's EI/L though it is hollow and its length is the gap's.

    The design's cylinder has I/L = pi r^4 / (4 l). The printed one is a ring of radius R and bore c as long as the gap
    there, R (tan lean_proximal + tan lean_distal), so R solves (R^4 - (c/2)^4) / L(R) = r^4 / l. Where the ring would
    be thinner than two nozzles, there is no bore and the gripper's cables pass beside the joint.
    """
    slope = math.tan(design.solid.lean_proximal) + math.tan(design.solid.lean_distal)
    scale = 1e3 * float(design.scale[i])
    wanted = (design.joint.radius * scale) ** 4 / (design.joint.length * scale)
    full = (wanted * slope) ** (1 / 3)
    bore = options.pair_hole if design.gripper is not None else 0.0
    ring = full
    for _ in range(50):  # A contraction: the bore's share of R^4 is small.
        ring = (wanted * slope * ring + (bore / 2) ** 4) ** 0.25
    if bore and ring - bore / 2 >= options.wall:
        return Joint(radius=ring, bore=bore, length=ring * slope)
    return Joint(radius=full, bore=0.0, length=full * slope)


def build_body(design: TrunkDesign, options: MakeOptions) -> Body:
    """The outline of the whole trunk and all that is cut from it."""
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


def build_trunk(design: TrunkDesign, options: MakeOptions) -> tuple[Part, ...]:
    """The trunk's body in as few pieces as the bed allows, each standing on its end nearer to the base.

    Two pieces meet in a plane through a section, where nothing bends; pins keep them in line, glue and the pull of the
    cables keep them together. Of several pieces the first one stands on its cut end, as its other one is pointed.

    Raises:
        DesignError: where a section alone is larger than the bed.
    """
    body = build_body(design, options)
    tools = _holes(design, body, options)
    planes = plan_planes(design, body, options)
    pins = find_pins(design, body, planes, options)
    names = tuple(
        (float(body.starts[n]), f"section {n + 1}" if n == 0 else f"joint {n} and section {n + 1}")
        for n in range(design.n_section)
    )
    parts = []
    for k, (low, high) in enumerate(pairwise(planes)):
        form = _piece(body, tools, low, high)
        form = Cut(form=form.form, tools=(*form.tools, *(hole for pin in pins for hole in pin.holes(low, high))))
        is_turned = k == 0 and len(planes) > 2
        at = high if is_turned else (0.0 if k == 0 else low)
        lowered = shifted(form, (0.0, 0.0, -at))
        part = Part(
            name=f"trunk_{k + 1}", group="trunk", what=f"sections {_span(body, low, high)} over their elastic joints",
            material=TPU, form=turned(lowered, "x", math.pi) if is_turned else lowered, at=(0.0, 0.0, at),
            turn=math.pi if is_turned else 0.0, landmarks=names,
            thinnest="a finer --nozzle-mm, a wider tip (fewer turns or a larger base) or a larger joint.radius_mm",
        )  # fmt: skip
        parts.append(part)
    return tuple(parts)


def plan_planes(design: TrunkDesign, body: Body, options: MakeOptions) -> list[float]:
    """Heights between which the pieces lie [mm]: the base's end, every cut, the tip's end."""
    return [float(body.profile[0][1]), *_split(design, body, options), body.end]


def _outline(
    design: TrunkDesign, n: int, joints: tuple[Joint, ...], start: float, seat: tuple[float, float, float, float] | None
) -> list[tuple[float, float]]:
    """Outline of section ``n`` from its proximal joint's surface to its distal one's; the ends lie on the axis."""
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


def _find_shell(
    design: TrunkDesign, n: int, options: MakeOptions, start: float
) -> tuple[float, float, float, float] | None:
    """Seat of a section's shell; none where it would leave too little round the holes or between the rims.

    The last section carries the gripper and has none either.
    """
    solid, scale = design.solid, 1e3 * float(design.scale[n])
    radius = solid.radius * scale
    inner, rim = (1 - options.shell_depth) * radius, RIM * radius
    hole = 1e3 * float(design.hole_position[n, 0, 1]) + options.hole / 2
    begin, end = start + solid.rim_start * scale + rim, start + solid.rim_end * scale - rim
    is_last = n == design.n_section - 1 and design.gripper is not None
    if is_last or inner - hole < options.wall or rim < options.wall or end - begin < 4 * options.wall:
        return None
    return inner, radius, begin, end


def _holes(design: TrunkDesign, body: Body, options: MakeOptions) -> list[Form]:
    """Every cable hole, the gripper's channel, its socket, and the screw holes in section 1."""
    tools: list[Form] = []
    for n in range(design.n_section):
        ring, start = 1e3 * float(design.hole_position[n, 0, 1]), float(body.starts[n])
        stop = start + 1e3 * float(design.section_length[n])
        for angle in design.cable.angles:
            tools.append(rod(options.hole / 2, polar(ring, angle, start), polar(ring, angle, min(stop, body.end + 1))))
    tools += _channel(design, body, options)
    tools += cut_neck_screws(design)
    if body.tip is not None:
        tools += add_socket(body.tip, body.end)
    return tools


def _channel(design: TrunkDesign, body: Body, options: MakeOptions) -> list[Form]:
    """Way of the gripper's two cables: through the joints as far as these can be hollow, then beside them.

    Beside the joints it is two holes across the axis from each other, on the axis of sideward bending, so that bending
    in the plane of cable 1 neither pulls nor slackens them. Where they part, each slants from the axis to its side.
    """
    if body.tip is None:
        return []
    r, hollow = options.hole / 2, body.n_hollow
    fork = 0.5 * (body.starts[hollow] + (body.starts[hollow + 1] if hollow < design.n_joint else body.end))
    tools: list[Form] = [rod(options.pair_hole / 2, (0, 0, -1.0), (0, 0, float(fork)))]
    stop = float(body.end) + 1.0
    for side in (1.0, -1.0):
        for n in range(hollow, design.n_section):
            begin = float(fork) if n == hollow else float(body.starts[n])
            end = float(body.starts[n + 1]) if n < design.n_joint else stop
            aside = side * body.find_aside(options)
            low = (0.0, 0.0, begin - r) if n == hollow else (0.0, aside, begin)
            tools.append(rod(r, low, (0.0, aside, end)))
    return tools


def _split(design: TrunkDesign, body: Body, options: MakeOptions) -> list[float]:
    """Heights at which the trunk is cut, so that each piece stands on the bed."""
    x, y, tall = options.bed
    width = 2e3 * float(design.section_radius[0])
    if width > min(x, y):
        raise DesignError(
            "trunk", got=Words(f"{width:.1f} mm wide at section 1"),
            allowed=f"at most {min(x, y):g} mm, the bed: a larger --bed-mm or a narrower base",
        )  # fmt: skip
    bottom = float(body.profile[0][1])
    ranges = [_cut_range(design, body, n, options) for n in range(1, design.n_section - 1)]
    least = max(1, math.ceil((body.end - bottom) / tall - 1e-9))
    for pieces in range(least, design.n_section):
        wanted = [bottom + (body.end - bottom) * i / pieces for i in range(1, pieces)]
        near = [[min(max(z, low), high) for low, high in ranges] for z in wanted]
        cuts = [places[int(np.argmin(np.abs(np.array(places) - z)))] for places, z in zip(near, wanted, strict=True)]
        ends = [bottom, *cuts, body.end]
        if all(LEAST_PIECE < high - low <= tall for low, high in pairwise(ends)):
            return cuts
    raise DesignError(
        "trunk", got=Words(f"no set of sections that each fit {tall:g} mm"),
        allowed="a bed at least as high as two sections: a larger --bed-mm Z",
    )  # fmt: skip


def _cut_range(design: TrunkDesign, body: Body, n: int, options: MakeOptions) -> tuple[float, float]:
    """Between which heights section ``n`` may be cut: the middle half of its outside, within the shell's seat [mm]."""
    solid, scale, start = design.solid, 1e3 * float(design.scale[n]), float(body.starts[n])
    width, seat = solid.rim_end - solid.rim_start, body.seats[n]
    low, high = start + scale * (solid.rim_start + width / 4), start + scale * (solid.rim_end - width / 4)
    if seat is None:
        return low, high
    return max(low, seat[2] + options.wall), min(high, seat[3] - options.wall)


def _piece(body: Body, tools: list[Form], low: float, high: float) -> Cut:
    """What of the body lies between two planes."""
    inside = [(r, z) for r, z in body.profile if low < z < high]
    radius = [_find_radius(body, z) for z in (low, high)]
    first = [(0.0, low), *([(radius[0], low)] if low > body.profile[0][1] else [])]
    is_end = high >= body.end
    last = [(r, z) for r, z in body.profile if z == high] if is_end else [(radius[1], high)]
    profile = (*first, *inside, *last, *([(0.0, high)] if last and last[-1][0] > 0 else []))
    near = [tool for tool in tools if compute_bounds(tool)[1, 2] > low and compute_bounds(tool)[0, 2] < high]
    return Cut(form=Revolved(profile=_tidy(profile)), tools=tuple(near))


def _find_radius(body: Body, z: float) -> float:
    """Radius of the outline at a height where it crosses it once."""
    for (r0, z0), (r1, z1) in pairwise(body.profile):
        if z0 <= z <= z1 and z0 < z1:
            return r0 + (r1 - r0) * (z - z0) / (z1 - z0)
    return body.profile[-1][0]


def _tidy(profile: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    """The polygon without repeated corners."""
    return tuple(point for i, point in enumerate(profile) if i == 0 or math.dist(point, profile[i - 1]) > 1e-9)


def _span(body: Body, low: float, high: float) -> str:
    first = int(np.searchsorted(body.starts, low + 1e-6, side="right"))
    last = int(np.searchsorted(body.starts, high - 1e-6))
    return f"{max(1, first)} to {last}"
