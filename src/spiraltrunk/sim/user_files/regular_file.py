"""Regular files of limited size."""

from __future__ import annotations

import os
import stat
from contextlib import suppress
from pathlib import Path

from spiraltrunk.errors import DesignError, Unquoted

FILE_MOST = 20_000_000
"""Largest file that is read [bytes]."""


def read_file(path: str, name: str) -> bytes:
    """Content of the file that a user named.

    Raises:
        DesignError: about ``name``, where it cannot be read, is no regular file, is empty or larger than `FILE_MOST`.
    """
    content = b""
    with suppress(OSError, ValueError, RuntimeError):  # Of an impossible path, or an unknown user's home.
        content = _read(Path(path).expanduser())
    if not 0 < len(content) <= FILE_MOST:
        allowed = f"a file that exists, regular and of 1 byte to {FILE_MOST // 1_000_000} MB"
        raise DesignError(name, got=path, allowed=allowed)
    return content


def read_below(folder: Path, name: str) -> bytes | None:
    """Content of a file that another file names; None where there is none.

    Raises:
        PermissionError: where it lies outside ``folder``, also by a symbolic link, or is no regular file, is empty or
            larger than `FILE_MOST`.
    """
    try:
        place = Path(os.path.realpath(folder / name))
        if not place.is_relative_to(os.path.realpath(folder)) or Path(name).is_absolute():
            raise PermissionError(name)
        if not place.exists():
            return None
        content = _read(place)
    except (OSError, ValueError) as error:
        raise PermissionError(name) from error
    if not 0 < len(content) <= FILE_MOST:
        raise PermissionError(name)
    return content


def _read(path: Path) -> bytes:
    """Content up to one byte beyond `FILE_MOST`; opening a pipe or a device neither waits nor reads."""
    if not path.is_file():
        return b""
    with os.fdopen(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
        is_regular = stat.S_ISREG(os.fstat(file.fileno()).st_mode)  # It may have been exchanged since.
        return file.read(FILE_MOST + 1) if is_regular else b""


def refusal(what: str, reason: str, allowed: str) -> DesignError:
    """The error about a file that cannot be used: "``what`` is ``reason``; allowed: ``allowed``"."""
    return DesignError(what, got=Unquoted(reason), allowed=allowed)
