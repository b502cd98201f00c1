"""Variants of a design: one field changed, or the requirements of the paper's rules changed.

What was measured on a print (section masses, their centre, joint stiffness) describes that print. It is left out where
the spiral or the sections change, and masses and stiffness follow from density and Young's modulus again.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

from spiraltrunk.checks import check_number, check_type
from spiraltrunk.design.rules import RANGES, design_from_rules
from spiraltrunk.design.schema import TABLES, find_key
from spiraltrunk.design.trunk import MOST_SECTIONS, TrunkDesign
from spiraltrunk.errors import UnknownName

MEASURED = ("joint.stiffness", "mass.sections", "mass.center_fraction")
"""Fields that hold what was measured on a print."""

_GEOMETRY = ("spiral.a", "spiral.b", "k", "delta_theta", "n_section", "theta_tip")
"""Fields with which the sections change."""


class Rules(NamedTuple):
    """Requirements of the paper's rules that a design meets; exactly so where its spiral is compact."""

    m: float
    """Largest object of the tip gripper over its base width [-]: 1 / (exp(pi b) - 1)."""
    delta_theta: float
    """Angle per section [rad]."""
    arm_radius: float
    """Radius of section 1, which is the arm's last link's [m]."""
    turns: float
    """Turns of the backbone's spiral from tip to base [-]."""


def read_rules(design: TrunkDesign) -> Rules:
    """Requirements that a design meets.

    Raises:
        DesignError: for what is no design.
    """
    check_type("design", design, TrunkDesign)
    return Rules(
        m=1.0 / math.expm1(math.pi * design.spiral.b),
        delta_theta=design.delta_theta,
        arm_radius=design.solid.radius,
        turns=design.n_section * design.delta_theta / (2 * math.pi),
    )


def list_fields() -> tuple[str, ...]:
    """Dotted names of all fields of a design that `change_field` changes."""
    names = []
    for table, keys in TABLES.items():
        names += [key.field if key.owner is TrunkDesign else f"{table}.{key.field}" for key in keys]
    return tuple(names)


def read_field(design: TrunkDesign, name: str) -> Any:
    """Value of a field by its dotted name, in SI; None where the part that it belongs to is absent."""
    part: Any = design
    for each in _split(name):
        part = None if part is None else getattr(part, each)
    return part


def change_field(design: TrunkDesign, name: str, value: Any) -> TrunkDesign:
    """The design with one field changed, and checked.

    Args:
        design: the design.
        name: dotted name of the field, such as ``cable.friction`` (`list_fields`).
        value: its value in SI.

    Raises:
        UnknownName: lists the fields.
        DesignError: for a value that the field does not allow, or a field of a gripper that the design has not.
    """
    check_type("design", design, TrunkDesign)
    path = _split(name)
    changed = (
        replace(design, **_drop_measured(design)) if name in _GEOMETRY and value != read_field(design, name) else design
    )
    if len(path) == 1:
        return replace(changed, **{name: value})
    part = getattr(changed, path[0])
    check_type(path[0], part, TABLES[path[0]][0].owner if path[0] != "spiral" else type(design.spiral))
    return replace(changed, **{path[0]: replace(part, **{path[1]: value})})


def change_rules(
    design: TrunkDesign, *, m: float | None = None, delta_theta: float | None = None, arm_radius: float | None = None,
    turns: float | None = None,
) -> TrunkDesign:  # fmt: skip
    """The design with other requirements of the paper's rules; those that are None stay as `read_rules` reads them.

    Spiral and sections are those of `design_from_rules`. The joint keeps its proportion to the base and the gripper to
    the tip. The angle per section moves to the nearest that divides the turns into whole sections; where only turns
    are given, they move to the nearest whole number of sections.

    Raises:
        DesignError: for a requirement out of its range, or requirements that together leave no tip.
    """
    kept = read_rules(design)
    b = design.spiral.b if m is None else None
    if delta_theta is None and turns is not None:
        turns = _fit_turns(turns, design.delta_theta)
    turns = kept.turns if turns is None else turns
    delta_theta = design.delta_theta if delta_theta is None else fit_delta_theta(delta_theta, turns)
    radius = kept.arm_radius if arm_radius is None else arm_radius
    ruled = design_from_rules(
        m=m, b=b, delta_theta=delta_theta, arm_radius=radius, turns=turns, name=design.name
    )  # fmt: skip
    joint, gripper = design.joint, design.gripper
    scale = ruled.solid.radius / design.solid.radius
    parts = _drop_measured(design)
    return replace(
        design, spiral=ruled.spiral, k=ruled.k, delta_theta=ruled.delta_theta, n_section=ruled.n_section,
        theta_tip=ruled.theta_tip, mass=parts["mass"],
        joint=replace(parts["joint"], radius=scale * joint.radius, length=scale * joint.length),
        gripper=None if gripper is None else gripper.scaled(ruled.tip_width / design.tip_width),
    )  # fmt: skip


def fit_delta_theta(delta_theta: float, turns: float) -> float:
    """The angle nearest to ``delta_theta`` [rad] that divides turns into whole sections, at most `MOST_SECTIONS`."""
    allowed = RANGES["delta_theta"]
    check_number("delta_theta", delta_theta, above=allowed.above, below=allowed.below)
    check_number("turns", turns, least=RANGES["turns"].least, most=RANGES["turns"].most)
    total = 2 * math.pi * turns
    fewest = math.floor(total / allowed.below * (1 + 1e-9)) + 1
    return total / min(max(round(total / delta_theta), fewest), MOST_SECTIONS)


def _fit_turns(turns: float, delta_theta: float) -> float:
    """The turns nearest to ``turns`` that are whole sections of an angle [rad], within their range."""
    allowed = RANGES["turns"]
    check_number("turns", turns, least=allowed.least, most=allowed.most)
    section = delta_theta / (2 * math.pi)
    fewest, most = math.ceil(allowed.least / section - 1e-9), math.floor(allowed.most / section + 1e-9)
    return min(max(round(turns / section), fewest), most) * section


def _drop_measured(design: TrunkDesign) -> dict[str, Any]:
    """Parts of the design without what was measured."""
    return {
        "joint": replace(design.joint, stiffness=None),
        "mass": replace(design.mass, sections=None, center_fraction=None),
    }


def _split(name: str) -> list[str]:
    if find_key(name) is None:
        raise UnknownName("field", name, list_fields())
    return name.split(".")
