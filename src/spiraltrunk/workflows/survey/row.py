"""What a survey's table says of one trial."""

from __future__ import annotations

from typing import Any

from spiraltrunk.workflows.survey.plan import Entry

Row = dict[str, Any]
"""One trial in plain values, ready for JSON."""

WORLD = ("width_m", "mass_kg", "friction", "stiffness_factor")
"""What a row tells of the world that was drawn."""

FIGURES = ("simulated_s", "real_time_factor", "planning_wall_s", "lift_m", "hold_s", "place_error_m", "retries")
"""What it tells of the trial; null where there was none."""


_NAMES = ("strategy", "object", "index", "seed", "success", "reason", "wall_s")


def build_empty_row(entry: Entry, reason: str = "") -> Row:
    """A failed trial of which nothing else is known."""
    told = (entry.strategy, entry.object, entry.index, entry.seed, False, reason, None)
    return {**dict(zip(_NAMES, told, strict=True)), **dict.fromkeys((*WORLD, *FIGURES))}


def check_row(row: Row) -> None:
    """Refuse what tells other things than a trial.

    Raises:
        ValueError: with what is missing or strange.
    """
    differing = row.keys() ^ {*_NAMES, *WORLD, *FIGURES}
    if differing:
        raise ValueError(f"{sorted(differing)} missing or strange")
