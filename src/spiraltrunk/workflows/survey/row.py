"""Rows of a survey's table, one for each trial."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from spiraltrunk.workflows.grasp.verdict.cause import Cause
from spiraltrunk.workflows.survey.plan import Entry, derive_seed, find_place, parse_shard

Row = dict[str, Any]
"""One trial in plain values, ready for JSON."""

_FIGURES = (
    "width_m", "mass_kg", "friction", "stiffness_factor", "simulated_s", "real_time_factor", "planning_wall_s",
    "lift_m", "hold_s", "place_error_m", "retries", "cause_time_s",
)  # fmt: skip
"""Figures of the scene and of the trial; null where there are none."""

_MOST = 1e9
"""Size that no figure of a trial reaches (ours)."""

_CLAIMS = ("held", "upright")
"""True or false, or null where they do not apply."""

_LATER = ("cause", "cause_time_s", *_CLAIMS)
"""Keys that rows of earlier versions lack."""

_KEYS = {"strategy", "object", "index", "seed", "success", "reason", "cause", "wall_s", *_CLAIMS, *_FIGURES}

_CAUSES = {None, *(cause.value for cause in Cause)}


def build_empty_row(entry: Entry, reason: str = "") -> Row:
    """A failed trial without figures, whose process ended."""
    outcome = {"success": False, "reason": reason, "cause": Cause.FAULT.value, "wall_s": None}
    return {**asdict(entry), **outcome, **dict.fromkeys((*_CLAIMS, *_FIGURES))}


def fill_row(row: Row) -> Row:
    """A row of an earlier version with the keys that it lacks, at its end; the cause of its failure is unknown."""
    later = dict.fromkeys(_LATER) | {"cause": None if row.get("success") else Cause.UNKNOWN.value}
    return {**row, **{key: value for key, value in later.items() if key not in row}}


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
    shard, place = (
        settings.get("shard"),
        find_place(list(settings["objects"]).index(strategy), index, len(settings["objects"])),
    )
    if shard is not None and not parse_shard(shard).holds(place):
        raise ValueError("of another shard")
    if row["object"] != objects[index % len(objects)] or not isinstance(row["reason"], str):
        raise ValueError("another object, or no reason")
    if type(row["seed"]) is not int or row["seed"] != derive_seed(settings["seed"], strategy, index):
        raise ValueError("another seed")
    if not isinstance(row["success"], bool):
        raise ValueError("no outcome")
    if row["cause"] not in _CAUSES or any(row[key] not in (None, True, False) for key in _CLAIMS):
        raise ValueError("no cause, or claims that are none")
    for key in ("wall_s", *_FIGURES):
        if row[key] is not None and (type(row[key]) not in (int, float) or not abs(row[key]) < _MOST):
            raise ValueError(f"{key} is no number")
