"""Self-contained HTML pages of texts, tables and pictures, without scripts or links."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from html import escape
from pathlib import Path

from spiraltrunk.files.atomic import write_text

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


def build_heading(text: str) -> str:
    """A section heading."""
    return f"<h2>{escape(text)}</h2>"


def build_paragraphs(texts: Sequence[str]) -> str:
    """One paragraph for each text."""
    return "\n".join(f"<p>{escape(text)}</p>" for text in texts)


def build_list(texts: Sequence[str]) -> str:
    """A list with one item for each text."""
    return "<ul>" + "".join(f"<li>{escape(text)}</li>" for text in texts) + "</ul>"


def build_table(header: Sequence[str], rows: Sequence[Sequence[str]], caption: str) -> str:
    """A table with a caption; all rows are as long as the header."""
    head = "".join(f"<th>{escape(cell)}</th>" for cell in header)
    lines = "\n".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f'<div class="table"><table><caption>{escape(caption)}</caption>\n<tr>{head}</tr>\n{lines}\n</table></div>'


def build_picture(path: Path, text: str) -> str:
    """A PNG embedded in the page, with its alternative text.

    Raises:
        OSError: where it cannot be read.
    """
    data = base64.b64encode(path.read_bytes()).decode()
    return f'<img alt="{escape(text)}" src="data:image/png;base64,{data}">'


def write_page(path: str | Path, title: str, blocks: Sequence[str]) -> Path:
    """Write a page of built blocks atomically; all texts in it are escaped.

    Raises:
        OSError: where it cannot be written.
    """
    body = "\n".join(blocks)
    write_text(
        path,
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>{escape(title)}</title>\n'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">\n<style>{_STYLE}</style>\n</head>\n'
        f"<body>\n<h1>{escape(title)}</h1>\n{body}\n</body>\n</html>\n",
    )
    return Path(path)
