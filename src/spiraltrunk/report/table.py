"""Plain-text tables for the terminal."""

from __future__ import annotations

from collections.abc import Sequence


def format_table(rows: Sequence[Sequence[str]], *, header: Sequence[str] = (), title: str = "", indent: int = 0) -> str:
    """Rows in aligned columns, one line each, without a line break at the end.

    Args:
        rows: equally many texts each; a row of one empty text is a blank line.
        header: texts above the columns, underlined.
        title: line above the table.
        indent: blanks before each row.
    """
    lines = [[" ".join(cell.split()) for cell in row] for row in ([header] if header else []) + list(rows)]
    columns = zip(*(line for line in lines if line != [""]), strict=True)
    widths = [max(map(len, column)) for column in columns]
    if header:
        lines.insert(1, ["-" * width for width in widths])
    cells = [[cell.ljust(width) for cell, width in zip(line, widths, strict=False)] for line in lines]
    return "\n".join([title] * bool(title) + [(" " * indent + "  ".join(line)).rstrip() for line in cells])
