"""CONTRIBUTING.md and the page on the architecture name every folder of the package, and no other."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "src" / "spiraltrunk"


def read_rows(page: str) -> list[list[str]]:
    """Cells of the rows of the tables whose first cell is code."""
    lines = (ROOT / page).read_text().splitlines()
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| `")]


def list_folders(folder: Path) -> set[str]:
    return {path.parent.name for path in folder.glob("*/__init__.py")}


def test_contributing_names_every_folder_and_its_folders() -> None:
    named = {}
    for first, _, holds in read_rows("CONTRIBUTING.md"):
        for name in re.findall(r"`([\w.]+)/?`", first):
            named[name] = set(re.findall(r"`([\w/]+)/`", holds))
    modules = {name for name in named if name.endswith(".py")}
    assert all((PACKAGE / name).is_file() for name in modules)
    assert set(named) - modules == list_folders(PACKAGE)
    for name in set(named) - modules:
        assert all((PACKAGE / name / each).is_dir() for each in named[name])
        assert list_folders(PACKAGE / name) <= named[name]


def test_the_page_on_the_architecture_names_every_folder() -> None:
    named = {name for first, *_ in read_rows("docs/concepts/architecture.md") for name in re.findall(r"`(\w+)`", first)}
    assert named == list_folders(PACKAGE)
