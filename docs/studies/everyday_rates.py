"""Rates with drawn everyday things: rows of the benchmarks as everyday_rates.json, and their tables.

`benchmarks/everyday_objects.py --part CLASS --out FILE` and `benchmarks/auto_choice.py --out DIR` make the rows. Then
`python docs/studies/everyday_rates.py FILE... [DIR/auto_choice.jsonl]` collects them, and `make_everyday.py` puts them
into the page. Rows of one class must be of one version of the code.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from spiraltrunk.files.atomic import write_text
from spiraltrunk.workflows.survey.summary import wilson

RESULT = Path(__file__).parent / "everyday_rates.json"

CLASSES = {
    "upright": ("standing, 40 to 80 mm wide, 80 to 240 mm tall, 20 to 400 g", "`paper`, `auto`"),
    "compact": ("compact solids, 25 to 70 mm wide, 50 to 250 g", "`paper-large-grip`, `tip-grip`"),
    "lying": ("slender, lying, 15 to 45 mm wide, 50 to 250 g", "`paper-large-grip`, `pinch`"),
}
"""Words for each class of the benchmark, and how it is taken."""

KEPT = (
    "part", "seed", "name", "size_mm", "mass_g", "success", "held", "upright", "refused", "cause", "lost_in", "tries",
    "friction", "ground_m", "simulated_s", "source",
)  # fmt: skip
"""Entries of a row of `everyday_objects.py` that are kept."""


def main(arguments: Sequence[str]) -> int:
    """Collect rows into everyday_rates.json."""
    if not arguments:
        print("everyday_rates: given no rows; allowed: files of JSON lines that the benchmarks wrote", file=sys.stderr)
        return 2
    rows = [json.loads(line) for name in arguments for line in Path(name).read_text().splitlines()]
    classes = [{key: row.get(key) for key in KEPT} for row in rows if "part" in row]
    classes.sort(key=lambda row: (list(CLASSES).index(row["part"]), row["seed"]))
    choice = sorted((row for row in rows if "index" in row), key=lambda row: row["index"])
    for part in CLASSES:
        versions = {row["source"] for row in classes if row["part"] == part}
        if len(versions) > 1:
            print(f"everyday_rates: given rows of {part} of {len(versions)} versions; allowed: one", file=sys.stderr)
            return 2
    lines = ",\n".join(f'"{key}": [\n{_format_rows(own)}\n]' for key, own in (("classes", classes), ("choice", choice)))
    write_text(RESULT, f"{{\n{lines}\n}}\n")
    return 0


def _format_rows(rows: Iterable[dict[str, Any]]) -> str:
    return ",\n".join(json.dumps(row, allow_nan=False) for row in rows)


def load_rates() -> dict[str, Any]:
    """Rows of the classes and of the choices."""
    rates: dict[str, Any] = json.loads(RESULT.read_text())
    return rates


def format_rates(rates: dict[str, Any]) -> str:
    """Rates of each class, with 95 % Wilson intervals, and the causes of its failures."""
    lines = [
        "| objects | robot, strategy | seeds | held | set down upright | full success | causes of failures |",
        "|---|---|---|---|---|---|---|",
    ]
    for part, (what, how) in CLASSES.items():
        rows = [row for row in rates["classes"] if row["part"] == part]
        if rows:
            seeds = f"{rows[0]['seed']} to {rows[-1]['seed']}"
            cells = (format_rate([row[entry] for row in rows]) for entry in ("held", "upright", "success"))
            lines.append(f"| {what} | {how} | {seeds} | {' | '.join(cells)} | {format_causes(rows)} |")
    return "\n".join(lines)


def format_choice(rates: dict[str, Any]) -> str:
    """How often the choice was right: what it calls feasible, and what it refuses when that is forced."""
    rows = rates["choice"]
    feasible = [row["auto"]["success"] for row in rows if row["auto"] is not None]
    first = [row["auto"]["success"] and len(row["auto"]["tries"]) == 1 for row in rows if row["auto"] is not None]
    forced = [row["forced"]["success"] for row in rows if row["forced"] is not None]
    causes = format_causes([row["auto"] for row in rows if row["auto"] is not None])
    lines = [
        "| what `auto` says of an object | full success | causes of failures |",
        "|---|---|---|",
        f"| feasible: its choice, with up to three tries | {format_rate(feasible)} | {causes} |",
        f"| of these, by the first try | {format_rate(first)} | |",
        f"| infeasible: a refused strategy, forced | {format_rate(forced)} | |",
    ]
    return "\n".join(lines)


def format_scores(rates: dict[str, Any], parts: int = 4) -> str:
    """Predicted chances and rates of first tries of the things called feasible, in parts of equal size by score."""
    tried = [row for row in rates["choice"] if row["auto"] is not None and row["auto"]["tries"][0] in row["feasible"]]
    pairs = sorted(
        (row["feasible"][row["auto"]["tries"][0]], row["auto"]["success"] and len(row["auto"]["tries"]) == 1)
        for row in tried
    )
    lines = ["| score of the first try | in the mean | first tries that succeeded |", "|---|---|---|"]
    for k in range(parts):
        part = pairs[k * len(pairs) // parts : (k + 1) * len(pairs) // parts]
        scores, outcomes = [score for score, _ in part], [outcome for _, outcome in part]
        mean = sum(scores) / len(scores)
        lines.append(f"| {scores[0]:.2f} to {scores[-1]:.2f} | {mean:.2f} | {format_rate(outcomes)} |")
    return "\n".join(lines)


def format_rate(outcomes: Sequence[bool]) -> str:
    """A rate with its 95 % Wilson interval."""
    if not outcomes:
        return "not tried"
    low, high = wilson(sum(outcomes), len(outcomes))
    return f"{sum(outcomes)} of {len(outcomes)} ({100 * low:.0f} to {100 * high:.0f} %)"


def format_causes(rows: Iterable[dict[str, Any]]) -> str:
    """Causes of the failures, the most frequent first; those after the hold are told so."""
    causes = Counter(
        f"{_name_cause(row)} after the hold" if row["held"] else _name_cause(row) for row in rows if not row["success"]
    )
    return ", ".join(f"{count} {cause}" for cause, count in causes.most_common()) or "none"


def _name_cause(row: dict[str, Any]) -> str:
    return "refused" if row["cause"] is None else str(row["cause"])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
