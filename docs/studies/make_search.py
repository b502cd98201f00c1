"""Puts a search for a trunk into validation/trunk_search.md, with its figures.

`spiraltrunk optimize --out FOLDER ...` searches, `python docs/studies/study_search_fingers.py FOLDER` tries the preset
with large fingers in the same worlds. Then `python docs/studies/make_search.py FOLDER`. Without a folder the page is
made from search.json.
"""

from __future__ import annotations

import json
import re
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from spiraltrunk.files.atomic import write_text
from spiraltrunk.files.results import format_json
from spiraltrunk.workflows.optimize.search_space import SPACE
from spiraltrunk.workflows.optimize.tables import format_markdown

STUDIES = Path(__file__).parent
RESULT = STUDIES / "search.json"
FINGERS = STUDIES / "search_fingers.json"
PAGE = STUDIES.parent / "validation" / "trunk_search.md"
IMAGES = STUDIES.parent / "images"


def main(folders: Sequence[str]) -> int:
    """Fill the page."""
    if len(folders) > 1:
        print("make_search: given several folders; allowed: one, of spiraltrunk optimize", file=sys.stderr)
        return 2
    if folders:
        folder = Path(folders[0])
        write_text(RESULT, format_json(json.loads((folder / "optimize.json").read_text())) + "\n")
        for name in ("history", "front"):
            shutil.copyfile(folder / f"{name}.png", IMAGES / f"search_{name}.png")
    result = json.loads(RESULT.read_text())
    page = PAGE.read_text()
    fingers = json.loads(FINGERS.read_text())
    texts = {
        "settings": format_settings(result), "space": format_space(), "table": format_table(result),
        "fingers": format_fingers(fingers, result["best"]), "former": format_former(fingers["former"]),
    }  # fmt: skip
    for name, text in texts.items():
        page = put_section(page, name, text)
    write_text(PAGE, page)
    return 0


def format_settings(result: dict[str, Any]) -> str:
    """What was searched, in a sentence."""
    own = result["settings"]
    tried = [each for each in result["candidates"] if not each["faults"]]
    unseen = result["unseen"]["paper"]["trials"] if result["unseen"] else 0
    return (
        f"{len(result['candidates'])} candidates, {len(tried)} of them printable; {own['objects']} objects each, "
        f"strategy `{own['strategy']}`, cable friction {own['friction']:g}, seed {own['seed']}; "
        f"{unseen} unseen objects."
    )


def format_space() -> str:
    """The parameters and their ranges."""
    rows = [f"| `{each.name}` | {each.what} | {each.least:g} to {each.most:g} | {each.first:g} |" for each in SPACE]
    return "\n".join(["| parameter | what it is | range | authors' robot |", "| --- | --- | --- | --- |", *rows])


def format_table(result: dict[str, Any]) -> str:
    """All candidates, and the comparison."""
    return format_markdown(result).rstrip("\n")


def format_fingers(fingers: dict[str, Any], best: int) -> str:
    """The preset with large fingers beside the preset ``paper`` and the best candidate."""
    return (
        f"In the same worlds the preset `{fingers['design']}` takes {_format_count(fingers)}. It differs from the "
        f"preset `paper` by {_format_difference(fingers['paper'])}, and candidate {best} differs from it by "
        f"{_format_difference(fingers['best'])}."
    )


def format_former(former: dict[str, Any]) -> str:
    """The best trunk of a search before beside the preset ``paper``."""
    return (
        f"In the same worlds the best trunk of the search before takes {_format_count(former)}. It differs from the "
        f"preset `paper` by {_format_difference(former['paper'])}."
    )


def _format_count(counted: dict[str, Any]) -> str:
    low, high = (f"{100 * counted[key]:.0f}" for key in ("low", "high"))
    return f"{counted['successes']} of {counted['trials']} ({low} to {high} %)"


def _format_difference(paired: dict[str, Any]) -> str:
    low, high, difference = (f"{100 * paired[key]:+.0f}" for key in ("low", "high", "difference"))
    return f"{difference} % ({low} to {high} %, paired, p = {paired['p']:.2g})"


def put_section(page: str, name: str, text: str) -> str:
    """The page with what stands between a section's two comments replaced."""
    pattern = rf"(<!-- {name} -->\n).*?(<!-- end of {name} -->)"
    return re.sub(pattern, lambda match: f"{match[1]}{text}\n{match[2]}", page, flags=re.DOTALL)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
