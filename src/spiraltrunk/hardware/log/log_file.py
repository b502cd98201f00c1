"""File of a log: made exclusively, with its head; a stream that keeps what the disc does not take."""

from __future__ import annotations

import os
import secrets
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import final

from spiraltrunk.errors import OutputError


def create_log(path: Path, head: bytes) -> int:
    """Make a file that begins with ``head``, and return its descriptor; the name appears only once the head is stored.

    Raises:
        OutputError: where the file exists, or cannot be made.
    """
    draft = path.with_name(f".{path.name[:80]}-{secrets.token_hex(4)}")
    try:
        descriptor = os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o644)
        try:
            _write_all(descriptor, head)
            os.fsync(descriptor)
            _give_name(draft, path)
        except BaseException:
            os.close(descriptor)
            raise
        finally:
            with suppress(OSError):  # In place already.
                draft.unlink()
    except FileExistsError:
        raise OutputError(f"the log {str(path)!r} exists; allowed: a new file, as no log is replaced") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise OutputError(f"the log {str(path)!r} cannot be made: {reason}; allowed: a folder to write to") from None
    return descriptor


def _write_all(descriptor: int, data: bytes) -> None:
    while data:
        data = data[os.write(descriptor, data) :]


def _give_name(draft: Path, path: Path) -> None:
    """Name the draft ``path``, which must not exist.

    Raises:
        FileExistsError: where it does.
        OSError: where it cannot be named.
    """
    try:
        os.link(draft, path)
    except FileExistsError:
        raise
    except OSError:  # No hard links here, as on FAT.
        os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644))
        draft.replace(path)


@final
class PendingStream:
    """Bytes on their way to a file; what the disc does not take now is kept for the next `commit`."""

    def __init__(self) -> None:
        self._offset = 0
        self._pending = bytearray()

    @property
    def pending(self) -> int:
        """Bytes not yet written."""
        return len(self._pending)

    def write(self, data: bytes) -> int:
        """Keep the bytes."""
        self._pending += data
        return len(data)

    def flush(self) -> None:
        """Nothing: `commit` writes."""

    def tell(self) -> int:
        """Offset in the file after all bytes that were kept."""
        return self._offset + len(self._pending)

    def take(self) -> bytes:
        """Bytes kept, which count as written."""
        data = bytes(self._pending)
        self._pending.clear()
        self._offset += len(data)
        return data

    def commit(self, write: Callable[[bytes], int]) -> None:
        """Write what is kept.

        Raises:
            OSError: where the disc does not take all; the rest is kept.
        """
        while self._pending:
            n = write(bytes(self._pending[:_BLOCK]))
            del self._pending[:n]
            self._offset += n


_BLOCK = 1 << 20
"""Bytes written in one call."""
