"""Constants of the reference model, computed once per design."""

from __future__ import annotations

import math
import weakref
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple, final

import numpy as np

from spiraltrunk.checks import check_type
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.model.jit import compiler, hash_files
from spiraltrunk.model.kinematics.cables import hole_positions

ROUNDED_RATIO = 0.9196 / math.exp(-0.16 * math.pi / 6)
"""k_p by which the authors' gravity equations scale levers and stiffness, 0.9196, over the exact one [-]."""

ROUNDED_RADIUS = 28.87 / 28.871516330624754
"""R_hole at the base in the authors' code, 28.87 mm, over what the spiral gives [-]."""

ROUNDED_GAP = 13.74 / 13.743977971204414
"""Straight gap of joint 1 in the authors' shares, 13.74 mm, over what the spiral gives [-]."""

STAMP = hash_files(Path(__file__).parent.glob("*.py"))
"""Digest of the sources that the machine code on disc was compiled from."""

compiled = compiler(STAMP, owns_arrays=False)
"""Decorator of the compiled laws; those that return parts of their arrays may be called by compiled ones only."""

alone = compiler(STAMP, owns_arrays=False, is_alone=True)
"""Decorator of compiled laws whose loops must vectorise."""

_SAME = 1e-6
"""Distance of unit vectors up to which two directions are the same [-]."""


@final
class Table(NamedTuple):
    """Constants of one design inside the compiled laws; arrays have shape (n_joint,) where nothing else is said."""

    limit: float
    """Largest bend in any direction [rad]."""
    as_authors: bool
    """Whether overflowing cable is accounted for as in the authors' code."""
    total: float
    """All gaps of one cable in the straight trunk [m]."""
    weight: np.ndarray
    """Gravity moment at each joint per cos of the inclination, less that at the next joint [N m]."""
    stiffness: np.ndarray
    """Bending stiffness under gravity [N m/rad]."""
    diameter: np.ndarray
    """2 R_hole: length of a gap over sin(opening / 2) [m]."""
    straight: np.ndarray
    """Gap of the straight trunk [m]."""
    wide: np.ndarray
    """Dorsal gap at the ventral limit [m]."""
    portion: np.ndarray
    """Share of the cable per joint, sum 1 [-]."""
    below: np.ndarray
    """1 over the sum of the portions nearer to the base; 0 at joint 1 [-]."""
    section_length: np.ndarray
    """Lengths between joint centres, shape (n_section,) [m]."""
    beyond: np.ndarray
    """Holes beyond each joint from its centre, straight, shape (n_joint, n_cable, 3) [m]."""
    before: np.ndarray
    """Holes before each joint from its centre, shape (n_joint, n_cable, 3) [m]."""


@final
@dataclass(frozen=True, kw_only=True)
class Prepared:
    """One design ready for the compiled laws."""

    constants: np.ndarray
    """n_joint, n_cable and the fields of `Table` in one array, since each argument of a compiled call costs time."""
    layout: tuple[tuple[tuple[int, ...], int, int], ...]
    """Shape, start and end of points, rotations, angles, gaps and changes in the numbers of one result."""
    record: np.dtype[np.void]
    """One result: the same arrays, which faces touch, the status, and padding to 8 bytes."""
    n_joint: int
    workspaces: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)
    """Free workspaces of `build_workspace`, one for every thread that has solved single shapes."""
    stroke: float
    """Shortening of cable 1 from the straight trunk to full dorsal curl [m]."""
    ventral_stroke: float
    """Lengthening of cable 1 from the straight trunk to full ventral curl [m]."""
    is_mirrored: bool
    """Whether the ventral cables mirror each other."""
    is_papers: bool
    """Whether the cables are the paper's three, 120 deg apart."""

    def build_workspace(self) -> tuple[np.ndarray, np.ndarray]:
        """Input array, shape (1, 3), and workspace of `dispatch.solve` for a single shape."""
        workspace = np.full(4 + 12 * self.n_joint, math.nan)
        workspace[:2] = 0.0, 1.0
        return np.zeros((1, 3)), workspace


