"""Lines of a text file, read in blocks: any line endings, limited line length, never the whole file at once."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, final

from spiraltrunk.errors import TakeError

MOST_BYTES = 2_000_000_000
"""Largest file that is read [bytes]: ten hours of 18 bodies at 100 Hz (ours)."""

_BLOCK = 1 << 22
_LONGEST = 1 << 21

_UTF_8, _UTF_16, _UTF_32 = b"\xef\xbb\xbf", (b"\xff\xfe", b"\xfe\xff"), (b"\xff\xfe\0\0", b"\0\0\xfe\xff")


def check_regular(path: Path) -> None:
    """Refuse a folder, and a pipe or a device, of which reading may not end.

    Raises:
        OSError: where there is one.
    """
    if path.exists() and not path.is_file():
        raise OSError(errno.EINVAL, "this is a folder" if path.is_dir() else "this is no regular file", str(path))


@contextmanager
def open_take(path: str | Path, what: str = "a recording that can be read") -> Iterator[BinaryIO]:
    """A regular file of limited size, opened for reading.

    Args:
        path: the file.
        what: what is allowed there, for the error.

    Raises:
        TakeError: where it cannot be read; it says why.
    """
    allowed, place = f"allowed: {what}", Path(path)
    try:
        check_regular(place)
        file = place.open("rb")
    except (OSError, ValueError) as error:  # Of a name that no file system takes it is the latter.
        raise TakeError(f"{getattr(error, 'strerror', None) or error}; {allowed}", file=str(path)[:300]) from None
    with file:
        size = os.fstat(file.fileno()).st_size
        if size > MOST_BYTES:
            allowed = f"at most {MOST_BYTES / 1e9:g} GB: export in parts"
            raise TakeError(f"the file has {size / 1e9:.2f} GB; allowed: {allowed}", file=str(path))
        yield file


@final
class Lines:
    """Lines of a stream as bytes without their endings CR LF, LF or CR."""

    def __init__(self, stream: BinaryIO, source: str) -> None:
        self.source = source
        """Name of the file in errors."""
        self.number = 0
        """Number of the last line that was read, from 1."""
        self.is_ended = True
        """Whether that line had an ending; if not, the file stops within it."""
        self._lines = self._read(stream)

    def __iter__(self) -> Iterator[bytes]:
        return self

    def __next__(self) -> bytes:
        line = next(self._lines)
        self.number += 1
        return line

    def _read(self, stream: BinaryIO) -> Iterator[bytes]:
        rest, is_first = b"", True
        while block := stream.read(_BLOCK):
            if is_first:
                block, is_first = self._strip_mark(block), False
            text = rest + block
            held = b""
            if text.endswith(b"\r"):  # LF may follow in the next block.
                text, held = text[:-1], b"\r"
            if b"\r" in text:
                text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
            lines = text.split(b"\n")
            rest = lines.pop() + held
            yield from lines
            if len(rest) > _LONGEST:
                found = f"the line has more than {_LONGEST} bytes; allowed: a Motive CSV"
                raise TakeError(found, file=self.source, line=self.number + 1)
        if rest.endswith(b"\r"):
            yield rest[:-1]
        elif rest:
            self.is_ended = False
            yield rest

    def _strip_mark(self, block: bytes) -> bytes:
        if block.startswith((*_UTF_16, *_UTF_32)) or b"\0" in block[:4]:
            raise TakeError(
                "the text is UTF-16 or binary; allowed: CSV in UTF-8, as Motive writes it", file=self.source
            )
        return block.removeprefix(_UTF_8)


def decode(line: bytes) -> str:
    """The text of a line in UTF-8, else in Windows-1252."""
    try:
        return line.decode()
    except UnicodeDecodeError:
        return line.decode("cp1252", errors="replace")
