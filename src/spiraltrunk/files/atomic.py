"""Atomic writing: a file, or the files of a folder, are replaced as a whole or not at all."""

from __future__ import annotations

import errno
import os
import secrets
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def atomic_file(path: str | Path) -> Iterator[Path]:
    """A path to write to, which replaces ``path`` at the end of the block; where the block raises, nothing is changed.

    The draft is in the same folder, which is made where it is missing, and has the same ending, by which writers choose
    their format.

    Raises:
        OSError: where the folder cannot be made or the file not be replaced.
    """
    target = Path(path)
    with _make_folder(target.parent):
        draft = target.parent / f".{secrets.token_hex(8)}{target.suffix}"
        try:
            yield draft
            draft.replace(target)
        except BaseException:
            with suppress(OSError):  # Never written.
                draft.unlink()
            raise


def write_file(path: str | Path, data: bytes) -> None:
    """Replace the file by one with this content, or leave it as it was.

    Raises:
        OSError: where it cannot be written.
    """
    with atomic_file(path) as draft, draft.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


@contextmanager
def atomic_folder(folder: str | Path, files: Sequence[str]) -> Iterator[Path]:
    """A draft folder to write to, whose files move to ``folder`` at the end of the block, ``result.json`` last.

    ``files`` of an earlier run are removed before. Where the block raises, nothing is changed.

    Args:
        folder: where to; made where it is missing.
        files: paths below it that an earlier run may have left there.

    Raises:
        OSError: where the folder cannot be made or written.
        FileExistsError: where it holds a file of the same name that is not one of ``files``.
    """
    target = Path(folder)
    with _make_folder(target):
        draft = target / f".{secrets.token_hex(8)}"
        try:
            draft.mkdir()
        except OSError as error:  # Name the folder that was asked for.
            raise OSError(error.errno, error.strerror, str(target)) from None
        try:
            yield draft
            written = [path for path in draft.rglob("*") if path.is_file()]
            check_foreign_files(target, [str(path.relative_to(draft)) for path in written], files)
            for name in files:
                (target / name).unlink(missing_ok=True)
            for path in sorted(written, key=lambda path: path.name == "result.json"):
                place = target / path.relative_to(draft)
                place.parent.mkdir(parents=True, exist_ok=True)
                path.replace(place)
        finally:
            shutil.rmtree(draft, ignore_errors=True)
        for emptied in sorted({(target / name).parent for name in files} - {target}, reverse=True):
            with suppress(OSError):  # Not empty, or never there.
                emptied.rmdir()


def check_foreign_files(folder: str | Path, names: Sequence[str], files: Sequence[str]) -> None:
    """Refuse to overwrite files that are not of an earlier run.

    Args:
        folder: where to.
        names: paths below it that are to be written.
        files: paths below it that an earlier run may have left there.

    Raises:
        FileExistsError: names the first.
    """
    for name in sorted(set(names) - set(files)):
        path = Path(folder) / name
        if path.exists():
            raise FileExistsError(errno.EEXIST, "it is there, and no earlier run of this command wrote it", str(path))


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
