"""Errors of this package: one base class; each error is also the built-in error that a caller would expect."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable


class SpiralTrunkError(Exception):
    """Base of every error that this package raises on purpose; its message is one line."""

    outside: object = None
    """The `checks.OutOfRange` that the error is about, if it is about a number that is out of its range."""

    def __init__(self, message: str = "") -> None:
        super().__init__(" ".join(str(message).split()))


class Unquoted(str):
    """A text about a value, such as "missing", which an error shows without quotes."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


class DesignError(SpiralTrunkError, ValueError):
    """A design value that cannot be built: its file, where it has one, its name, the value and what is allowed."""

    def __init__(self, name: str, *, got: object, allowed: object, file: str = "") -> None:
        self.name = name
        self.got = got
        self.allowed = allowed
        where = f"{describe(file)}: " if file else ""
        super().__init__(f"{where}{name} is {describe(got)}; allowed: {allowed}")


class ShapeError(SpiralTrunkError, ValueError):
    """An array whose shape or content does not fit the design."""


class ModelError(SpiralTrunkError, ValueError):
    """An input for which the model has no solution."""


class UnknownName(SpiralTrunkError, KeyError):
    """A name that is not in a catalogue; the message lists the names that are."""

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        self.name = name
        self.known = tuple(known)
        super().__init__(f"unknown {kind} {name!r}; known: {', '.join(self.known)}")

    def __str__(self) -> str:
        return str(self.args[0])


class MissingPackage(SpiralTrunkError, ImportError):
    """An optional package that is not installed; the message says how to install it."""


class TakeError(SpiralTrunkError, ValueError):
    """A recording or a protocol that cannot be used: place in the file, what was found and what is allowed."""

    def __init__(self, message: str, *, file: str = "", line: int | None = None, column: int | None = None) -> None:
        self.file = file
        self.line = line
        self.column = column
        where = [repr(file)] if file else []
        where += [f"line {line}"] if line is not None else []
        where += [f"column {column}"] if column is not None else []
        super().__init__(f"{', '.join(where)}: {message}" if where else message)


class SurveyError(SpiralTrunkError, ValueError):
    """A folder that holds another survey than the requested one."""


class OutputError(SpiralTrunkError, OSError):
    """A file or folder that cannot be written or must not be replaced: which, why and what is allowed."""


class PartError(SpiralTrunkError, ValueError):
    """A part that cannot be manufactured: which, where and by how much."""


class RunError(SpiralTrunkError, RuntimeError):
    """A run that cannot start or cannot go on."""


class DriveError(SpiralTrunkError, RuntimeError):
    """A bus, motor, servo or arm that cannot be reached or refuses, or a command that it must not get."""


def describe_reason(error: BaseException) -> str:
    """Why the operating system or a library refused, on one line, without numbers of errors and names of files."""
    if isinstance(error, OSError) and error.errno is not None and error.errno > 0:
        return os.strerror(error.errno)
    return " ".join(re.sub(r"\[(Errno|Error Code) -?\d+\]:? ?", "", str(error)).split()) or type(error).__name__


def describe(value: object, most: int = 80) -> str:
    """The value's `repr` on one line, of at most ``most`` characters."""
    text = " ".join(repr(value).split())
    return text if len(text) <= most else f"{text[: most // 2 - 3]}...{text[-most // 2 :]}"


class StudioError(SpiralTrunkError, RuntimeError):
    """An address, a port or a file that the studio cannot use."""
