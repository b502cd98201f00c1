"""Atomic writing: a file is replaced as a whole or not at all."""

from __future__ import annotations

import hashlib
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from spiraltrunk.files.lock import acquire_lock, remove_abandoned

_DRAFTS = 10
"""Largest number of drafts created in turn, where other processes remove each as an abandoned one (ours)."""


@contextmanager
def atomic_file(path: str | Path) -> Iterator[Path]:
    """A path to write to, which replaces ``path`` at the end of the block; where the block raises, nothing is changed.

    The draft is in the same folder, which is made where it is missing, and has the same ending, by which writers choose
    their format. Drafts of processes that were killed while they wrote the same file are removed.

    Raises:
        OSError: where the folder cannot be made or the file not be written; it names ``path``.
    """
    target = Path(path)
    with _make_folder(target.parent):
        name = f".spiraltrunk-{hashlib.sha256(os.fsencode(target.name)).hexdigest()[:8]}-"
        for left in target.parent.glob(f"{name}*"):
            remove_abandoned(left)
        try:
            draft, lock = _open_draft(target, name)
        except OSError as error:
            raise _name(target, error) from None
        try:
            yield draft
            draft.replace(target)
        except OSError as error:
            if error.filename in (None, str(draft)):
                raise _name(target, error) from error
            raise
        finally:
            with suppress(OSError):  # In place already.
                draft.unlink()
            os.close(lock)


def check_place(path: str | Path) -> None:
    """Make a draft of the file and remove it, so that a place that cannot be written is known before long work.

    Raises:
        OSError: where the folder cannot be made or the file not be written; it names ``path``.
    """
    with suppress(FileNotFoundError):
        os.lstat(path)  # A name that is too long.
    with suppress(_DraftRemoved), atomic_file(path):
        raise _DraftRemoved


class _DraftRemoved(Exception):
    """Leaves `atomic_file` without a file."""


def write_file(path: str | Path, data: bytes) -> None:
    """Replace the file by one with this content, or leave it as it was.

    Raises:
        OSError: where it cannot be written; it names ``path``.
    """
    with atomic_file(path) as draft, draft.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


def write_text(path: str | Path, text: str) -> None:
    """`write_file` in UTF-8; half surrogates, as in names of files that are no UTF-8, are escaped.

    Raises:
        OSError: where it cannot be written; it names ``path``.
    """
    write_file(path, text.encode(errors="backslashreplace"))


def _open_draft(target: Path, name: str) -> tuple[Path, int]:
    """A new draft beside the file, its name beginning with ``name``, and the descriptor that holds its lock.

    Before this process has locked a draft that it created, a second process that writes the same file may hold its
    lock, to remove it as an abandoned one (`remove_abandoned`). Then another draft is created.

    Raises:
        BlockingIOError: where that happens `_DRAFTS` times.
        OSError: where the draft cannot be made.
    """
    for tried in range(1, _DRAFTS + 1):
        draft = target.parent / f"{name}{secrets.token_hex(4)}{target.suffix}"
        try:
            lock = acquire_lock(draft)
        except BlockingIOError:
            if tried == _DRAFTS:
                raise
        else:
            break
    return draft, lock


def _name(target: Path, error: OSError) -> OSError:
    """The same error, of the file that was asked for."""
    return OSError(error.errno, error.strerror or str(error), str(target))


@contextmanager
def _make_folder(folder: Path) -> Iterator[None]:
    """Make the folder and those above it; where the block raises, remove those that were made."""
    made = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        yield
    except BaseException:
        for path in made:
            with suppress(OSError):  # Not empty, or never made.
                path.rmdir()
        raise