def read_table(constants: np.ndarray) -> Table:
    """The table in `Prepared.constants`, as views."""
    n, m = int(constants[0]), int(constants[1])
    c = constants[5:]
    end = 8 * n + 1
    half = end + 3 * n * m
    return Table(
        constants[2], constants[3] > 0.0, constants[4], c[0:n], c[n : 2 * n], c[2 * n : 3 * n], c[3 * n : 4 * n],
        c[4 * n : 5 * n], c[5 * n : 6 * n], c[6 * n : 7 * n], c[7 * n : end], c[end:half].reshape(n, m, 3),
        c[half : half + 3 * n * m].reshape(n, m, 3),
    )  # fmt: skip


unpack = compiled(read_table)
"""`read_table` for compiled laws."""


def rest_mass(design: TrunkDesign) -> np.ndarray:
    """Masses as the paper lumps them: the gripper counts as part of the last section, shape (n_section,) [kg].

    The authors add its 3.2 g to the 1.4 g of the last section and keep K_c for the sum.
    """
    mass = design.section_mass.copy()
    mass[-1] += 0.0 if design.gripper is None else design.gripper.mass
    return mass


def gravity_moment_term(design: TrunkDesign, ratio: float = 1.0) -> np.ndarray:
    """Gravity moment per cos of inclination, (m_n K_c + sum m_i) g a_n, to be summed from the tip, (n_joint,) [N m].

    Paper, equation of rest under gravity, without its second K_c; m_n and a_n belong to the section after joint n,
    a_n is its length. ``ratio`` scales that length by ratio^n [-].
    """
    mass = rest_mass(design)
    fraction = design.section_center / design.section_length
    beyond = mass.sum() - np.cumsum(mass)
    lever = design.section_length[1:] * ratio ** np.arange(1, design.n_section)
    return (mass[1:] * fraction[1:] + beyond[1:]) * GRAVITY * lever


def rest_stiffness(design: TrunkDesign, ratio: float = 1.0) -> np.ndarray:
    """E I / L of the joints with k_p times ``ratio``, or the design's own list as it is, shape (n_joint,) [N m/rad]."""
    if design.joint.stiffness is not None:
        return design.joint_stiffness
    return design.joint_stiffness * ratio ** (3.0 * np.arange(design.n_joint))


def portions(design: TrunkDesign, radius: np.ndarray, straight: np.ndarray) -> np.ndarray:
    """Shares of a pulled cable, sum 1, shape (n_joint,) [-].

    Paper, section "Bending": each joint turns by M_i L_i / (E I_i) and the share is the chord that its gap gains. The
    printed M_i = k_p^(-5/2) M_(i-1) is the ratio of the rotations; the moments go by k_p^(1/2). The largest rotation,
    at the tip, is the limit (authors' code: 0.0127 N m, which turns the tip joint by 29.995 deg).
    """
    turn = design.k_p ** (0.5 * np.arange(design.n_joint)) / design.joint_stiffness
    turn *= design.joint_limit / turn.max()
    gain = 2 * radius * np.sin((design.delta_theta + turn) / 2) - straight
    return gain / gain.sum()


def prepare(design: TrunkDesign, as_authors: bool = True) -> Prepared:
    """Constants of a design whose cable 1 is dorsal, cached as long as the design lives."""
    key = (id(design), as_authors is True)
    kept = _PREPARED.get(key) if isinstance(as_authors, bool) else None
    if kept is not None and kept[0]() is design:
        return kept[1]
    check_type("design", design, TrunkDesign)
    check_type("as_authors", as_authors, bool)
    prepared = _build(design, as_authors)
    _PREPARED[key] = (weakref.ref(design, lambda _: _PREPARED.pop(key, None)), prepared)
    return prepared


