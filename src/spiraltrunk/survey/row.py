"""What a survey's table says of one trial."""

from __future__ import annotations

from typing import Any

from spiraltrunk.survey.plan import Entry

Row = dict[str, Any]
"""One trial in plain values, ready for JSON."""

WORLD = ("width_m", "mass_kg", "friction", "stiffness_factor")
"""What a row tells of the world that was drawn."""

FIGURES = ("simulated_s", "real_time_factor", "planning_wall_s", "lift_m", "hold_s", "place_error_m", "retries")
"""What it tells of the trial; null where there was none."""


def build_empty_row(entry: Entry, reason: str = "") -> Row:
    """A failed trial of which nothing else is known."""
    return {
        "strategy": entry.strategy,
        "object": entry.object,
        "index": entry.index,
        "seed": entry.seed,
        "success": False,
        "reason": reason,
        "wall_s": None,
        **dict.fromkeys(WORLD),
        **dict.fromkeys(FIGURES),
    }
