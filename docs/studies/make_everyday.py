"""Puts the study of everyday things into validation/everyday.md: two galleries and the tables.

`python docs/studies/study_everyday.py --out FOLDER` makes everyday.json, and the pictures in FOLDER,
`rank_everyday.py` makes everyday_ranking.json, `everyday_rates.py` everyday_rates.json. Then
`python docs/studies/make_everyday.py --rules FOLDER`. Without a folder the tables alone are made, without ``--rules``
the limits of the designs stay as they are in the page.
"""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

from everyday_rates import format_choice, format_rates, format_scores, load_rates
from everyday_rules import compute_rules
from PIL import Image, ImageDraw

from spiraltrunk.design import presets
from spiraltrunk.files.atomic import atomic_file, write_text
from spiraltrunk.report.style import COLORS, INK, LIMIT
from spiraltrunk.report.trial.filmstrip import load_font, wrap_caption

STUDIES = Path(__file__).parent
PAGE = STUDIES.parent / "validation" / "everyday.md"
IMAGES = STUDIES.parent / "images"

DESIGNS = ("paper", "paper-large-grip")
COLUMNS, WIDTH, HEIGHT, GAP, LETTER = 5, 260, 220, 12, 14
"""Columns of a gallery; width and height of a picture, gap and letters [pixels]."""

GREY = "#666666"
MARKS = {
    "held": ("\N{CHECK MARK}", COLORS[0]),
    "failed": ("\N{BALLOT X}", LIMIT),
    "refused": ("\N{EN DASH}", GREY),
    "untried": ("?", GREY),
}
"""Mark and colour of each outcome; words say the same."""

FAMILIES = {
    "wraps": ("wrap-oblique-low", "wrap-oblique", "wrap-horizontal"),
    "fingers": ("pinch", "tip-grip", "flip-grip"),
}
"""Names of strategies that are often of one opinion."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What became of a thing with a design."""

    kind: str
    """Of the first world, which the gallery shows: held, failed or refused."""
    words: str
    """The same in words, with the counts of all worlds."""
    strategies: str
    """Strategies that the first world's trial tried, in order."""


def main(arguments: Sequence[str]) -> int:
    """Fill the page, and draw the galleries where there are pictures."""
    folders = [each for each in arguments if each != "--rules"]
    if len(folders) > 1:
        print("make_everyday: given several folders; allowed: one, of study_everyday.py's pictures", file=sys.stderr)
        return 2
    if folders and not Path(folders[0]).is_dir():
        print(f"make_everyday: given {folders[0]!r}; allowed: --rules, and a folder that exists", file=sys.stderr)
        return 2
    figures = load_figures()
    rules = {design: compute_rules(presets.get(design)) for design in DESIGNS} if "--rules" in arguments else None
    write_text(PAGE, fill_page(PAGE.read_text(), figures, rules))
    for design in DESIGNS if folders else ():
        draw_gallery(figures, design, Path(folders[0]), IMAGES / f"everyday_{design.replace('-', '_')}.png")
    return 0


def load_figures() -> dict[str, Any]:
    """Things, rows of trials, and the ranking of each thing for each design."""
    ranking = json.loads((STUDIES / "everyday_ranking.json").read_text())
    return json.loads((STUDIES / "everyday.json").read_text()) | {"ranking": ranking, "rates": load_rates()}


def fill_page(page: str, figures: dict[str, Any], rules: Mapping[str, Mapping[str, str]] | None = None) -> str:
    """The page with what stands between its sections' comments made from the figures and, where given, the rules."""
    tables = {
        "counts": format_counts(figures),
        "outcomes": format_outcomes(figures),
        "refusals": format_refusals(figures),
        "rates": format_rates(figures["rates"]),
        "choice": format_choice(figures["rates"]),
        "scores": format_scores(figures["rates"]),
    } | ({} if rules is None else {"rules": format_rules(rules)})
    for name, text in tables.items():
        pattern = rf"(<!-- {name} -->\n).*?(<!-- end of {name} -->)"
        page = re.sub(pattern, lambda match, text=text: f"{match[1]}{text}\n{match[2]}", page, flags=re.DOTALL)
    return page


def format_rules(rules: Mapping[str, Mapping[str, str]]) -> str:
    """Limits of each design, by what they limit."""
    lines = [f"| limit | {' | '.join(f'`{design}`' for design in rules)} |", f"|---{'|---' * len(rules)}|"]
    first = next(iter(rules.values()))
    return "\n".join([*lines, *(f"| {name} | {' | '.join(each[name] for each in rules.values())} |" for name in first)])


def find_rows(figures: dict[str, Any], design: str, thing: str | None = None) -> list[dict[str, Any]]:
    """Trials with a design, of one thing or of all."""
    return [row for row in figures["rows"] if row["design"] == design and thing in (None, row["thing"])]


def judge(rows: Sequence[dict[str, Any]]) -> Outcome | None:
    """Outcome of a thing with a design; None where no trial was made."""
    if not rows:
        return None
    first, held = rows[0], sum(row["success"] for row in rows)
    tried = ", then ".join(each["strategy"] for each in first.get("attempts", ()))
    if first["cause"] == "refused":
        return Outcome(kind="refused", words="refused", strategies="")
    if held == len(rows):
        return Outcome(kind="held", words=f"held and set down, {held} of {len(rows)}", strategies=tried)
    causes = ", ".join(dict.fromkeys(_name_cause(row) for row in rows if not row["success"]))
    kind = "held" if first["success"] else "failed"
    return Outcome(kind=kind, words=f"{held} of {len(rows)} succeeded, else {causes}", strategies=tried)


def _name_cause(row: dict[str, Any]) -> str:
    cause = str(row["cause"])
    return f"{cause} after the hold" if row["held"] and cause != "arm's limit" else cause


