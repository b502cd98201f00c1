"""Docstrings are plain text with code in backticks: ``|``, ``*`` and a trailing ``_`` stand for themselves."""

from __future__ import annotations

import re
from typing import Any

from sphinx.application import Sphinx

_CODE = re.compile(r"(``.*?``|`[^`]*`_{0,2})")
_MARKUP = re.compile(r"[|*]|(?<=\w)_(?=\W|$)")


def escape(*event: Any) -> None:
    """Escape what reStructuredText would read as markup, literal blocks left as they are; the lines come last."""
    lines: list[str] = event[-1]
    if "Fields:" in lines:  # What `help` shows; here each field has an entry of its own.
        del lines[lines.index("Fields:") :]
    margin: int | None = None
    before = ""
    for i, line in enumerate(lines):
        if not line.strip():
            continue
        indent = len(line) - len(line.lstrip())
        if margin is not None and indent <= margin:
            margin = None
        if margin is None and before.endswith("::") and indent > len(before) - len(before.lstrip()):
            margin = len(before) - len(before.lstrip())
        before = line.rstrip()
        if margin is None:
            parts = _CODE.split(line)
            parts[::2] = [_MARKUP.sub(r"\\\g<0>", part) for part in parts[::2]]
            lines[i] = "".join(parts)


def setup(app: Sphinx) -> dict[str, Any]:
    """Come before napoleon, which adds markup of its own."""
    app.connect("autodoc-process-docstring", escape, priority=400)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
