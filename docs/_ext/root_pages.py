"""Pages whose text lives beside the README: contributing, safety and the changelog are written once."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

PAGES = {"contributing": "CONTRIBUTING.md", "safety": "SAFETY.md", "changelog": "CHANGELOG.md"}
"""File at the root for each page of the site."""


def replace_text(app: Sphinx, docname: str, source: list[str]) -> None:
    """Read the file at the root instead of the page's own text; links lead to pages of the site."""
    if docname not in PAGES:
        return
    path = Path(app.srcdir).parent / PAGES[docname]
    app.env.note_dependency(str(path))
    text = path.read_text(encoding="utf-8")
    for page, name in PAGES.items():
        text = text.replace(f"]({name})", f"]({page}.md)")
    source[0] = re.sub(r"\]\(docs/", "](", text)


def setup(app: Sphinx) -> dict[str, Any]:
    """Listen for pages as they are read."""
    app.connect("source-read", replace_text)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
