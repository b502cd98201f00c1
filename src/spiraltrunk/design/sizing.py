"""Compact spirals from sizes: tip, length, and base width or taper, as published for relatives of the paper's trunk.

For a contour of radius 1 at the base: half-width of the base face h = (1 - exp(-2 pi b)) / 2, backbone k, section
chord k c with c^2 = 1 + k_p^2 - 2 k_p cos(delta_theta), slope of the cone through the face edges h (1 - k_p) / (k c).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from scipy.optimize import brentq

from spiraltrunk.checks import check_number
from spiraltrunk.design.parts import CableDesign
from spiraltrunk.design.rules import build_compact, compactness
from spiraltrunk.design.spiral import Spiral
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError

_B_RANGE = (1e-4, 1.0)
_USUAL_TURN = math.radians(30.0)


class _Sizes(NamedTuple):
    tip_width: float
    length: float
    base_width: float | None
    taper: float | None


class _Fit(NamedTuple):
    b: float
    face_half_width: float
    n_section: float


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
    sizes = _Sizes(tip_width, length, base_width, taper)
    wanted = _fit(sizes, _USUAL_TURN).n_section
    n_section = max(2, round(wanted))
    turn = _root(lambda angle: _fit(sizes, angle).n_section - n_section, _turns_between(wanted, n_section), sizes)
    fit = _fit(sizes, turn)
    spiral = Spiral(a=_base_radius(fit, turn, n_section), b=fit.b)
    return build_compact(spiral=spiral, delta_theta=turn, n_section=n_section, name=name, cable=cable)


def _fit(sizes: _Sizes, turn: float) -> _Fit:
    """Growth, base face and (real) number of sections with these sizes at an angle per section."""

    def base_face(b: float) -> float:
        if sizes.taper is not None:
            return sizes.tip_width / 2 + sizes.length * math.tan(sizes.taper / 2)
        assert sizes.base_width is not None  # One of the two is given: checked by the caller.
        return sizes.base_width / (2 * math.sin(_face_angle(b, turn)))

    def miss(b: float) -> float:
        return _slope(b, turn) - (base_face(b) - sizes.tip_width / 2) / sizes.length

    b = _root(miss, _B_RANGE, sizes)
    face = base_face(b)
    return _Fit(b, face, math.log(2 * face / sizes.tip_width) / (b * turn))


def _turns_between(wanted: float, n_section: int) -> tuple[float, float]:
    """Bracket of the angle with ``n_section`` sections, whose number decreases a little faster than 1 / angle.

    It is narrow because wide angles may have no solution.
    """
    reach = wanted / n_section
    return 0.95 * _USUAL_TURN * min(1.0, reach), 1.05 * _USUAL_TURN * max(1.0, reach)


def _slope(b: float, turn: float) -> float:
    k_p = math.exp(-b * turn)
    chord = math.sqrt(1 + k_p**2 - 2 * k_p * math.cos(turn))
    half = (1 - math.exp(-2 * math.pi * b)) / 2
    return half * (1 - k_p) / (compactness(b) * chord)


def _face_angle(b: float, turn: float) -> float:
    k_p = math.exp(-b * turn)
    return math.atan2(k_p * math.sin(turn), 1 - k_p * math.cos(turn))


def _base_radius(fit: _Fit, turn: float, n_section: int) -> float:
    """Scale a of the spiral whose base face, at theta = pi / 2 + n turn, has the fitted half-width."""
    half = (1 - math.exp(-2 * math.pi * fit.b)) / 2
    return fit.face_half_width / half * math.exp(-fit.b * (math.pi / 2 + n_section * turn))


def _root(function, bounds: tuple[float, float], sizes: _Sizes) -> float:  # type: ignore[no-untyped-def]
    try:
        return float(brentq(function, *bounds, xtol=1e-15, rtol=1e-14))
    except ValueError:
        allowed = "tip, length and base or taper of one compact spiral"
        raise DesignError("sizes", got=sizes._asdict(), allowed=allowed) from None
