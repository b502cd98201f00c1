"""Parameters of a trunk that the search varies, and the design that follows from them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import final

from spiraltrunk.checks import Range, check_range
from spiraltrunk.design.rules import design_from_rules
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError
from spiraltrunk.field_docs import explain_fields


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Parameter:
    """A number that the search varies."""

    name: str
    """Its name in tables and files."""
    least: float
    """Least value."""
    most: float
    """Largest value."""
    first: float
    """Value of the first candidate, that of the authors' robot."""
    step: int | None = None
    """Distance of whole numbers; None for any number."""
    what: str
    """What it is, with its unit."""


SPACE = (
    Parameter(
        name="m", least=1.1, most=2.0, first=1.53,
        what="largest object of the tip gripper over its base width, which gives the growth b [-]",
    ),
    Parameter(
        name="sections_per_turn", least=8, most=18, first=12, step=2,
        what="sections in a turn of the spiral: 360 deg over the angle of a section [-]",
    ),
    Parameter(
        name="joint_radius_factor", least=0.8, most=1.25, first=1.0,
        what="radius of the joints over that of the authors' proportions [-]; their stiffness grows with its 4th power",
    ),
    Parameter(
        name="hole_fraction", least=0.5, most=0.7, first=0.6,
        what="distance of the cable holes from the backbone over the half-width of a section's face [-]",
    ),
    Parameter(
        name="finger_scale", least=1.0, most=2.0, first=1.0,
        what="size of the tip's fingers over the authors' proportions [-]",
    ),
)  # fmt: skip
"""The search space (ranges ours: wide enough to leave the paper's trunk in every direction, and mostly printable)."""


def build_candidate(values: Mapping[str, float], *, friction: float = 0.0, name: str = "candidate") -> TrunkDesign:
    """The trunk of a point of the search space: the design rules with 1.5 turns and the arm radius of the paper.

    Args:
        values: a value of each parameter in `SPACE`.
        friction: coefficient between cables and holes [-].
        name: name of the design.

    Raises:
        DesignError: for a missing or unknown parameter, a value out of its range, and values that together give no
            trunk.
    """
    if set(values) != {each.name for each in SPACE}:
        raise DesignError("values", got=sorted(values), allowed=", ".join(each.name for each in SPACE))
    for each in SPACE:
        check_range(each.name, values[each.name], Range(least=each.least, most=each.most))
    plain = design_from_rules(m=values["m"], delta_theta=2 * math.pi / values["sections_per_turn"], name=name)
    assert plain.gripper is not None
    return replace(
        plain,
        joint=replace(plain.joint, radius=plain.joint.radius * values["joint_radius_factor"]),
        cable=replace(plain.cable, hole_fraction=values["hole_fraction"], friction=friction),
        gripper=plain.gripper.enlarged(values["finger_scale"]),
    )
