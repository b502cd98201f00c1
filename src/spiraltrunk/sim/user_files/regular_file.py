"""Regular files of limited size."""

from __future__ import annotations

import os
import stat
from contextlib import suppress
from pathlib import Path

from spiraltrunk.errors import DesignError, Unquoted, describe_reason

FILE_MOST = 20_000_000
"""Largest file that is read [bytes]."""


def read_file(path: str, name: str) -> bytes:
    """Content of the file that a user named.

    Raises:
        DesignError: about ``name``, where it cannot be read, is no regular file, is empty or larger than `FILE_MOST`.
    """
    content, place = b"", None
    with suppress(OSError, ValueError, RuntimeError):  # Of an impossible path, or an unknown user's home.
        place = Path(path).expanduser()
        content = _read(place)
    if not 0 < len(content) <= FILE_MOST:
        allowed = f"a file that exists, regular and of 1 byte to {FILE_MOST // 1_000_000} MB"
        fault = _find_fault(place, len(content)) if path else "no name is given"
        raise DesignError(name, got=path, allowed=f"{allowed}; {fault}")
    return content


def _find_fault(place: Path | None, size: int) -> str:
    """What is wrong with a file of which ``size`` bytes could be read."""
    if size > FILE_MOST:
        return f"it is larger than {FILE_MOST // 1_000_000} MB"
    try:
        status = place.stat() if place is not None else None
    except (FileNotFoundError, NotADirectoryError, ValueError):
        status = None
    except OSError as error:
        return f"it cannot be read: {describe_reason(error)}"
    if status is None:
        return "it does not exist"
    if stat.S_ISDIR(status.st_mode):
        return "it is a folder"
    if not stat.S_ISREG(status.st_mode):
        return "it is a pipe, a socket or a device"
    return "it is empty" if status.st_size == 0 else "it cannot be read"


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
