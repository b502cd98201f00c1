"""A survey's folder: every trial is logged as a line when it ends, so that an interrupted survey can be resumed."""

from __future__ import annotations

import errno
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from io import FileIO
from pathlib import Path
from typing import Any, NoReturn, final

from spiraltrunk.errors import OutputError, SurveyError
from spiraltrunk.files.atomic import write_text
from spiraltrunk.files.output_folder import OutputFolder
from spiraltrunk.workflows.survey.row import check_row, fill_row

WRITER = "survey"
"""Name of the command in output folders."""

FILES = ("survey.json", "trials.jsonl", "table.md", "rates.png", "heatmap.png", "causes.png")
"""Files of a survey; the plots are written when it is complete."""

_ALLOWED = "allowed: the folder of a survey with the same settings, or a new one"

_HEAD = b'{"strategy": "'
"""How each line of the log begins."""


@final
class Log:
    """Rows of the ended trials, in memory and as lines of a file."""

    def __init__(self, file: FileIO, rows: list[dict[str, Any]]) -> None:
        self._file = file
        self.rows = rows
        """All rows, in the order in which they ended."""

    def add(self, row: dict[str, Any]) -> None:
        """Store a row; it survives a crash.

        Raises:
            OutputError: where it cannot be written.
        """
        line = json.dumps(row, allow_nan=False).encode() + b"\n"
        try:
            if self._file.write(line) != len(line):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        except OSError as error:
            allowed = "allowed: a place that can be written"
            raise OutputError(f"{str(self._file.name)!r} cannot be written: {error.strerror}; {allowed}") from error
        self.rows.append(row)


@contextmanager
def open_log(output: OutputFolder, settings: Mapping[str, Any]) -> Iterator[Log]:
    """The folder's log with its rows.

    A last line that a crash cut off is removed. The caller must write ``survey.json`` with its settings at once.

    Raises:
        SurveyError: where the folder holds another survey, or a line of the log is none of its trials.
        OSError: where it cannot be written.
    """
    check_settings(output.path, settings)
    path = output.add_log("trials.jsonl")
    with path.open("a+b", buffering=0) as file:
        file.seek(0)
        rows, whole = read_rows(path, file.readall(), settings)
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
        differing = [key for key in settings if settings[key] != held.get(key)]
    except FileNotFoundError:
        log = folder / "trials.jsonl"
        if log.exists() and log.stat().st_size > 0:  # An empty one is of a command that was killed as it began.
            raise SurveyError(f"--out: {str(folder)!r} has trials.jsonl, but no survey.json; {_ALLOWED}") from None
        return
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        raise SurveyError(f"--out: {str(path)!r} is no survey's; {_ALLOWED}") from None
    if differing:
        key = differing[0]
        what = _describe_difference(key, held.get(key), settings[key])
        raise SurveyError(f"--out: {str(folder)!r} holds a survey {what}; {_ALLOWED}")


def _describe_difference(key: str, held: Any, asked: Any) -> str:
    """What distinguishes the survey of the folder by this setting."""
    if key == "design":
        return "of another design"
    if key == "objects" and isinstance(held, dict) and held.keys() != asked.keys():
        return f"of the strategies {', '.join(held)}, not {', '.join(asked)}"
    if key == "files" and isinstance(held, dict):
        return f"with another content of {_short([name for name in asked if held.get(name) != asked[name]])}"
    return f"with {key} {_short(held)}, not {_short(asked)}"


def write_tables(
    output: OutputFolder, result: Mapping[str, Any], rows: Sequence[Mapping[str, Any]], markdown: str
) -> None:
    """Write ``survey.json``, the result with all rows, and ``table.md``.

    Raises:
        OutputError: where a file cannot be written or must not be replaced.
    """
    text = json.dumps({**result, "rows": list(rows)}, indent=2, allow_nan=False)
    with output.draft(is_partial=True) as draft:
        write_text(draft / "survey.json", text + "\n")
        write_text(draft / "table.md", markdown)


def read_rows(
    path: Path, data: bytes, settings: Mapping[str, Any], option: str = "--out"
) -> tuple[list[dict[str, Any]], int]:
    """Rows of the complete lines, and their size in bytes.

    Raises:
        SurveyError: where a line is no trial of the survey; it names the option that named the folder.
    """
    lines = data.split(b"\n")
    torn = lines.pop()
    rows: list[dict[str, Any]] = []
    seen: set[tuple[str, int]] = set()
    for number, line in enumerate(lines, start=1):
        try:
            row = fill_row(dict(json.loads(line.decode(), parse_constant=_refuse_constant)))
            check_row(row, settings)
            if (row["strategy"], row["index"]) in seen:
                raise ValueError("there twice")
        except (ValueError, TypeError, OverflowError, RecursionError):
            raise SurveyError(f"{option}: line {number} of {str(path)!r} is no trial; {_ALLOWED}") from None
        seen.add((row["strategy"], row["index"]))
        rows.append(row)
    if not (_HEAD.startswith(torn) or (torn.startswith(_HEAD) and torn.isascii() and torn.decode().isprintable())):
        raise SurveyError(f"{option}: the last line of {str(path)!r} is no trial; {_ALLOWED}")
    return rows, len(data) - len(torn)


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is no JSON")


def _short(value: object, most: int = 120) -> str:
    text = json.dumps(value)
    return text if len(text) <= most else f"{text[:most]}..."
