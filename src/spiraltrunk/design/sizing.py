"""Compact spirals from sizes: tip, length, and base width or taper, as published for relatives of the paper's trunk."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

from spiraltrunk.checks import check_number
from spiraltrunk.design.parts import CableDesign
from spiraltrunk.design.rules import build_bare, build_compact
from spiraltrunk.design.spiral import Spiral
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError

_B_RANGE = (1e-4, 1.0)
_USUAL_TURN = math.radians(30.0)


def design_from_sizes(
    *,
    tip_width: float,
    length: float,
    base_width: float | None = None,
    taper: float | None = None,
    cable: CableDesign | None = None,
    name: str = "from-sizes",
) -> TrunkDesign:
    """The compact trunk of given tip width, length, and either base width or taper.

    The number of sections is the one whose angle per section is nearest to 30 deg; that angle is then solved for, so
    that all three sizes are met exactly.

    Args:
        tip_width: width of the face at the tip [m].
        length: length of the straight trunk [m].
        base_width: width of section 1 [m], or
        taper: full angle of the cone through the face edges [rad].
        cable: cables; three, 120 deg apart, by default.
        name: name of the design.

    Raises:
        DesignError: for a value out of range, for both or neither of base and taper, or sizes that no spiral meets.
    """
    check_number("tip_width", tip_width, above=0.0, below=10.0)
    check_number("length", length, above=0.0, below=100.0)
    if (base_width is None) == (taper is None):
        raise DesignError("base_width", got=base_width, allowed="either base_width or taper, not both")
    if base_width is not None:
        check_number("base_width", base_width, above=tip_width, below=10.0)
    if taper is not None:
        check_number("taper", taper, above=0.0, below=math.pi / 2)
    sizes = {"tip_width": tip_width, "length": length, "base_width": base_width, "taper": taper}
    try:
        b, turn, n_section = _solve(tip_width, length, base_width, taper)
    except ValueError:
        raise DesignError("sizes", got=sizes, allowed="tip, length and base or taper of one compact spiral") from None
    spiral = Spiral(a=length / build_bare(b, turn, n_section).length, b=b)
    return build_compact(spiral=spiral, delta_theta=turn, n_section=n_section, name=name, cable=cable)


def _solve(tip_width: float, length: float, base_width: float | None, taper: float | None) -> tuple[float, float, int]:
    """Growth, angle per section and number of sections with these sizes."""
    face = 0.0 if taper is None else tip_width / 2 + length * math.tan(taper / 2)

    def base_face(unit: TrunkDesign) -> float:
        return face if base_width is None else base_width / 2 * unit.face_half_width / unit.solid.radius

    fit = partial(_fit, tip_width, length, base_face)
    wanted = fit(_USUAL_TURN)[1]
    n_section = max(2, round(wanted))
    turn = _root(lambda angle: fit(angle)[1] - n_section, *_turns_between(wanted, n_section))
    return fit(turn)[0], turn, n_section


def _fit(
    tip_width: float, length: float, base_face: Callable[[TrunkDesign], float], turn: float
) -> tuple[float, float]:
    """Growth and (real) number of sections of the trunk with these sizes at an angle per section.

    The slope of the cone through the face edges is (base face - tip face) / length.
    """

    def miss(b: float) -> float:
        unit = build_bare(b, turn)
        return math.tan(unit.taper / 2) - (base_face(unit) - tip_width / 2) / length

    b = _root(miss, *_B_RANGE)
    return b, math.log(2 * base_face(build_bare(b, turn)) / tip_width) / (b * turn)


def _turns_between(wanted: float, n_section: int) -> tuple[float, float]:
    """Bracket of the angle with ``n_section`` sections, whose number decreases a little faster than 1 / angle.

    It is narrow because wide angles may have no solution.
    """
    reach = wanted / n_section
    return 0.95 * _USUAL_TURN * min(1.0, reach), 1.05 * _USUAL_TURN * max(1.0, reach)


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    from scipy.optimize import brentq

    return float(brentq(function, low, high, xtol=1e-15, rtol=1e-14))
