"""Manifest of an output folder: which command wrote which file, with what content."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple, final

from spiraltrunk.errors import OutputError
from spiraltrunk.files.atomic import write_text

_SCHEMA = 1
_MOST_BYTES = 4_000_000
_HEX = frozenset("0123456789abcdef")


@final
class Record(NamedTuple):
    """One file that a command wrote."""

    writer: str
    """The command."""
    sha256: tuple[str, ...]
    """Contents that are the command's own: one, two while it is being replaced, none for a log that grows."""


def load_manifest(path: Path) -> dict[str, Record]:
    """Records by the files' names, which are paths below the folder; empty where there is no manifest.

    Raises:
        OutputError: where it is damaged.
    """
    try:
        with path.open("rb") as file:
            data = file.read(_MOST_BYTES + 1)
        return _parse(data)
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        reason = f"{str(path)!r} is damaged, so that it is not known which files are the user's"
        raise OutputError(f"{reason}; allowed: another folder, or this one once that file is removed") from None


def write_manifest(path: Path, records: dict[str, Record]) -> None:
    """Replace the manifest as a whole.

    Raises:
        OSError: where it cannot be written.
    """
    files = {name: {"writer": record.writer, "sha256": record.sha256} for name, record in sorted(records.items())}
    write_text(path, json.dumps({"schema": _SCHEMA, "files": files}, indent=1) + "\n")


def compute_digest(path: Path) -> str:
    """SHA-256 of a file.

    Raises:
        OSError: where it cannot be read.
    """
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def sync_file(path: Path) -> Path:
    """Wait until a file's content is on the disc, and return its path.

    Raises:
        OSError: where it cannot be stored.
    """
    with path.open("rb") as file:
        os.fsync(file.fileno())
    return path


def _parse(data: bytes) -> dict[str, Record]:
    """The records.

    Raises:
        ValueError, TypeError, KeyError, AttributeError, RecursionError: where it is no manifest.
    """
    if len(data) > _MOST_BYTES:
        raise ValueError("too long")
    document = json.loads(data)
    if document["schema"] != _SCHEMA:
        raise ValueError("another schema")
    return {_check_name(name): _read_record(entry) for name, entry in document["files"].items()}


def _check_name(name: str) -> str:
    path = PurePosixPath(name)
    if path.is_absolute() or ".." in path.parts or not path.parts or str(path) != name or "\0" in name:
        raise ValueError("no path below the folder")
    return name


def _read_record(entry: dict[str, Any]) -> Record:
    writer, digests = entry["writer"], tuple(entry["sha256"])
    if not isinstance(writer, str) or not all(
        isinstance(digest, str) and len(digest) == 64 and set(digest) <= _HEX for digest in digests
    ):
        raise ValueError("no record")
    return Record(writer, digests)
