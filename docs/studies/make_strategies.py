"""Puts surveys of the nine strategies into validation/strategies.md: rates, failures, success by size and mass.

`spiraltrunk survey --trials 100 --out FOLDER` makes a survey, hours on two cores. Then:
`python docs/studies/make_strategies.py FOLDER [FOLDER ...]`. Where several have one strategy, the last counts.

`python benchmarks/range_payload.py --out FOLDER` measures range and payload, and
`python docs/studies/make_strategies.py --range FOLDER` puts those into the page.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from spiraltrunk import strategies
from spiraltrunk.workflows.survey.results import write_pictures
from spiraltrunk.workflows.survey.tables import format_markdown

DOCS = Path(__file__).parents[1]

TRIALS = 100
"""Trials of each strategy that make the page complete."""


def main(folders: Sequence[str]) -> int:
    """Gather, draw, and put the tables into the page."""
    if len(folders) == 2 and folders[0] == "--range":
        return put_range(Path(folders[1]))
    if not folders:
        print(
            "make_strategies: no folder given; allowed: folders that `spiraltrunk survey --out` made", file=sys.stderr
        )
        return 2
    surveys = [json.loads((Path(folder) / "survey.json").read_text()) for folder in folders]
    result = gather(surveys)
    (DOCS / "studies" / "strategies.json").write_text(json.dumps(result, indent=1) + "\n")
    page = DOCS / "validation" / "strategies.md"
    page.write_text(put_tables(page.read_text(), result))
    last = {name: survey for survey in surveys for name in survey["strategies"]}
    rows = [row for name, survey in last.items() for row in survey["rows"] if row["strategy"] == name]
    write_pictures(result, rows, DOCS / "images" / "strategies_rates.png", DOCS / "images" / "strategies_heatmap.png")
    return 0


def put_range(folder: Path) -> int:
    """Keep what a run of range_payload.py found, and put it into the page."""
    table = json.loads((folder / "range_payload.json").read_text())
    (DOCS / "studies" / "range_payload.json").write_text(json.dumps(table, indent=1) + "\n")
    page = DOCS / "validation" / "strategies.md"
    page.write_text(put_section(page.read_text(), "range", format_range(table)))
    return 0


def format_range(table: dict[str, Any]) -> str:
    """Range and payload beside the paper's, as Markdown; what an interrupted run did not come to is left out."""
    paper, seeds = table["paper"], table["seeds"]
    rows = [
        (f"{what} cylinder of {table['light_kg']:g} kg", _told(table[key], 1e3, "mm"), _told(paper[key], 1e3, "mm"))
        for what, key in (("thinnest", "width_least_m"), ("widest", "width_most_m"))
        if key in table
    ]
    for width, mass in table["payload_kg"].items():
        at = _told(paper["payload_kg"], 1.0, "kg") if float(width) == paper["width_least_m"] else "-"
        rows.append((f"heaviest of {float(width) * 1e3:g} mm", _told(mass, 1.0, "kg"), at))
    lines = [f"| held by all of {seeds} seeds | here | paper |", "| --- | --- | --- |"]
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in rows)])


def _told(value: float | None, scale: float, unit: str) -> str:
    return "none" if value is None else f"{value * scale:g} {unit}"


def put_section(page: str, name: str, text: str) -> str:
    """The page with what stands between a section's two comments replaced."""
    pattern = rf"(<!-- {name} -->\n).*?(<!-- end of {name} -->)"
    return re.sub(pattern, lambda match: f"{match[1]}{text}\n{match[2]}", page, flags=re.DOTALL)


def gather(surveys: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Counts of all strategies in the order of their numbers, each with its seed, without the single trials."""
    told = {
        name: counts | {"seed": survey["settings"]["seed"]}
        for survey in surveys
        for name, counts in survey["strategies"].items()
    }
    ordered = sorted(told, key=lambda name: strategies.get(name).number)
    asked = TRIALS * len(told)
    return {
        "strategies": {name: told[name] for name in ordered},
        "complete": sum(counts["trials"] for counts in told.values()) >= asked,
        "asked": asked,
        "versions": surveys[-1]["settings"]["versions"],
    }


def put_tables(page: str, result: dict[str, Any]) -> str:
    """The page with its tables made anew."""
    rates, objects = format_markdown(result).rstrip().rsplit("\n\n", 1)
    for name, table in (("rates", rates), ("objects", objects)):
        page = put_section(page, name, table)
    return page


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
