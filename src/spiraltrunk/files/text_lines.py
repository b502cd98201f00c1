"""Lines of a text file, read in blocks: any line ends, no line longer than a limit, never the whole file at once."""

from __future__ import annotations

import os
import stat
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


@contextmanager
def open_take(path: str | Path) -> Iterator[BinaryIO]:
    """The file, opened: a regular one of sensible size, as a pipe would block and a device never end.

    Raises:
        TakeError: where it cannot be read; it says why.
    """
    allowed = "allowed: a recording that can be read"
    try:
        if Path(path).is_dir():
            raise TakeError(f"this is a folder; {allowed}", file=str(path))
        # Without waiting, which a pipe would make it do.
        file = os.fdopen(os.open(path, os.O_RDONLY | os.O_NONBLOCK), "rb")
    except TakeError:
        raise
    except (OSError, ValueError) as error:  # A name that no disc takes is the latter.
        raise TakeError(f"{getattr(error, 'strerror', None) or error}; {allowed}", file=str(path)[:300]) from None
    with file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode):
            raise TakeError(f"this is no regular file; {allowed}", file=str(path))
        if status.st_size > MOST_BYTES:
            told = f"{status.st_size / 1e9:.2f} GB; allowed: at most {MOST_BYTES / 1e9:g} GB: export in parts"
            raise TakeError(f"the file has {told}", file=str(path))
        yield file


@final
class Lines:
    """Lines of a stream as bytes without their ends; CR LF, LF and CR all end one."""

    def __init__(self, stream: BinaryIO, source: str) -> None:
        self.source = source
        """What errors call the file."""
        self.number = 0
        """Number of the line that was read last, from 1."""
        self.is_ended = True
        """Whether that line had an end, or the file stopped within it."""
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
            if text.endswith(b"\r"):  # The rest of the line's end may come with the next block.
                text, held = text[:-1], b"\r"
            if b"\r" in text:
                text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
            lines = text.split(b"\n")
            rest = lines.pop() + held
            yield from lines
            if len(rest) > _LONGEST:
                told = f"the line has more than {_LONGEST} bytes; allowed: a Motive CSV"
                raise TakeError(told, file=self.source, line=self.number + 1)
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
    """The text of a line: UTF-8, else what Windows writes in the West."""
    try:
        return line.decode()
    except UnicodeDecodeError:
        return line.decode("cp1252", errors="replace")
