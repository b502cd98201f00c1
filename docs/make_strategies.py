"""Puts surveys of the nine strategies into docs/strategies.md: rates, failures, and where in size and mass they hold.

`spiraltrunk survey --trials 100 --out FOLDER` makes a survey, hours on two cores. Then:
`python docs/make_strategies.py FOLDER [FOLDER ...]`; where several tell of one strategy, the last of them counts.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from spiraltrunk import strategies
from spiraltrunk.survey.engine import write_pictures
from spiraltrunk.survey.tables import format_markdown

DOCS = Path(__file__).parent

TRIALS = 100
"""Trials of each strategy that make the page complete."""


def main(folders: Sequence[str]) -> int:
    """Gather, draw, and put the tables into the page."""
    if not folders:
        print(
            "make_strategies: no folder given; allowed: folders that `spiraltrunk survey --out` made", file=sys.stderr
        )
        return 2
    surveys = [json.loads((Path(folder) / "survey.json").read_text()) for folder in folders]
    result = gather(surveys)
    (DOCS / "strategies.json").write_text(json.dumps(result, indent=1) + "\n")
    page = DOCS / "strategies.md"
    page.write_text(put_tables(page.read_text(), result))
    last = {name: survey for survey in surveys for name in survey["strategies"]}
    rows = [row for name, survey in last.items() for row in survey["rows"] if row["strategy"] == name]
    write_pictures(result, rows, DOCS / "images" / "strategies_rates.png", DOCS / "images" / "strategies_heatmap.png")
    return 0


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
        pattern = rf"(<!-- {name} -->\n).*?(<!-- end of {name} -->)"
        page = re.sub(pattern, lambda match, table=table: f"{match[1]}{table}\n{match[2]}", page, flags=re.DOTALL)
    return page


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
