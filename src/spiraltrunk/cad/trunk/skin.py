"""Silicone shells with random horizontal cuts (wrinkles), and their two-part moulds.

A shell is a ring in the seat between a section's rims. Its mould is a core with a floor, and a ring with a ridge for
each cut, which stands on the step of the floor. Silicone is poured in from above; the cured shell is stretched off.
"""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.geometry.csg import Cut, Form, Revolved, Union, shifted, tube
from spiraltrunk.cad.geometry.part import Part
from spiraltrunk.cad.trunk.body import ShellSeat, build_body
from spiraltrunk.design.materials import SILICONE
from spiraltrunk.design.trunk import TrunkDesign

CUT_DEPTH = 0.25
"""Depth of a cut over the shell's thickness [-] (ours)."""

MOULD_WALL = 2.4
"""Thickness of a mould's walls and floor [mm] (ours)."""

STEP = 2.0
"""Height of the step that centres the mould's ring [mm] (ours)."""

_ARCS = (math.radians(40.0), math.radians(150.0))
"""Least and largest angle of a cut (ours)."""


def build_shells(design: TrunkDesign, options: MakeOptions) -> tuple[Part, ...]:
    """One shell for each section that has a seat."""
    return tuple(_build_shell(n, shell, options) for n, shell in _list_shells(design, options))


def build_moulds(design: TrunkDesign, options: MakeOptions) -> tuple[Part, ...]:
    """Core and ring of each shell's mould."""
    return tuple(part for n, shell in _list_shells(design, options) for part in _build_mould(n, shell, design, options))


def draw_wrinkles(n: int, inner: float, outer: float, height: float, options: MakeOptions) -> tuple[Revolved, ...]:
    """The cuts of shell ``n`` (from 0): ring sectors of triangular cross-section, open to the outside.

    Each is drawn at random, from the seed and ``n``, with its height in its own band, so that cuts do not overlap, and
    with begin and angle. There are fewer than asked for where ridges of two nozzles' width leave no room.
    """
    random = np.random.default_rng((options.seed, n))
    depth = CUT_DEPTH * (outer - inner)
    half = max(options.wall / 2, depth / 3)
    count = min(options.n_wrinkle, int((height - 2 * options.wall) / (2 * half + options.wall)))
    band = (height - 2 * options.wall) / max(1, count)
    cuts = []
    for i in range(count):
        middle = options.wall + band * i + half + (band - 2 * half - options.wall) * float(random.random())
        start, arc = float(random.uniform(0, 2 * math.pi)), float(random.uniform(*_ARCS))
        over = 0.2 * depth  # The triangle extends outside, so that no face coincides with the shell's.
        wide = half * (1 + over / depth)
        profile = ((outer - depth, middle), (outer + over, middle - wide), (outer + over, middle + wide))
        cuts.append(Revolved(profile=profile, start=start, arc=arc))
    return tuple(cuts)


def _list_shells(design: TrunkDesign, options: MakeOptions) -> list[tuple[int, ShellSeat]]:
    """Section (from 0) and dimensions of each shell: a little narrower than its seat, so that it grips."""
    grip, half = 1 - options.shell_grip, options.clearance / 2
    return [
        (n, ShellSeat(seat.inner * grip, seat.outer, seat.begin + half, seat.end - half))
        for n, seat in enumerate(build_body(design, options).seats)
        if seat is not None
    ]


def _build_shell(n: int, shell: ShellSeat, options: MakeOptions) -> Part:
    inner, outer, begin, end = shell
    ring = tube(inner, outer, 0.0, end - begin)
    form = Cut(form=ring, tools=draw_wrinkles(n, inner, outer, end - begin, options))
    return Part(
        name=f"shell_{n + 1:02d}", group="shells", what=f"wrinkled shell of section {n + 1}, cast", material=SILICONE,
        form=form, at=(0.0, 0.0, begin), checks_walls=False,
    )  # fmt: skip


def _build_mould(n: int, shell: ShellSeat, design: TrunkDesign, options: MakeOptions) -> tuple[Part, Part]:
    inner, outer, begin, end = shell
    height, wide = end - begin, outer + MOULD_WALL
    # The step has the shell's outline and centres the ring.
    core = Revolved(
        profile=(
            (0.0, -MOULD_WALL - STEP), (wide, -MOULD_WALL - STEP), (wide, -STEP), (outer - options.clearance, -STEP),
            (outer - options.clearance, 0.0), (inner, 0.0), (inner, height), (0.0, height),
        )
    )  # fmt: skip
    wall = tube(outer, wide, -STEP, height)
    ridges: tuple[Form, ...] = draw_wrinkles(n, inner, outer, height, options)
    at, material = (0.0, 0.0, begin), design.housing.filament
    common = f"of the mould of shell {n + 1}"
    return (
        Part(name=f"mould_core_{n + 1:02d}", group="moulds", what=f"core and floor {common}", material=material,
             form=shifted(core, (0, 0, MOULD_WALL + STEP)), at=at),
        Part(name=f"mould_ring_{n + 1:02d}", group="moulds", what=f"ring with ridges {common}", material=material,
             form=shifted(Union(forms=(wall, *ridges)), (0, 0, STEP)), at=at),
    )  # fmt: skip
