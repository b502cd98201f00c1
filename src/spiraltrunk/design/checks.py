"""Checks of design values: each refuses a wrong type, a non-finite number and a value outside its range."""

from __future__ import annotations

import math
from collections.abc import Sequence

from spiraltrunk.errors import DesignError


def check_number(
    name: str, value: object, *, above: float = -math.inf, least: float = -math.inf, below: float = math.inf
) -> None:
    """Refuse anything but a finite number in (``above``, ``below``) that is at least ``least``.

    Raises:
        DesignError: with the name, the value and the range.
    """
    number = _to_float(value)
    if not (math.isfinite(number) and above < number < below and number >= least):
        raise DesignError(name, got=value, allowed=_range(above, least, below))


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
        raise DesignError(name, got=f"{len(values)} numbers", allowed=f"{count} numbers")
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


def _range(above: float, least: float, below: float) -> str:
    parts = ["a finite number"]
    if above > -math.inf:
        parts.append(f"above {above:g}")
    if least > -math.inf:
        parts.append(f"at least {least:g}")
    if below < math.inf:
        parts.append(f"below {below:g}")
    return ", ".join(parts)
