"""Output of a command: exit code, text on standard output, lines on standard error."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from typing import TYPE_CHECKING

from spiraltrunk.errors import OutputError

if TYPE_CHECKING:
    from spiraltrunk.files.output_folder import OutputFolder

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
    with _sending():
        # Names of files that are no UTF-8 have half surrogates.
        print(text.encode(sys.stdout.encoding or "utf-8", "backslashreplace").decode(sys.stdout.encoding or "utf-8"))
    return code


def send(code: int) -> int:
    """Send what has been printed, such as a help, and return the code; a closed pipe is no error, a full disc is."""
    if sys.stdout is not None:
        with _sending():
            pass
    return code


@contextmanager
def _sending() -> Iterator[None]:
    """Flush standard output at the end."""
    try:
        yield
        sys.stdout.flush()
    except OSError as error:
        # Python would report the error again at exit, when it flushes the buffer.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):
            raise


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


def format_count(count: int, noun: str) -> str:
    """The count and the noun, which takes an s unless it is one."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def add_file_count(text: str, result: dict[str, object], arguments: argparse.Namespace, gap: str = "\n\n") -> str:
    """The text, followed by the number of files in ``--out`` where it was given."""
    count = len(result["files"])  # type: ignore[arg-type]
    return text if arguments.out is None else f"{text}{gap}{format_count(count, 'file')} in {arguments.out}"


@contextmanager
def open_out(
    folder: str | None, writer: str, names: Iterable[str] = (), option: str = "--out"
) -> Iterator[OutputFolder | None]:
    """The output folder of a command, open within the block; None where none was asked for.

    Args:
        folder: where to write.
        writer: the command.
        names: files that it may write, as paths below the folder.
        option: the option that names the folder.

    Raises:
        UsageError: where it cannot be written, is being written or holds one of the files that is not the command's
            own; nothing is changed.
    """
    if folder is None:
        yield None
        return
    from spiraltrunk.files.output_folder import open_output

    with ExitStack() as stack:
        try:
            output = stack.enter_context(open_output(folder, writer, names))
        except OutputError as error:
            raise UsageError(f"{option}: {error}") from None
        yield output


@contextmanager
def name_option(option: str) -> Iterator[None]:
    """Name the option in errors of its output file.

    Raises:
        UsageError: where the file cannot be written or must not be replaced.
    """
    try:
        yield
    except OutputError as error:
        raise UsageError(f"{option}: {error}") from None
