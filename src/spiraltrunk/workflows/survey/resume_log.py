"""A survey's folder: every trial is logged as a line when it ends, so that an interrupted survey can be resumed."""

from __future__ import annotations

import fcntl
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any, final

from spiraltrunk.errors import SurveyError
from spiraltrunk.files.atomic import atomic_file
from spiraltrunk.workflows.survey.row import check_row

FILES = ("survey.json", "trials.jsonl", "table.md", "rates.png", "heatmap.png")
"""Files of a survey; the plots are written when it is complete."""

_ALLOWED = "allowed: the folder of a survey with the same settings, or a new one"


@final
class Log:
    """Rows of the ended trials, in memory and as lines of a file."""

    def __init__(self, file: IO[str], rows: list[dict[str, Any]]) -> None:
        self._file = file
        self.rows = rows
        """All rows, in the order in which they ended."""

    def add(self, row: dict[str, Any]) -> None:
        """Store a row; it survives a crash."""
        self._file.write(json.dumps(row, allow_nan=False) + "\n")
        self._file.flush()
        self.rows.append(row)


@contextmanager
def open_log(folder: Path, settings: Mapping[str, Any]) -> Iterator[Log]:
    """The folder's log with its rows, locked within the block.

    An incomplete last line is removed. The caller must write ``survey.json`` with its settings at once.

    Raises:
        SurveyError: where the folder holds another survey, or another process is running one in it.
        OSError: where it cannot be written.
    """
    check_settings(folder, settings)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "trials.jsonl"
    with path.open("a+") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise SurveyError(f"--out: a survey is being made in {str(folder)!r}; allowed: another folder") from None
        file.seek(0)
        rows, whole = _read_rows(path, file.read())
        file.truncate(whole)
        yield Log(file, rows)


def check_settings(folder: Path, settings: Mapping[str, Any]) -> None:
    """Refuse a folder that holds another survey.

    Raises:
        SurveyError: with the first setting that differs.
    """
    path = folder / "survey.json"
    try:
        held = json.loads(path.read_text())["settings"]
        differing = [key for key in settings if settings[key] != held[key]]
    except FileNotFoundError:
        if (folder / "trials.jsonl").exists():
            raise SurveyError(f"--out: {str(folder)!r} has trials.jsonl, but no survey.json; {_ALLOWED}") from None
        return
    except (ValueError, TypeError, KeyError):
        raise SurveyError(f"--out: {str(path)!r} is no survey's; {_ALLOWED}") from None
    if differing:
        key = differing[0]
        what = f"a survey with {key} {_short(held[key])}, not {_short(settings[key])}"
        raise SurveyError(f"--out: {str(folder)!r} holds {what}; {_ALLOWED}")


def write_tables(folder: Path, result: Mapping[str, Any], rows: Sequence[Mapping[str, Any]], markdown: str) -> None:
    """Write ``survey.json``, the result with all rows, and ``table.md``, each atomically."""
    with atomic_file(folder / "survey.json") as draft:
        draft.write_text(json.dumps({**result, "rows": list(rows)}, indent=2, allow_nan=False) + "\n")
    with atomic_file(folder / "table.md") as draft:
        draft.write_text(markdown)


def _read_rows(path: Path, text: str) -> tuple[list[dict[str, Any]], int]:
    """Rows of the complete lines, and their size in bytes."""
    lines = text.splitlines(keepends=True)
    if lines and not lines[-1].endswith("\n"):
        lines.pop()
    rows = []
    for number, line in enumerate(lines, start=1):
        try:
            row = dict(json.loads(line))
            check_row(row)
        except (ValueError, TypeError):
            raise SurveyError(f"--out: line {number} of {str(path)!r} is no trial; {_ALLOWED}") from None
        rows.append(row)
    return rows, sum(len(line.encode()) for line in lines)


def _short(value: object, most: int = 120) -> str:
    text = json.dumps(value)
    return text if len(text) <= most else f"{text[:most]}..."
