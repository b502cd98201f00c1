"""What a strategy may be told to do otherwise: numbers, checked once when they are given."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields
from typing import Any, TypeVar

from spiraltrunk.checks import check_count, check_number, check_numbers, check_type

_Options = TypeVar("_Options")

LARGEST = 100.0
"""Bound of every choice, in its own unit."""


def check_choices(options: Any, *, positive: Iterable[str] = (), signed: Iterable[str] = ()) -> None:
    """Refuse options whose numbers no strategy can work with: they are finite, at least 0, and counts are whole.

    Args:
        options: a dataclass of numbers, pairs of numbers and other options.
        positive: names of those that are divided by, so that 0 is none.
        signed: names of those that may be negative.

    Raises:
        DesignError: with name, value and what is allowed.
    """
    for field in fields(options):
        name, value = f"{type(options).__name__}.{field.name}", getattr(options, field.name)
        if field.type == "int":
            check_count(name, value, least=0, most=100)
        elif field.type == "float":
            bound = {"above": 0.0} if field.name in positive else {"least": -LARGEST if field.name in signed else 0.0}
            check_number(name, value, **bound, below=LARGEST)
        elif field.type == "tuple[float, float]":
            check_numbers(name, value, count=2, above=0.0)


def choose(options: _Options | None, usual: _Options) -> _Options:
    """The options given, which must be of the usual ones' kind, or the usual ones for None.

    Raises:
        DesignError: for options of another kind.
    """
    if options is None:
        return usual
    check_type("options", options, type(usual))
    return options
