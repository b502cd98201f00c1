"""Puts the trials of study_robustness.py into validation/robustness.md and README.md: rates, and failures by cause.

`python docs/studies/study_robustness.py --out FOLDER` runs the trials. Then
`python docs/studies/make_robustness.py FOLDER`. Without a folder the pages are made from robustness.json.

`python docs/studies/make_robustness.py --survey CONDITION FOLDER` puts a survey in the place of a condition's trials,
as of `spiraltrunk survey --friction 0.15 --trials 50 --out FOLDER`. `--replace FOLDER` replaces the trials of each
condition and strategy that study_robustness.py ran into the folder, and keeps all others.
"""

from __future__ import annotations

import json
import re
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

from study_robustness import CONDITIONS, load_rows

from spiraltrunk import strategies
from spiraltrunk.files.atomic import write_text
from spiraltrunk.workflows.survey.summary import count_causes, count_rate

STUDIES = Path(__file__).parent
RESULT = STUDIES / "robustness.json"
PAGE = STUDIES.parent / "validation" / "robustness.md"
README = STUDIES.parents[1] / "README.md"

FRICTION = "friction 0.15"
"""Condition that stands in README.md beside the preset."""

KEPT = ("condition", "strategy", "object", "index", "seed", "success", "reason", "cause", "source")
"""What is kept of a row."""


def main(folders: Sequence[str]) -> int:
    """Count, and fill both pages."""
    if len(folders) == 3 and folders[0] == "--survey":
        replace_condition(folders[1], Path(folders[2]))
        folders = ()
    if len(folders) == 2 and folders[0] == "--replace":
        refused = replace_strategies(Path(folders[1]))
        if refused is not None:
            print(f"make_robustness: {refused}; allowed: a folder with as many trials or more", file=sys.stderr)
            return 2
        folders = ()
    if len(folders) > 1:
        print("make_robustness: given several folders; allowed: one, of study_robustness.py's trials", file=sys.stderr)
        return 2
    if folders:
        lines = (Path(folders[0]) / "trials.jsonl").read_text().splitlines()
        write_text(RESULT, format_rows([json.loads(line) for line in lines]))
    rows, rates = load_figures()
    write_text(PAGE, fill_page(PAGE.read_text(), rows))
    write_text(README, fill_readme(README.read_text(), rows, rates))
    return 0


def replace_condition(condition: str, folder: Path) -> None:
    """Put the trials of a survey into robustness.json in the place of a condition's."""
    source = json.loads((folder / "survey.json").read_text())["settings"]["source"]
    trials = [json.loads(line) for line in (folder / "trials.jsonl").read_text().splitlines()]
    kept = [row for row in json.loads(RESULT.read_text())["rows"] if row["condition"] != condition]
    new = [{"condition": condition, "source": source, **row} for row in trials]
    write_text(RESULT, format_rows([*kept, *new]))


def replace_strategies(folder: Path) -> str | None:
    """Replace the trials in robustness.json of each condition and strategy that occurs in a folder's.

    Returns:
        why nothing was replaced: the folder has no trials, or fewer than there are of a condition and strategy; else
        None.
    """
    new, rows = load_rows(folder / "trials.jsonl"), json.loads(RESULT.read_text())["rows"]
    if not new:
        return f"{folder} has no trials"
    counts, old = (Counter((row["condition"], row["strategy"]) for row in each) for each in (new, rows))
    short = [f"{name}, {condition}" for (condition, name), count in counts.items() if count < old[condition, name]]
    if short:
        return f"{folder} has fewer trials than there are of {'; '.join(short)}"
    kept = [row for row in rows if (row["condition"], row["strategy"]) not in counts]
    write_text(RESULT, format_rows([*kept, *new]))
    return None


