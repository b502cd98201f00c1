"""What a command gives back: an exit code, a text on standard output, lines on standard error."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
"""Exit codes; a signal that ends the command has 128 plus its number."""

Answer = tuple[int, str]
"""Exit code and the text for standard output."""

_LONGEST_LINE = 700


class UsageError(Exception):
    """Arguments that make no command."""


def put(code: int, text: str) -> int:
    """Print the answer; a reader that has left, or was never there, is no error, a full disc is."""
    if sys.stdout is None:  # Started with its standard output closed.
        return code
    try:
        print(text)
        sys.stdout.flush()
    except OSError as error:
        # Python would complain once more at exit, where it flushes what is left.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):
            raise
    return code


def complain(message: str, code: int) -> int:
    """Say the message in one printable line on standard error."""
    line = " ".join(message.split())
    line = "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in line)
    if len(line) > _LONGEST_LINE:
        half = _LONGEST_LINE // 2
        line = f"{line[:half]} ... {line[-half:]}"
    with suppress(OSError):  # Nobody listens.
        if sys.stderr is None:
            return code
        print(f"spiraltrunk: {line}", file=sys.stderr, flush=True)
    return code


def quote(text: str, most: int = 60) -> str:
    """What was typed, in quotes, as far as it fits in a line."""
    return repr(text if len(text) <= most else f"{text[:most]}...")


def format_json(value: object) -> str:
    """Strict JSON of plain values."""
    import json

    return json.dumps(value, indent=2, allow_nan=False)


def check_folder(folder: str, option: str = "--out") -> None:
    """Refuse a folder to write to that is a file, lies below one or cannot be written, before any work is done.

    Raises:
        UsageError: names the file or folder.
    """
    target = Path(folder)
    with suppress(OSError):  # Names that no disc takes are refused where they are made.
        for path in (target, *target.parents):
            if path.exists():
                if not path.is_dir():
                    allowed = "a folder, existing or new"
                    raise UsageError(f"{option}: {quote(str(path), 200)} is a file; allowed: {allowed}")
                if not os.access(path, os.W_OK | os.X_OK):
                    allowed = "a folder that can be written"
                    raise UsageError(f"{option}: {quote(str(path), 200)} cannot be written; allowed: {allowed}")
                return
