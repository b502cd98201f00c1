"""Domain randomisation by name: which quantities of a world are drawn, and how far."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

from spiraltrunk.errors import DesignError, UnknownName
from spiraltrunk.workflows.grasp.world import AS_ANNOUNCED, Spread

DEFAULT = Spread()
"""The ranges of the survey."""

FACTORS = tuple(field.name for field in fields(Spread))
"""Names of the factors."""

Randomization = str | Sequence[str] | Mapping[str, object] | Spread
"""What an environment takes: "none", "default", a factor, several factors, factors with their ranges, or a `Spread`."""


def parse_randomization(value: Randomization) -> Spread:
    """The ranges of a randomisation by name.

    Args:
        value: "default" draws every factor as surveys do; "none" draws nothing; the name of a factor, or a sequence of
            names, draws these alone; a mapping gives the ranges of its factors in the units of `Spread`; a `Spread` is
            taken as it is.

    Raises:
        UnknownName: for another name; it lists the factors.
        DesignError: for a range that `Spread` refuses.
    """
    if isinstance(value, Spread):
        return value
    if isinstance(value, str) and value in ("none", "default"):
        return AS_ANNOUNCED if value == "none" else DEFAULT
    if isinstance(value, Mapping):
        ranges: dict[str, Any] = {_check_factor(name): _as_range(name, given) for name, given in value.items()}
        return replace(AS_ANNOUNCED, **ranges)
    names = (value,) if isinstance(value, str) else value
    if not isinstance(names, Sequence):
        raise DesignError("randomization", got=value, allowed=f"none, default, or of {', '.join(FACTORS)}")
    return replace(AS_ANNOUNCED, **{_check_factor(name): getattr(DEFAULT, name) for name in names})


def _check_factor(name: object) -> str:
    if not isinstance(name, str) or name not in FACTORS:
        raise UnknownName("randomization", str(name), ("none", "default", *FACTORS))
    return name


def _as_range(name: str, given: object) -> object:
    """The value of a factor; lists, as JSON has them, are tuples."""
    if name == "sensors" and isinstance(given, bool):
        return DEFAULT.sensors if given else AS_ANNOUNCED.sensors
    return tuple(given) if isinstance(given, list) else given


def describe_spread(spread: Spread) -> dict[str, float]:
    """The ranges in plain numbers, angles in degrees."""
    low, high = spread.friction
    return {
        "position_m": spread.position, "yaw_deg": math.degrees(spread.yaw), "size": spread.size, "mass": spread.mass,
        "friction_low": low, "friction_high": high, "stiffness": spread.stiffness,
    }  # fmt: skip
