"""A comparison of two surveys as a table."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from spiraltrunk.report import format_table

_HEADER = ("strategy", "pairs", "A", "B", "B - A, 95 % interval", "only A", "only B", "p", "p (Holm)", "differs")

_LONGEST = 100
"""Length to which the value of a setting is shortened."""


def format_comparison(result: Mapping[str, Any]) -> str:
    """One line for each strategy and one over all, then what is not paired and which settings differ."""
    rows = [_format_line(name, told) for name, told in result["strategies"].items()]
    rows.append(_format_line("all", result["overall"]))
    lines = [f"A is {result['a']}, B is {result['b']}", format_table(rows, header=_HEADER)]
    unpaired = result["unpaired"]
    if unpaired["a"] or unpaired["b"]:
        lines.append(f"not paired, and not counted: {unpaired['a']} trials of A, {unpaired['b']} of B")
    lines += [f"{key}: {_short(a)} in A, {_short(b)} in B" for key, (a, b) in result["settings"].items()]
    differing = [name for name, told in result["strategies"].items() if told["significant"]]
    told = f"significant at 5 %, corrected by Holm: {', '.join(differing) or 'none'}"
    return "\n".join((*lines, told))


def _format_line(name: str, told: Mapping[str, Any]) -> tuple[str, ...]:
    interval = "-"
    if told["difference"] is not None:
        interval = " to ".join(f"{100 * told[key]:+.1f}" for key in ("low", "high"))
        interval = f"{100 * told['difference']:+.1f} % ({interval})"
    rates = (f"{told[key]['successes']} of {told[key]['trials']}" for key in "ab")
    holm = told.get("p_holm")
    return (
        name, str(told["pairs"]), *rates, interval, str(told["only_a"]), str(told["only_b"]), f"{told['p']:.3g}",
        "-" if holm is None else f"{holm:.3g}", "yes" if told["significant"] else "no",
    )  # fmt: skip


def _short(value: object) -> str:
    text = value if isinstance(value, str) else json.dumps(value)
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."
