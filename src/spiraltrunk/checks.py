"""Checks of values where they enter: numbers, counts, texts and types; each refusal is one line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from types import EllipsisType
from typing import NamedTuple, final

import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.errors import DesignError, ModelError, SpiralTrunkError, Unquoted, describe


@final
class Range(NamedTuple):
    """An interval of finite numbers; as a text it states its bounds."""

    above: float = -math.inf
    """Every number is larger than this."""
    least: float = -math.inf
    """No number is smaller than this."""
    below: float = math.inf
    """Every number is smaller than this."""
    most: float = math.inf
    """No number is larger than this."""

    def holds(self, number: float) -> bool:
        """Whether the number is finite and in the range."""
        return self.above < number < self.below and self.least <= number <= self.most

    def in_unit(self, unit: float) -> Range:
        """The same range for numbers that count multiples of ``unit``."""
        return Range(*(bound / unit for bound in self))

    def __str__(self) -> str:
        words = zip(("above", "at least", "below", "at most"), self, strict=True)
        return ", ".join(["a finite number", *(f"{word} {bound:g}" for word, bound in words if math.isfinite(bound))])


@final
class OutOfRange(NamedTuple):
    """A number that is not in its range; as a text it states both."""

    name: str
    """What the error calls it."""
    number: float
    """The number."""
    allowed: Range
    """Its range."""
    unit: str = ""
    """Unit of both."""

    def in_unit(self, unit: str, size: float) -> OutOfRange:
        """The same in ``unit``, which is ``size`` of the present one."""
        return OutOfRange(self.name, self.number / size, self.allowed.in_unit(size), unit)

    def __str__(self) -> str:
        of = f" {self.unit}" if self.unit else ""
        return f"{self.name} is {self.number:g}{of}; allowed: {self.allowed}{of}"


FINITE = Range()
"""Every finite number."""

FEW = 32
"""Size up to which plain Python checks an array sooner than NumPy starts [-]."""


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
    check_range(name, value, Range(above, least, below, most))


def check_range(name: str, value: object, allowed: Range) -> None:
    """Refuse anything but a number in the range.

    Raises:
        DesignError: with the name, the value and the range.
    """
    if not (isinstance(value, (float, int)) and allowed.holds(value)):
        raise DesignError(name, got=value, allowed=allowed)


def check_tip(width: float, least: float) -> None:
    """Refuse a tip that is thinner than ``least`` [m]: it cannot be made, and the sizes derived from it underflow.

    Raises:
        DesignError: with both widths, and what makes the tip wider.
    """
    if not width >= least:
        allowed = f"at least {1e3 * least:g} mm: fewer turns or sections, a smaller b (larger m) or a wider base"
        raise DesignError("width of the tip", got=Unquoted(f"{1e3 * width:.3g} mm"), allowed=allowed)


def check_count(name: str, value: object, *, least: int, most: int) -> None:
    """Refuse anything but a whole number from ``least`` to ``most``.

    Raises:
        DesignError: with the name, the value and the range.
    """
    if not (isinstance(value, (int, np.integer)) and least <= value <= most):
        raise DesignError(name, got=value, allowed=f"a whole number from {least} to {most}")


def check_numbers(
    name: str,
    values: object,
    *,
    count: int | None = None,
    above: float = -math.inf,
    least: float = -math.inf,
    most: float = math.inf,
) -> None:
    """Refuse anything but a tuple of numbers as of `check_number`, ``count`` of them where a count is given.

    Raises:
        DesignError: with the name, the value and what is allowed.
    """
    if not isinstance(values, tuple):
        raise DesignError(name, got=values, allowed="a tuple of numbers")
    if count is not None and len(values) != count:
        raise DesignError(name, got=Unquoted(f"{len(values)} numbers"), allowed=f"{count} numbers")
    for i, value in enumerate(values):
        check_number(f"{name}[{i}]", value, above=above, least=least, most=most)


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


def read_array(
    name: str,
    value: ArrayLike,
    shape: tuple[int | EllipsisType, ...] | None = None,
    *,
    error: type[SpiralTrunkError] = ModelError,
) -> np.ndarray:
    """The value as an array of floats, which may be infinite or NaN; an array of floats is returned as it is.

    Args:
        name: what the error calls it.
        value: a number, an array or nested sequences of numbers.
        shape: shape that it must have, a leading ``...`` standing for any axes; None allows every shape.
        error: class of the error.

    Raises:
        SpiralTrunkError: of class ``error``, where it is not numbers or of another shape.
    """
    if type(value) is np.ndarray and value.dtype == np.float64:
        array = value
    else:
        try:
            array = np.asarray(value)
        except (TypeError, ValueError):  # Ragged.
            array = np.empty(0, object)
        if array.dtype.kind not in "fiub":
            raise error(f"{name} is {describe(value)}; allowed: numbers")
        array = array.astype(float, copy=False)
    if not (shape is None or array.shape == shape or _ends_in(array.shape, shape)):
        allowed = str(shape).replace("Ellipsis", "...") if shape else "one number"
        raise error(f"{name} has shape {array.shape}; allowed: {allowed}")
    return array


def _ends_in(shape: tuple[int, ...], wanted: tuple[int | EllipsisType, ...]) -> bool:
    return wanted[:1] == (...,) and shape[1 - len(wanted) :] == wanted[1:]


def read_numbers(
    name: str,
    value: ArrayLike,
    allowed: Range = FINITE,
    *,
    shape: tuple[int | EllipsisType, ...] | None = None,
    unit: str = "",
    error: type[SpiralTrunkError] = ModelError,
) -> np.ndarray:
    """`read_array`, each number of which is finite and in the range, which the error states in ``unit``.

    Raises:
        SpiralTrunkError: of class ``error``, with the first number out of the range, or where it is not numbers or of
            another shape.
    """
    if type(value) is float and allowed is FINITE and not shape and math.isfinite(value):
        return np.array(value)
    array = read_array(name, value, shape, error=error)
    if not _are_within(array, allowed):
        outside = OutOfRange(name, next(number for number in array.flat if not allowed.holds(number)), allowed, unit)
        refusal = error(str(outside))
        refusal.outside = outside
        raise refusal
    return array


def _are_within(array: np.ndarray, allowed: Range) -> bool:
    if array.size > FEW:  # Least and largest of numbers with a NaN are NaN.
        return allowed.holds(array.min()) and allowed.holds(array.max())
    numbers = array.ravel().tolist()
    if not all(map(math.isfinite, numbers)):
        return False
    return allowed is FINITE or not numbers or (allowed.holds(min(numbers)) and allowed.holds(max(numbers)))


def broadcast_batches(batches: dict[str, tuple[int, ...]]) -> tuple[int, ...]:
    """The shape to which the batch axes of several inputs broadcast.

    Raises:
        ModelError: with every input's axes, where they do not.
    """
    try:
        return np.broadcast_shapes(*batches.values()) if any(batches.values()) else ()
    except ValueError:
        given = ", ".join(f"{name} {axes}" for name, axes in batches.items())
        raise ModelError(f"batches are {given}; allowed: batches that broadcast") from None
