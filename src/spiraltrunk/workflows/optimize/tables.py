"""A search's candidates as tables, for the terminal and for a page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from spiraltrunk.report.table import format_table
from spiraltrunk.workflows.optimize.search_space import SPACE

_UNSEEN = ("on unseen objects", "grasped", "rate", "95 % interval")

_SHOWN = 8
"""Candidates in the table for the terminal [-]."""


def format_text(result: Mapping[str, Any]) -> str:
    """The best candidates, and the best trunk beside the preset paper on unseen objects."""
    header, rows = _list_rows(result)
    told = [format_table(rows[:_SHOWN], header=header)]
    if result["unseen"]:
        told.append(format_table(_list_unseen(result), header=_UNSEEN))
        told.append(_format_difference(result["unseen"]["difference"]))
    return "\n\n".join(told)


def format_markdown(result: Mapping[str, Any]) -> str:
    """All candidates, the best first; the comparison on unseen objects."""
    header, rows = _list_rows(result)
    short = "" if result["complete"] else f"Incomplete: {len(rows)} of {result['asked']} candidates.\n\n"
    text = short + _format_rows(header, rows)
    if result["unseen"]:
        text += "\n" + _format_rows(_UNSEEN, _list_unseen(result))
        text += f"\n{_format_difference(result['unseen']['difference'])}\n"
    return text


def _list_rows(result: Mapping[str, Any]) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    header = ("candidate", *(each.name for each in SPACE), "grasped", "95 % interval", "payload [kg]", "range [mm]", "")
    ranked = sorted(result["candidates"], key=lambda one: (bool(one["faults"]), -one["success"], -one["payload"]))
    rows = []
    for one in ranked:
        marks = [word for word, holds in (("best", one["number"] == result["best"]),
                                          ("front", one["number"] in result["front"])) if holds]  # fmt: skip
        note = f"cannot be made: {one['faults'][0]}" if one["faults"] else ", ".join(marks)
        rows.append(
            (
                str(one["number"]), *(f"{one['values'][each.name]:.3g}" for each in SPACE),
                *_format_count(one), f"{one['payload']:.2f}", f"{1e3 * one['range']:.0f}", note,
            )
        )  # fmt: skip
    return header, rows


def _format_count(one: Mapping[str, Any]) -> tuple[str, str]:
    """Successes and their interval; dashes where nothing was tried, as of a trunk that cannot be made."""
    if not one["trials"]:
        return "-", "-"
    return f"{one['successes']} of {one['trials']}", f"{100 * one['low']:.0f} to {100 * one['high']:.0f} %"


def _list_unseen(result: Mapping[str, Any]) -> list[tuple[str, ...]]:
    names = {"paper": "preset paper", "best": f"candidate {result['best']}"}
    return [
        (names[name], f"{own['successes']} of {own['trials']}", f"{100 * own['rate']:.0f} %",
         f"{100 * own['low']:.0f} to {100 * own['high']:.0f} %")
        for name, own in result["unseen"].items()
        if name in names
    ]  # fmt: skip


def _format_difference(told: Mapping[str, Any]) -> str:
    """Paired difference of the two rates, in words."""
    low, high = (f"{100 * told[key]:+.0f}" for key in ("low", "high"))
    return (
        f"Difference {100 * told['difference']:+.0f} % of the objects ({low} to {high} %, paired); "
        f"{told['only_b']} by the best alone, {told['only_a']} by the paper's alone; "
        f"p = {told['p']:.2g} (exact McNemar)."
    )


def _format_rows(header: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    lines = [header, ("---",) * len(header), *rows]
    return "".join("| " + " | ".join(cell.replace("|", "/") for cell in line) + " |\n" for line in lines)