def check_ventral(design: TrunkDesign, prepared: Prepared) -> None:
    """Refuse a design whose ventral cables do not mirror each other; a `ModelError` says which angles were given."""
    if not prepared.is_mirrored:
        raise ModelError(
            f"cable.angles are {_degrees(design)}; allowed for ventral pulls: cables that mirror each other"
        )


def check_twist(design: TrunkDesign, prepared: Prepared) -> None:
    """Refuse a design without the paper's three cables, 120 deg apart; a `ModelError` says which angles were given."""
    if not prepared.is_papers:
        raise ModelError(f"cable.angles are {_degrees(design)}; allowed for twist: 0, 120 and 240 deg")


def _is_mirrored(design: TrunkDesign) -> bool:
    side = design.cable_direction[1:]
    distance = np.linalg.norm(side[:, None] - side * [1.0, 1.0, -1.0], axis=-1).min(axis=1)
    return bool(distance.max() < _SAME and side[:, 1].min() < 0)


def _is_papers(design: TrunkDesign) -> bool:
    angle = np.radians([0.0, 120.0, 240.0])
    expected = np.stack([0 * angle, np.cos(angle), np.sin(angle)], axis=-1)
    return design.n_cable == 3 and bool(np.abs(design.cable_direction - expected).max() < _SAME)


_PREPARED: dict[tuple[int, bool], tuple[weakref.ref[TrunkDesign], Prepared]] = {}
"""Constants of living designs, by identity, since hashing a design takes longer than a solution."""


def _degrees(design: TrunkDesign) -> str:
    return ", ".join(f"{math.degrees(angle):g}" for angle in design.cable.angles) + " deg"


def _build(design: TrunkDesign, as_authors: bool) -> Prepared:
    if np.abs(design.cable_direction[0] - [0.0, 1.0, 0.0]).max() > _SAME:
        raise ModelError(f"cable.angles are {_degrees(design)}; allowed: cable 1 dorsal, at 0 deg")
    n_joint, n_cable, table = design.n_joint, design.n_cable, _build_table(design, as_authors)
    shapes = {
        "points": (n_joint + 1, 3), "joint_rotation": (n_joint, 3, 3), "joint_angle": (n_joint,),
        "gap": (n_joint, n_cable), "cable_change": (n_cable,),
    }  # fmt: skip
    ends = np.cumsum([math.prod(shape) for shape in shapes.values()]).tolist()
    flags = ("is_shut", np.bool_, (n_joint,)), ("status", np.uint8), ("padding", np.uint8, (-(n_joint + 1) % 8,))
    return Prepared(
        constants=np.concatenate([np.ravel(part) for part in (n_joint, n_cable, *table)]).astype(float),
        layout=tuple(zip(shapes.values(), [0, *ends[:-1]], ends, strict=True)),
        record=np.dtype([*((name, float, shape) for name, shape in shapes.items()), *flags]),
        n_joint=n_joint,
        stroke=design.cable_stroke,
        ventral_stroke=float(table.wide.sum()) - design.cable_stroke,
        is_mirrored=_is_mirrored(design),
        is_papers=_is_papers(design),
    )


def _build_table(design: TrunkDesign, as_authors: bool) -> Table:
    ratio, part, gap = (ROUNDED_RATIO, ROUNDED_RADIUS, ROUNDED_GAP) if as_authors else (1.0, 1.0, 1.0)
    radius, straight = design.hole_to_joint * part, design.straight_gap * gap
    portion = portions(design, radius, straight)
    beyond, before = hole_positions(design)
    return Table(
        limit=design.joint_limit, as_authors=as_authors, total=design.cable_stroke,
        weight=gravity_moment_term(design, ratio), stiffness=rest_stiffness(design, ratio), diameter=2 * radius,
        straight=straight, wide=2 * design.hole_to_joint * math.sin(design.joint_limit), portion=portion,
        below=np.append(0.0, 1 / np.cumsum(portion)[:-1]), section_length=design.section_length, beyond=beyond,
        before=before,
    )  # fmt: skip
