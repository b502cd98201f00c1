"""The paper's reference model beside an equilibrium: its shape for the same pulls, where it has one.

The reference model knows rest, cable 1 pulled alone, the ventral cables pulled equally, and cable 1 pulled before
cable 2 (`reference`). Which of them an equilibrium is, its tensions tell: slack cables are relaxed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign, ventral_cables
from spiraltrunk.errors import ModelError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.model import reference
from spiraltrunk.model.kinematics.cables import PULL_MARGIN
from spiraltrunk.model.kinematics.shape import Shape

_SLACK = 1e-6
"""Tension below which a cable counts as slack [N]."""

_EQUAL = 5e-5
"""Difference of two pulls below which they count as equal [m]: half of a slider's step."""

_LEVER = 1e-6
"""Difference of two cables' levers over their radius below which they count as equal [-]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class PaperShape:
    """What the reference model says of an equilibrium's pulls."""

    shape: Shape | None
    """Its shape, None where it has none."""
    pull: str
    """The pull in words, or the reason why there is no shape."""


def compute_paper_shape(
    design: TrunkDesign, shape: Shape, rest: Shape, theta_0: float, roll: float = 0.0
) -> PaperShape:
    """Shape of the reference model after the same pulls from rest as those of an equilibrium.

    Args:
        design: the trunk.
        shape: an equilibrium.
        rest: the equilibrium with slack cables at the same base, from which pulls are counted.
        theta_0: angle of the base axis below the horizontal [rad].
        roll: rotation about the base axis [rad]; the reference model has none.
    """
    if abs(roll) > 1e-9:
        return PaperShape(shape=None, pull="the paper's model has no roll")
    tension = np.zeros(design.n_cable) if shape.forces is None else shape.forces.cable_tension
    taut = tuple(int(cable) for cable in np.flatnonzero(tension > _SLACK))
    moved = shape.cable_change - rest.cable_change
    try:
        return _compute(design, taut, moved, theta_0)
    except ModelError as error:
        return PaperShape(shape=None, pull=str(error))


def _compute(design: TrunkDesign, taut: tuple[int, ...], moved: np.ndarray, theta_0: float) -> PaperShape:
    """The paper's pull by the taut cables and their change from rest [m]."""
    stroke, most = design.cable_stroke, PULL_MARGIN * design.cable_stroke
    if taut == ():
        return PaperShape(shape=reference.rest(design, theta_0), pull="rest")
    if taut == (0,) and 0.0 <= moved[0] <= most:
        pull = min(float(moved[0]), stroke)
        return PaperShape(shape=reference.bend_dorsal(design, pull, theta_0), pull=f"cable 1 in by {_mm(pull)}")
    if _are_ventral(design, taut) and np.ptp(moved[list(taut)]) < 2 * _EQUAL and moved[0] <= 0.0:
        given = -float(moved[0])
        shape = reference.bend_ventral(design, given, theta_0)
        return PaperShape(shape=shape, pull=f"ventral cables in until cable 1 is {_mm(given)} longer")
    if taut == (0, 1) and 0.0 <= moved[0] <= most:
        return _twist(design, min(float(moved[0]), stroke), float(moved[1]), theta_0)
    known = "rest, cable 1 alone, the ventral cables equally, cable 1 and then cable 2"
    return PaperShape(shape=None, pull=f"the paper's model has no shape for these pulls; it has: {known}")


def _are_ventral(design: TrunkDesign, taut: tuple[int, ...]) -> bool:
    """Whether the taut cables are the ventral ones, or those of them with the shortest lever.

    Pulled in equally, the others are slack: they come in farther as the trunk bends.
    """
    ventral = np.flatnonzero(ventral_cables(design))
    lever = -design.cable_direction[ventral, 1]
    shortest = ventral[lever < lever.min(initial=np.inf) + _LEVER]
    return taut in (tuple(ventral.tolist()), tuple(shortest.tolist()))


def _twist(design: TrunkDesign, first: float, moved: float, theta_0: float) -> PaperShape:
    """Cable 1 pulled in from rest, then cable 2 until its change from rest is that of the equilibrium."""
    at_rest = float(reference.rest(design, theta_0).cable_change[1])
    bent = float(reference.bend_dorsal(design, first, theta_0).cable_change[1])
    second = moved - (bent - at_rest)
    if second < 0.0:
        return PaperShape(shape=None, pull="in the paper's model cable 2 would be slack here")
    shape = reference.twist(design, first, second, theta_0)
    return PaperShape(shape=shape, pull=f"cable 1 in by {_mm(first)}, then cable 2 by {_mm(second)}")


def _mm(length: float) -> str:
    return f"{1e3 * length:.1f} mm"
