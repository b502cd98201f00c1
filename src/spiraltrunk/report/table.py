"""Plain-text tables for the terminal."""

from __future__ import annotations

from collections.abc import Sequence

from spiraltrunk.errors import ShapeError


def format_table(
    rows: Sequence[Sequence[str]], *, header: Sequence[str] = (), title: str = "", gap: int = 2, indent: int = 0
) -> str:
    """Rows in aligned columns, one line each, without a line break at the end.

    Args:
        rows: texts of each row, equally many: two for names and values. A row of one empty text is a blank line.
        header: texts over the columns, underlined.
        title: line above it all.
        gap: blanks between columns.
        indent: blanks before each row.

    Raises:
        ShapeError: where rows have different numbers of columns.
    """
    lines = [[" ".join(cell.split()) for cell in row] for row in ([header] if header else []) + list(rows)]
    full = [line for line in lines if line != [""]]
    n_column = len(full[0]) if full else 0
    for line in full:
        if len(line) != n_column:
            raise ShapeError(f"row {line} has {len(line)} columns; allowed: {n_column}, as the first")
    widths = [max(len(line[column]) for line in full) for column in range(n_column)]
    if header:
        lines.insert(1, ["-" * width for width in widths])
    texts = [title] if title else []
    for line in lines:
        cells = [cell.ljust(width) for cell, width in zip(line, widths, strict=False)]
        texts.append((" " * indent + (" " * gap).join(cells)).rstrip())
    return "\n".join(texts)