def load_figures() -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Rows of the trials, and the counts of the preset in validation/strategies.md by strategy."""
    rates = json.loads((STUDIES / "strategies.json").read_text())["strategies"]
    return json.loads(RESULT.read_text())["rows"], rates


def format_rows(rows: Sequence[dict[str, Any]]) -> str:
    """Rows as JSON, one on each line, by condition, strategy and number."""
    order = list(CONDITIONS)
    kept = sorted(rows, key=lambda row: (order.index(row["condition"]), _number(row["strategy"]), row["index"]))
    lines = ",\n".join(json.dumps({key: row[key] for key in KEPT}) for row in kept)
    return f'{{"rows": [\n{lines}\n]}}\n'


def fill_page(page: str, rows: Sequence[dict[str, Any]]) -> str:
    """The page with its three tables made anew."""
    for name, table in (
        ("conditions", format_conditions(rows)), ("rates", format_rates(rows)), ("failures", format_failures(rows)),
    ):  # fmt: skip
        page = put_section(page, name, table)
    return page


def fill_readme(text: str, rows: Sequence[dict[str, Any]], rates: dict[str, Any]) -> str:
    """README with the rates without friction and with it, each with its Wilson interval."""
    lines = ["| strategy | without friction | cable friction 0.15 |", "|---|---|---|"]
    for name in sorted(strategies.NAMES, key=_number):
        rubbed = count_rate([row for row in rows if (row["condition"], row["strategy"]) == (FRICTION, name)])
        lines.append(f"| {_number(name)} `{name}` | {_format_rate(rates[name])} | {_format_rate(rubbed)} |")
    return put_section(text, "strategies", "\n".join(lines))


def format_conditions(rows: Sequence[dict[str, Any]]) -> str:
    """All strategies together, by condition."""
    lines = ["| condition | succeeded (95 % interval) | failures by cause |", "| --- | --- | --- |"]
    for condition in _conditions(rows):
        own = [row for row in rows if row["condition"] == condition]
        causes = "; ".join(f"{count} x {cause}" for cause, count in count_causes(own).items())
        lines.append(f"| {condition} | {_format_rate(count_rate(own))} | {causes or '-'} |")
    return "\n".join(lines)


def format_rates(rows: Sequence[dict[str, Any]]) -> str:
    """Successes of trials by strategy and condition."""
    conditions = _conditions(rows)
    lines = [f"| strategy | {' | '.join(conditions)} |", f"| --- |{' --- |' * len(conditions)}"]
    for name in sorted(strategies.NAMES, key=_number):
        cells = []
        for condition in conditions:
            rate = count_rate([row for row in rows if (row["condition"], row["strategy"]) == (condition, name)])
            cells.append(f"{rate['successes']} of {rate['trials']}" if rate["trials"] else "-")
        lines.append(f"| `{name}` | {' | '.join(cells)} |")
    return "\n".join(lines)


def format_failures(rows: Sequence[dict[str, Any]]) -> str:
    """Every failed trial, to be repeated by `spiraltrunk grasp` with its seed."""
    lines = ["| condition | strategy | object | seed | cause | reason |", "| --- | --- | --- | --- | --- | --- |"]
    for row in rows:
        if not row["success"]:
            told = (row["condition"], f"`{row['strategy']}`", f"`{row['object']}`", row["seed"], row["cause"])
            lines.append(f"| {' | '.join(map(str, told))} | {row['reason'].replace('|', '/')} |")
    return "\n".join(lines)


def put_section(page: str, name: str, text: str) -> str:
    """The page with what stands between a section's two comments replaced."""
    pattern = rf"(<!-- {name} -->\n).*?(<!-- end of {name} -->)"
    return re.sub(pattern, lambda match: f"{match[1]}{text}\n{match[2]}", page, flags=re.DOTALL)


def _format_rate(rate: dict[str, Any]) -> str:
    if not rate["trials"]:
        return "-"
    return f"{rate['successes']} of {rate['trials']} ({100 * rate['low']:.0f}-{100 * rate['high']:.0f} %)"


def _conditions(rows: Sequence[dict[str, Any]]) -> list[str]:
    return list(dict.fromkeys(row["condition"] for row in rows))


def _number(name: str) -> int:
    return strategies.get(name).number


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