def format_counts(figures: dict[str, Any]) -> str:
    """Of each design: things, trials, outcomes."""
    lines = [
        "| design | ground [m] | objects taken on | trials of them | held and set down | held | objects refused |",
        "|---|---|---|---|---|---|---|",
    ]
    for design in DESIGNS:
        rows = find_rows(figures, design)
        moved = [row for row in rows if row["cause"] != "refused"]
        counts = (
            len({row["thing"] for row in moved}), len(moved), sum(row["success"] for row in moved),
            sum(row["held"] for row in moved), len(rows) - len(moved),
        )  # fmt: skip
        ground = "-" if not rows else f"{rows[0]['ground_m']:.2f}"
        lines.append(f"| `{design}` | {ground} | {' | '.join(str(count) for count in counts)} |")
    return "\n".join(lines)


def format_outcomes(figures: dict[str, Any]) -> str:
    """Thing by thing: what became of it with each design."""
    lines = [f"| object | mm | {' | '.join(f'`{design}`' for design in DESIGNS)} |", "|---|---|---|---|"]
    for thing in figures["things"]:
        cells = [_format_outcome(predict(figures, design, thing["name"])) for design in DESIGNS]
        lines.append(f"| {thing['name']} | {thing['measures']} | {' | '.join(cells)} |")
    return "\n".join(lines)


def predict(figures: dict[str, Any], design: str, thing: str) -> Outcome:
    """Outcome of a thing with a design; where it was not tried, what the models say."""
    outcome = judge(find_rows(figures, design, thing))
    if outcome is not None:
        return outcome
    if any(each["feasible"] for each in figures["ranking"][design][thing]):
        return Outcome(
            kind="untried", words="not tried yet; the models would try", strategies=best(figures, design, thing)
        )
    return Outcome(kind="refused", words="refused", strategies="")


def best(figures: dict[str, Any], design: str, thing: str) -> str:
    """The strategy that the models rank first."""
    return str(figures["ranking"][design][thing][0]["strategy"])


def _format_outcome(outcome: Outcome) -> str:
    return f"{MARKS[outcome.kind][0]} {outcome.words}" + (f" ({outcome.strategies})" if outcome.strategies else "")


def format_refusals(figures: dict[str, Any]) -> str:
    """Thing by thing: why a strategy of each design cannot take it."""
    lines = [f"| object | {' | '.join(f'`{design}`' for design in DESIGNS)} |", "|---|---|---|"]
    for thing in figures["things"]:
        cells = [_format_reasons(figures["ranking"][design][thing["name"]]) for design in DESIGNS]
        lines.append(f"| {thing['name']} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _format_reasons(candidates: Iterable[dict[str, Any]]) -> str:
    """Reasons of the infeasible candidates, each with the strategies that give it."""
    by: dict[str, list[str]] = {}
    for each in candidates:
        if not each["feasible"]:
            by.setdefault(each["reason"].replace("|", "/"), []).append(each["strategy"])
    return "<br>".join(f"{_name_family(names)}: {reason}" for reason, names in by.items()) or "all can"


def _name_family(names: list[str]) -> str:
    for family, members in FAMILIES.items():
        if sorted(names) == sorted(members):
            return family
    return ", ".join(names)


def draw_gallery(figures: dict[str, Any], design: str, folder: Path, path: Path) -> None:
    """One picture of each thing: name, measures, strategy and outcome under it."""
    shown = [(thing, find_rows(figures, design, thing["name"])) for thing in figures["things"]]
    shown = [(thing, rows) for thing, rows in shown if rows and (folder / name_picture(rows[0])).exists()]
    rows_down, pitch = math.ceil(len(shown) / COLUMNS), HEIGHT + 7 * LETTER
    sheet = Image.new("RGB", (GAP + COLUMNS * (WIDTH + GAP), GAP + rows_down * (pitch + GAP)), "white")
    for i, (thing, rows) in enumerate(shown):
        at = GAP + i % COLUMNS * (WIDTH + GAP), GAP + i // COLUMNS * (pitch + GAP)
        with Image.open(folder / name_picture(rows[0])) as picture:
            sheet.paste(picture.convert("RGB").resize((WIDTH, HEIGHT), Image.LANCZOS), at)
        draw_caption(ImageDraw.Draw(sheet), at, thing, rows)
    with atomic_file(path) as draft:
        sheet.quantize(colors=160, dither=Image.Dither.NONE).save(draft, format="png", optimize=True)


def draw_caption(draw: ImageDraw.ImageDraw, at: tuple[int, int], thing: dict[str, Any], rows: list[Any]) -> None:
    """Name, measures, strategies and outcome below the picture at ``at`` [pixels], and a border for a failure."""
    outcome, font, (left, top) = judge(rows), load_font(LETTER), at
    assert outcome is not None
    mark, color = MARKS[outcome.kind]
    head = wrap_caption(f"{thing['name']}, {thing['measures']}", font, WIDTH)
    draw.multiline_text((left, top + HEIGHT + 4), head, font=font, fill=INK)
    below = top + HEIGHT + 6 + round(1.25 * LETTER) * (1 + head.count("\n"))
    words = wrap_caption(
        f"{mark} {outcome.words}" + (f": {outcome.strategies}" * bool(outcome.strategies)), font, WIDTH
    )
    draw.multiline_text((left, below), words, font=font, fill=color)
    draw.rectangle((left - 2, top - 2, left + WIDTH + 1, top + HEIGHT + 1), outline=color, width=2)


def name_picture(row: dict[str, Any]) -> str:
    """File of a row's picture."""
    return f"{row['design']} {row['thing']} {row['seed']}.png".replace(",", "").replace(" ", "-")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
