"""The trunk's body: sections and elastic joints as one revolved polygon, drilled, and split to fit the bed.

At the radius rho a section reaches from rho tan(lean_proximal) to length - rho tan(lean_distal). The gap between two
sections opens by the angle per section; the elastic joint fills it near the axis.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.geometry.csg import Cut, Form, Revolved, compute_bounds, polar, rod, shifted, turned
from spiraltrunk.cad.geometry.part import Part
from spiraltrunk.cad.trunk.body import Body, build_body
from spiraltrunk.cad.trunk.gripper import add_socket
from spiraltrunk.cad.trunk.neck_screws import cut_neck_screws
from spiraltrunk.cad.trunk.pins import find_pins
from spiraltrunk.design.materials import TPU
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, Unquoted

LEAST_PIECE = 8.0
"""Least height of a piece of the trunk [mm] (ours)."""


def build_trunk(design: TrunkDesign, options: MakeOptions) -> tuple[Part, ...]:
    """The trunk's body in as few pieces as the bed allows, each printed on its proximal end.

    Pieces meet in planes through sections, where nothing bends. Pins align them; glue and the cables' tension hold them
    together. Of several pieces the first is printed on its distal, flat end.

    Raises:
        DesignError: where one section is larger than the bed.
    """
    body = build_body(design, options)
    tools = _holes(design, body, options)
    planes = plan_planes(design, body, options)
    pins = find_pins(design, body, planes, options)
    names = tuple(
        (float(body.starts[n]), f"section {n + 1}" if n == 0 else f"joint {n} and section {n + 1}")
        for n in range(design.n_section)
    )
    parts, finer = [], options.remedies.nozzle
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
            thinnest=f"{finer}, a wider tip (fewer turns or a larger base) or a larger joint.radius_mm",
        )  # fmt: skip
        parts.append(part)
    return tuple(parts)


def plan_planes(design: TrunkDesign, body: Body, options: MakeOptions) -> list[float]:
    """Heights of the pieces' ends [mm]: base, cuts, tip."""
    return [float(body.profile[0][1]), *_split(design, body, options), body.end]


def _holes(design: TrunkDesign, body: Body, options: MakeOptions) -> list[Form]:
    """Cuts of the trunk: cable holes, the gripper's channel and socket, screw holes in section 1."""
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
    """Channel of the gripper's two cables: one hole through the hollow joints, then holes beside the solid ones.

    Cables of one leg have a hole each, on opposite sides of the axis, on the neutral axis of bending in the plane of
    cable 1, which therefore does not change the cables' lengths. Cables of two legs have two holes each, opposite each
    other, at a right angle to those of the other cable. At the fork each hole slants from the axis to its side.
    """
    if body.tip is None or design.gripper is None:
        return []
    r, hollow = options.hole / 2, body.n_hollow
    fork = body.find_fork(design.n_joint, design.gripper.n_leg, options)
    tools: list[Form] = [rod(options.pair_hole / 2, (0, 0, -1.0), (0, 0, fork))]
    stop = float(body.end) + 1.0
    for x, y in body.find_legs(design.gripper.n_leg, options):
        for n in range(hollow, design.n_section):
            begin = fork if n == hollow else float(body.starts[n])
            end = float(body.starts[n + 1]) if n < design.n_joint else stop
            low = (0.0, 0.0, begin - r) if n == hollow else (x, y, begin)
            tools.append(rod(r, low, (x, y, end)))
    return tools


def _split(design: TrunkDesign, body: Body, options: MakeOptions) -> list[float]:
    """Heights of the cuts, so that each piece fits the bed."""
    x, y, tall = options.bed
    width = 2e3 * float(design.section_radius[0])
    if width > min(x, y):
        raise DesignError(
            "trunk", got=Unquoted(f"{width:.1f} mm wide at section 1"),
            allowed=f"at most {min(x, y):g} mm, the bed: {options.remedies.bed} or a narrower base",
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
        "trunk", got=Unquoted(f"no set of sections that each fit {tall:g} mm"),
        allowed=f"a bed at least as high as two sections: {options.remedies.tall_bed}",
    )  # fmt: skip


def _cut_range(design: TrunkDesign, body: Body, n: int, options: MakeOptions) -> tuple[float, float]:
    """Range of heights for a cut of section ``n``: the middle half of its rim, within the shell's seat [mm]."""
    solid, scale, start = design.solid, 1e3 * float(design.scale[n]), float(body.starts[n])
    width, seat = solid.rim_end - solid.rim_start, body.seats[n]
    low, high = start + scale * (solid.rim_start + width / 4), start + scale * (solid.rim_end - width / 4)
    if seat is None:
        return low, high
    return max(low, seat.begin + options.wall), min(high, seat.end - options.wall)


def _piece(body: Body, tools: list[Form], low: float, high: float) -> Cut:
    """The body between two planes."""
    inside = [(r, z) for r, z in body.profile if low < z < high]
    radius = [float(np.interp(z, [z for _, z in body.profile], [r for r, _ in body.profile])) for z in (low, high)]
    first = [(0.0, low), *([(radius[0], low)] if low > body.profile[0][1] else [])]
    is_end = high >= body.end
    last = [(r, z) for r, z in body.profile if z == high] if is_end else [(radius[1], high)]
    profile = (*first, *inside, *last, *([(0.0, high)] if last and last[-1][0] > 0 else []))
    corners = [p for i, p in enumerate(profile) if i == 0 or math.dist(p, profile[i - 1]) > 1e-9]  # None twice.
    near = [tool for tool in tools if compute_bounds(tool)[1, 2] > low and compute_bounds(tool)[0, 2] < high]
    return Cut(form=Revolved(profile=tuple(corners)), tools=tuple(near))


def _span(body: Body, low: float, high: float) -> str:
    first = int(np.searchsorted(body.starts, low + 1e-6, side="right"))
    last = int(np.searchsorted(body.starts, high - 1e-6))
    return f"{max(1, first)} to {last}"
