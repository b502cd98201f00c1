"""From wished sizes to a compact spiral: for relatives of the paper's trunk, known by tip, length and base or taper.

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


class _Wish(NamedTuple):
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
    """The compact trunk with a given tip, length, and either base width or taper.

    It has the whole number of sections that puts the angle per section nearest to 30 deg; that angle then makes up
    for the rest, so that all three sizes are met.

    Args:
        tip_width: width of the face at the tip [m].
        length: length of the straight trunk [m].
        base_width: width of section 1 [m], or
        taper: full angle of the cone through the face edges [rad].
        cable: cables; three, 120 deg apart, by default.
        name: what to call it.

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
    wish = _Wish(tip_width, length, base_width, taper)
    wanted = _fit(wish, _USUAL_TURN).n_section
    n_section = max(2, round(wanted))
    turn = _root(lambda angle: _fit(wish, angle).n_section - n_section, _turns_between(wanted, n_section), wish)
    fit = _fit(wish, turn)
    spiral = Spiral(a=_base_radius(fit, turn, n_section), b=fit.b)
    return build_compact(spiral=spiral, delta_theta=turn, n_section=n_section, name=name, cable=cable)


def _fit(wish: _Wish, turn: float) -> _Fit:
    """Growth, base face and (real) number of sections that meet the wish at an angle per section."""

    def base_face(b: float) -> float:
        if wish.taper is not None:
            return wish.tip_width / 2 + wish.length * math.tan(wish.taper / 2)
        assert wish.base_width is not None  # One of the two is given: checked by the caller.
        return wish.base_width / (2 * math.sin(_face_angle(b, turn)))

    def miss(b: float) -> float:
        return _slope(b, turn) - (base_face(b) - wish.tip_width / 2) / wish.length

    b = _root(miss, _B_RANGE, wish)
    face = base_face(b)
    return _Fit(b, face, math.log(2 * face / wish.tip_width) / (b * turn))


def _turns_between(wanted: float, n_section: int) -> tuple[float, float]:
    """Angles around the one with ``n_section`` sections, whose number falls a little faster than 1 / angle.

    No wider, because a wide angle may have no spiral where the one sought has.
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


def _root(function, bounds: tuple[float, float], wish: _Wish) -> float:  # type: ignore[no-untyped-def]
    try:
        return float(brentq(function, *bounds, xtol=1e-15, rtol=1e-14))
    except ValueError:
        allowed = "tip, length and base or taper that one compact spiral can have"
        raise DesignError("sizes", got=wish._asdict(), allowed=allowed) from None
