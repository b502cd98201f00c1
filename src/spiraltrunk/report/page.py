"""Self-contained HTML pages of texts, tables and pictures, without scripts or links."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import final

from spiraltrunk.files.atomic import atomic_file

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #222; max-width: 1060px; margin: 2em auto; padding: 0 1em; }
h1 { font-size: 1.5em; } h2 { font-size: 1.15em; margin-top: 2em; }
img { max-width: 100%; display: block; margin: .6em 0; }
div.table { overflow-x: auto; }
table { border-collapse: collapse; margin: .8em 0; }
th, td { padding: .25em .8em; border-bottom: 1px solid #ddd; text-align: left; vertical-align: top; }
td:not(:first-child), th:not(:first-child) { text-align: right; font-variant-numeric: tabular-nums; }
caption { text-align: left; color: #555; padding-bottom: .3em; }
ul { padding-left: 1.2em; overflow-wrap: anywhere; } p.note { color: #555; }
@media (max-width: 600px) { body { margin: 1em auto; } table { font-size: .8em; } th, td { padding: .2em .35em; } }
"""


@final
@dataclass(frozen=True, kw_only=True)
class Heading:
    """A section heading."""

    text: str
    """Its text."""


@final
@dataclass(frozen=True, kw_only=True)
class Paragraphs:
    """Paragraphs, or items of a list."""

    texts: tuple[str, ...]
    """Text of each."""
    is_list: bool = False
    """Whether they are items of a list."""


@final
@dataclass(frozen=True, kw_only=True)
class Table:
    """A table; all rows are as long as the header."""

    header: tuple[str, ...]
    """Names of the columns."""
    rows: tuple[tuple[str, ...], ...]
    """Cells."""
    caption: str = ""
    """Its caption."""


@final
@dataclass(frozen=True, kw_only=True)
class Picture:
    """A PNG that is embedded in the page."""

    path: Path
    """Its file."""
    text: str
    """Alternative text."""


Block = Heading | Paragraphs | Table | Picture


def write_page(path: str | Path, title: str, blocks: Sequence[Block]) -> Path:
    """Write the page atomically.

    Raises:
        OSError: where it cannot be written or a picture not be read.
    """
    text = format_page(title, blocks)
    with atomic_file(path) as draft:
        draft.write_text(text, encoding="utf-8")
    return Path(path)


def format_page(title: str, blocks: Sequence[Block]) -> str:
    """The page as text; all texts are escaped."""
    body = "\n".join(_format(block) for block in blocks)
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>{escape(title)}</title>\n'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">\n<style>{_STYLE}</style>\n</head>\n'
        f"<body>\n<h1>{escape(title)}</h1>\n{body}\n</body>\n</html>\n"
    )


def _format(block: Block) -> str:
    if isinstance(block, Heading):
        return f"<h2>{escape(block.text)}</h2>"
    if isinstance(block, Paragraphs):
        if block.is_list:
            return "<ul>" + "".join(f"<li>{escape(text)}</li>" for text in block.texts) + "</ul>"
        return "\n".join(f"<p>{escape(text)}</p>" for text in block.texts)
    if isinstance(block, Picture):
        data = base64.b64encode(block.path.read_bytes()).decode()
        return f'<img alt="{escape(block.text)}" src="data:image/png;base64,{data}">'
    caption = f"<caption>{escape(block.caption)}</caption>" if block.caption else ""
    head = "".join(f"<th>{escape(cell)}</th>" for cell in block.header)
    rows = "\n".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in block.rows)
    return f'<div class="table"><table>{caption}\n<tr>{head}</tr>\n{rows}\n</table></div>'
