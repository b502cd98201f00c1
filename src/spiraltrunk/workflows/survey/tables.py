"""A survey's rates as tables, for the terminal and for a page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from spiraltrunk.report import format_table

_HEADER = ("strategy", "succeeded", "rate", "95 % interval")
_TIMES = ("time [s]", "time without retry [s]")


def format_text(result: Mapping[str, Any]) -> str:
    """One line for each strategy, with the wall time of a trial, which depends on the machine."""
    rows = [
        (
            *_format_rate(name, own), _format_seconds(own["median_wall_s"]), _format_failures(own.get("causes", {})),
            _format_failures(own["failures"]),
        )
        for name, own in result["strategies"].items()
    ]  # fmt: skip
    return format_table(rows, header=(*_HEADER, "s a trial", "causes", "failures"))


def format_markdown(result: Mapping[str, Any]) -> str:
    """Success rates by strategy, by class of objects, and by strategy and object; equal for a seed on any machine.

    Times are medians over the successful trials: what the robot takes from its start to the end of the release.
    Surveys of earlier versions have neither causes, classes nor these times.
    """
    done = sum(own["trials"] for own in result["strategies"].values())
    short = "" if result["complete"] else f"Incomplete: {done} of {result['asked']} trials.\n\n"
    whole = [
        (
            *_format_rate(f"`{name}`", own), *(_format_count(own.get(key)) for key in ("held", "upright")),
            *(_format_seconds(own.get(key)) for key in ("median_success_s", "median_success_first_s")),
            _format_failures(own.get("causes", {})), _format_failures(own["failures"]),
        )
        for name, own in result["strategies"].items()
    ]  # fmt: skip
    classes = [
        (*_format_rate(name, own), _format_failures(own["causes"])) for name, own in result.get("classes", {}).items()
    ]
    parts = [
        (f"`{name}`", *_format_rate(f"`{each}`", counted))
        for name, own in result["strategies"].items()
        for each, counted in own["objects"].items()
    ]
    by_strategy = _format_rows((*_HEADER, "held", "upright", *_TIMES, "causes", "failures"), whole)
    by_class = _format_rows(("class of objects", *_HEADER[1:], "causes"), classes) + "\n" if classes else ""
    return f"{short}{by_strategy}\n{by_class}{_format_rows((_HEADER[0], 'object', *_HEADER[1:]), parts)}"


def _format_rows(header: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    lines = [header, ("---",) * len(header), *rows]
    return "".join(f"| {' | '.join(cell.replace('|', '/') for cell in line)} |\n" for line in lines)


def _format_rate(name: str, counted: Mapping[str, Any]) -> tuple[str, str, str, str]:
    rate = "-" if counted["rate"] is None else f"{100 * counted['rate']:.0f} %"
    interval = f"{100 * counted['low']:.1f}-{100 * counted['high']:.1f} %"
    return name, f"{counted['successes']} of {counted['trials']}", rate, interval


def _format_failures(failures: Mapping[str, int]) -> str:
    return "; ".join(f"{count} x {kind}" for kind, count in failures.items()) or "-"


def _format_count(count: int | None) -> str:
    return "-" if count is None else str(count)


def _format_seconds(seconds: float | None) -> str:
    return "-" if seconds is None else f"{seconds:.1f}"
