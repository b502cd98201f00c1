"""Checks of design values: each refuses a wrong type, a non-finite number and a value outside its range."""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal
from typing import NamedTuple, final

import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.errors import DesignError, ModelError, Words, tell


@final
class Range(NamedTuple):
    """Which finite numbers are allowed; as a text it says so."""

    above: float = -math.inf
    """Every number is larger than this."""
    least: float = -math.inf
    """No number is smaller than this."""
    below: float = math.inf
    """Every number is smaller than this."""
    most: float = math.inf
    """No number is larger than this."""
    unit: Decimal = Decimal(1)
    """What the numbers are told in, over the unit that the bounds are in [-]."""

    def holds(self, number: float) -> bool:
        """Whether the number, in the unit of the bounds, is finite and in the range."""
        return math.isfinite(number) and self.above < number < self.below and self.least <= number <= self.most

    def told_in(self, unit: Decimal) -> Range:
        """The same range, told in another unit."""
        return self._replace(unit=unit)

    def __str__(self) -> str:
        words = [
            f"{word} {self._tell(bound, rounding)}"
            for word, bound, rounding in (
                ("above", self.above, ROUND_CEILING),
                ("at least", self.least, ROUND_CEILING),
                ("below", self.below, ROUND_FLOOR),
                ("at most", self.most, ROUND_FLOOR),
            )
            if math.isfinite(bound)
        ]
        return ", ".join(["a finite number", *words])

    def _tell(self, bound: float, rounding: str) -> str:
        """The bound in six digits, rounded inwards, so that what is told is true."""
        exact = Context(prec=14, rounding=ROUND_HALF_EVEN).divide(Decimal(repr(float(bound))), self.unit)
        return f"{float(Context(prec=6, rounding=rounding).plus(exact)):g}"


def check_number(
    name: str,
    value: object,
    *,
    above: float = -math.inf,
    least: float = -math.inf,
    below: float = math.inf,
    most: float = math.inf,
) -> None:
    """Refuse anything but a finite number in (``above``, ``below``) and in [``least``, ``most``].

    Raises:
        DesignError: with the name, the value and the `Range`.
    """
    check_range(name, value, Range(above=above, least=least, below=below, most=most))


def check_range(name: str, value: object, allowed: Range) -> None:
    """Refuse anything but a number in the range.

    Raises:
        DesignError: with the name, the value and the range.
    """
    if not allowed.holds(_to_float(value)):
        raise DesignError(name, got=value, allowed=allowed)


def check_tip(width: float, least: float) -> None:
    """Refuse a tip that is thinner than ``least`` [m]: nobody makes it, and what follows from it is no number.

    Raises:
        DesignError: with both widths, and what makes the tip wider.
    """
    if not width >= least:
        allowed = f"at least {1e3 * least:g} mm: fewer turns or sections, a smaller b (larger m) or a wider base"
        raise DesignError("width of the tip", got=Words(f"{1e3 * width:.3g} mm"), allowed=allowed)


def check_count(name: str, value: object, *, least: int, most: int) -> None:
    """Refuse anything but a whole number from ``least`` to ``most``.

    Raises:
        DesignError: with the name, the value and the range.
    """
    is_count = isinstance(value, int) and not isinstance(value, bool)
    if not (is_count and least <= value <= most):  # type: ignore[operator]
        raise DesignError(name, got=value, allowed=f"a whole number from {least} to {most}")


def check_numbers(name: str, values: object, *, count: int | None = None, above: float = -math.inf) -> None:
    """Refuse anything but a tuple of finite numbers, ``count`` of them where a count is given.

    Raises:
        DesignError: with the name, the value and what is allowed.
    """
    if not isinstance(values, tuple):
        raise DesignError(name, got=values, allowed="a tuple of numbers")
    if count is not None and len(values) != count:
        raise DesignError(name, got=Words(f"{len(values)} numbers"), allowed=f"{count} numbers")
    for i, value in enumerate(values):
        check_number(f"{name}[{i}]", value, above=above)


def check_text(name: str, value: object, *, most: int = 200) -> None:
    """Refuse anything but a printable text of 1 to ``most`` characters.

    Raises:
        DesignError: with the name, the value and what is allowed.
    """
    if not (isinstance(value, str) and 0 < len(value) <= most and value.isprintable()):
        raise DesignError(name, got=value, allowed=f"a printable text of 1 to {most} characters")


def check_type(name: str, value: object, kinds: type | Sequence[type]) -> None:
    """Refuse a value that is none of ``kinds``.

    Raises:
        DesignError: with the name, the value and the kinds.
    """
    kinds = (kinds,) if isinstance(kinds, type) else tuple(kinds)
    if not isinstance(value, kinds):
        raise DesignError(name, got=value, allowed=" or ".join(kind.__name__ for kind in kinds))


def _to_float(value: object) -> float:
    """The number itself, nan for anything else and for whole numbers that no float holds."""
    if not isinstance(value, (int, float)) or isinstance(value, bool):
        return math.nan
    try:
        return float(value) if float(value) == value else math.nan
    except OverflowError:
        return math.nan


FEW = 32
"""Numbers up to which plain Python looks at them sooner than NumPy starts [-]."""


def read_numbers(name: str, value: ArrayLike) -> np.ndarray:
    """An array of finite numbers.

    Raises:
        ModelError: for anything else.
    """
    if type(value) is float and math.isfinite(value):
        return np.array(value)
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):  # Ragged.
        array = np.empty(0, object)
    if array.dtype.kind not in "fiub" or isinstance(value, np.ma.MaskedArray):
        raise ModelError(f"{name} is {tell(value)}; allowed: finite numbers")
    array = array.astype(float, copy=False)
    is_finite = all(map(math.isfinite, array.ravel().tolist())) if array.size <= FEW else np.isfinite(array).all()
    if not is_finite:
        raise ModelError(f"{name} is not finite; allowed: finite numbers")
    return array


def check_kind(name: str, value: object, kind: type) -> None:
    """Refuse anything that is not of a kind.

    Raises:
        ModelError: with the name, the value and the kind.
    """
    if not isinstance(value, kind):
        raise ModelError(f"{name} is {tell(value)}; allowed: {kind.__name__}")
