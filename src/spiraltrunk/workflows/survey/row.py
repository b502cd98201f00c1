"""Rows of a survey's table, one for each trial."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from spiraltrunk.workflows.survey.plan import Entry, derive_seed

Row = dict[str, Any]
"""One trial in plain values, ready for JSON."""

_FIGURES = (
    "width_m", "mass_kg", "friction", "stiffness_factor", "simulated_s", "real_time_factor", "planning_wall_s",
    "lift_m", "hold_s", "place_error_m", "retries",
)  # fmt: skip
"""Figures of the scene and of the trial; null where there are none."""

_MOST = 1e9
"""Size that no figure of a trial reaches (ours)."""

_KEYS = {"strategy", "object", "index", "seed", "success", "reason", "wall_s", *_FIGURES}


def build_empty_row(entry: Entry, reason: str = "") -> Row:
    """A failed trial without figures."""
    return {**asdict(entry), "success": False, "reason": reason, "wall_s": None, **dict.fromkeys(_FIGURES)}


def check_row(row: Row, settings: Mapping[str, Any]) -> None:
    """Refuse what is no row of the survey with these settings.

    Raises:
        ValueError: says why; OverflowError and TypeError for numbers that are none.
    """
    differing = row.keys() ^ _KEYS
    if differing:
        raise ValueError(f"{sorted(differing)} missing or unknown")
    strategy, index = row["strategy"], row["index"]
    if not isinstance(strategy, str) or strategy not in settings["objects"]:
        raise ValueError("another strategy")
    if type(index) is not int or not 0 <= index < settings["trials"]:
        raise ValueError("another trial")
    objects = settings["objects"][strategy]
    if row["object"] != objects[index % len(objects)] or not isinstance(row["reason"], str):
        raise ValueError("another object, or no reason")
    if type(row["seed"]) is not int or row["seed"] != derive_seed(settings["seed"], strategy, index):
        raise ValueError("another seed")
    if not isinstance(row["success"], bool):
        raise ValueError("no outcome")
    for key in ("wall_s", *_FIGURES):
        if row[key] is not None and (type(row[key]) not in (int, float) or not abs(row[key]) < _MOST):
            raise ValueError(f"{key} is no number")
