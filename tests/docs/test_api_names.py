"""Every module and name that an API page lists exists: what the site's build would otherwise find out late."""

from __future__ import annotations

import importlib
from pathlib import Path

import pytest

PAGES = sorted((Path(__file__).parents[2] / "docs" / "reference" / "api").glob("*.rst"))


def list_names(page: Path) -> list[tuple[str, str]]:
    """Module and name of each entry of the page's directives; an empty name for a module alone."""
    found, module = [], ""
    for line in page.read_text().splitlines():
        if line.startswith(".. public-module::"):
            module = line.partition("::")[2].strip()
            found.append((module, ""))
        elif module and line.startswith("   ") and line.strip():
            found.append((module, line.strip()))
        elif line.strip():
            module = ""
    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_names_exist(page: Path) -> None:
    missing = []
    for module, name in list_names(page):
        try:
            loaded = importlib.import_module(module)
        except ModuleNotFoundError:
            missing.append(module)
            continue
        if name and not hasattr(loaded, name):
            missing.append(f"{module}.{name}")
    assert missing == []
