"""Output of a command: exit code, text on standard output, lines on standard error."""

from __future__ import annotations

import argparse
import os
import sys
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryFile

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
"""Exit codes; a command ended by a signal has 128 plus the signal's number."""

Answer = tuple[int, str]
"""Exit code and text for standard output."""

_LONGEST_LINE = 700


class UsageError(Exception):
    """Arguments that cannot be combined or used."""


def put(code: int, text: str) -> int:
    """Print the text and return the code; a closed pipe is no error, a full disc is."""
    if sys.stdout is None:  # Started with its standard output closed.
        return code
    try:
        print(text)
        sys.stdout.flush()
    except OSError as error:
        # Python would report the error again at exit, when it flushes the buffer.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):
            raise
    return code


def complain(message: str, code: int) -> int:
    """Print the message as one printable line on standard error, and return the code."""
    line = " ".join(message.split())
    line = "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in line)
    if len(line) > _LONGEST_LINE:
        half = _LONGEST_LINE // 2
        line = f"{line[:half]} ... {line[-half:]}"
    with suppress(OSError):  # Standard error is closed.
        if sys.stderr is not None:
            print(f"spiraltrunk: {line}", file=sys.stderr, flush=True)
    return code


def quote(text: str, most: int = 60) -> str:
    """The text in quotes, shortened to ``most`` characters."""
    return repr(text if len(text) <= most else f"{text[:most]}...")


def format_json(value: object) -> str:
    """Strict JSON; numbers that are not finite are null."""
    from spiraltrunk.files.results import format_json

    return format_json(value)


def add_file_count(text: str, result: dict[str, object], arguments: argparse.Namespace, gap: str = "\n\n") -> str:
    """The text, followed by the number of files in ``--out`` where it was given."""
    count = len(result["files"])  # type: ignore[arg-type]
    return text if arguments.out is None else f"{text}{gap}{count} files in {arguments.out}"


def check_folder(folder: str | Path | None, option: str = "--out") -> None:
    """Refuse an output folder that cannot be made or written, before any work is done; nothing stays on disc.

    Raises:
        UsageError: names the folder, or the file in its place.
    """
    if folder is None:
        return
    target, made = Path(folder), list[Path]()
    try:
        for path in reversed((target, *target.parents)):
            if not path.exists():
                path.mkdir()
                made.append(path)
            elif not path.is_dir():
                raise UsageError(f"{option}: {quote(str(path), 200)} is a file; allowed: a folder, existing or new")
        with TemporaryFile(dir=target):
            pass
    except OSError as error:
        reason = f"{quote(str(folder), 200)} cannot be written: {error.strerror}"
        raise UsageError(f"{option}: {reason}; allowed: a folder that can be made and written") from None
    finally:
        for path in reversed(made):
            with suppress(OSError):  # Another process has put something there.
                path.rmdir()
