"""Output files: a command replaces a file that it wrote, and no other.

A single file has no folder that could know what was written. Its last comment therefore holds the SHA-256 of the rest:
a file without it was written by another program, and one whose rest differs was changed since.
"""

from __future__ import annotations

import hashlib
import os
import zlib
from pathlib import Path

from spiraltrunk.errors import OutputError
from spiraltrunk.files.atomic import check_place, write_file

_TEXT = b"Written by spiraltrunk; SHA-256 of the rest: "

_COMMENTS = {"toml": (b"# ", b"\n"), "svg": (b"<!-- ", b" -->\n"), "pdf": (b"% ", b"\n"),
             "html": (b"<!-- ", b" -->\n")}  # fmt: skip
"""Begin and end of a comment in the last line of a format."""

_PNG_END = b"\0\0\0\0IEND\xaeB`\x82"
"""Last chunk of a PNG (ISO/IEC 15948, section 11.2.5)."""

_MOST_BYTES = 100_000_000
"""Largest file that is read: those of this package are far smaller."""

FORMATS = (*_COMMENTS, "png")
"""Formats of the files that can be written."""


def check_output_file(path: str | Path, form: str) -> None:
    """Refuse a place where no file can be written, or where one is that must not be replaced; nothing stays there.

    Args:
        path: the file.
        form: its format, of `FORMATS`.

    Raises:
        OutputError: with the path, or that of the file in place of its folder.
    """
    target = Path(path)
    _check_replaced(target, form)
    try:
        check_place(target)
    except OSError as error:
        raise _refuse(target, error) from None


def _check_replaced(target: Path, form: str) -> None:
    """Refuse a folder, a file in place of a folder, or a file that must not be replaced."""
    try:
        if target.is_dir():
            raise OutputError(f"{str(target)!r} is a folder; allowed: a file, existing or new")
        for above in target.parents:
            if above.exists() and not above.is_dir():
                raise OutputError(f"{str(above)!r} is a file; allowed: a folder, existing or new")
        is_free = not os.path.lexists(target) or _is_own(target, form)
    except OutputError:
        raise
    except OSError as error:
        raise _refuse(target, error) from None
    if not is_free:
        reason = "it is no file of spiraltrunk's, or was changed since"
        raise OutputError(f"{str(target)!r} is not replaced: {reason}; allowed: a new file, or move that one away")


def write_output_file(path: str | Path, data: bytes, form: str) -> None:
    """Write a file that `check_output_file` allows, with its SHA-256 in a comment, whole or not at all.

    Args:
        path: the file.
        data: its content.
        form: its format, of `FORMATS`.

    Raises:
        OutputError: where it cannot be written, or must not be replaced.
    """
    _check_replaced(Path(path), form)
    try:
        write_file(path, _seal(data, form))
    except OSError as error:
        raise _refuse(Path(path), error) from error


def _refuse(target: Path, error: OSError) -> OutputError:
    reason = error.strerror or str(error)
    return OutputError(f"{str(target)!r} cannot be written: {reason}; allowed: a place that can be made and written")


def _seal(data: bytes, form: str) -> bytes:
    """The file with its comment."""
    mark = _TEXT + hashlib.sha256(data).hexdigest().encode()
    if form == "png":
        chunk = b"tEXtComment\0" + mark
        chunk = (len(chunk) - 4).to_bytes(4, "big") + chunk + zlib.crc32(chunk).to_bytes(4, "big")
        return data.removesuffix(_PNG_END) + chunk + _PNG_END
    begin, end = _COMMENTS[form]
    return data + begin + mark + end


def _is_own(path: Path, form: str) -> bool:
    """Whether the file is one of ours, as it was written."""
    if path.is_symlink() or not path.is_file() or path.stat().st_size > _MOST_BYTES:
        return False
    data, tail = path.read_bytes(), _PNG_END if form == "png" else b""
    added = len(_seal(tail, form))
    return _seal(data[:-added] + tail, form) == data
