"""Rows of a survey's table, one for each trial."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from spiraltrunk.workflows.survey.plan import Entry

Row = dict[str, Any]
"""One trial in plain values, ready for JSON."""

_FIGURES = (
    "width_m", "mass_kg", "friction", "stiffness_factor", "simulated_s", "real_time_factor", "planning_wall_s",
    "lift_m", "hold_s", "place_error_m", "retries",
)  # fmt: skip
"""Figures of the scene and of the trial; null where there are none."""

_KEYS = {"strategy", "object", "index", "seed", "success", "reason", "wall_s", *_FIGURES}


def build_empty_row(entry: Entry, reason: str = "") -> Row:
    """A failed trial without figures."""
    return {**asdict(entry), "success": False, "reason": reason, "wall_s": None, **dict.fromkeys(_FIGURES)}


def check_row(row: Row) -> None:
    """Refuse a row with other keys.

    Raises:
        ValueError: with the missing or unknown keys.
    """
    differing = row.keys() ^ _KEYS
    if differing:
        raise ValueError(f"{sorted(differing)} missing or unknown")
