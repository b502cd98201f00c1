"""Atomic writing: a file, or the files of a folder, are replaced as a whole or not at all."""

from __future__ import annotations

import errno
import secrets
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def atomic_file(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path beside ``path`` that replaces it at the end of the block.

    It has the same ending, as writers choose their format by it. The folder is made where it is missing. Where the
    block raises, the temporary file is removed and ``path`` stays unchanged.
    """
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    draft = target.parent / f".{secrets.token_hex(8)}{target.suffix}"
    try:
        yield draft
        draft.replace(target)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise


@contextmanager
def atomic_folder(folder: str | Path, files: Sequence[str]) -> Iterator[Path]:
    """Yield a temporary folder; at the end of the block its files move to ``folder``, which is made where missing.

    At that time the ``files`` of an earlier run are removed; ``result.json`` is moved last. Where the block raises,
    everything is as before.

    Args:
        folder: where to.
        files: paths below it that an earlier run may have left there.

    Raises:
        OSError: where the folder cannot be made or written.
        FileExistsError: where it holds a file of the same name that is not one of ``files``.
    """
    target = Path(folder)
    missing = [path for path in (target, *target.parents) if not path.exists()]
    draft = target / f".{secrets.token_hex(8)}"
    try:
        try:
            draft.mkdir(parents=True)
        except OSError as error:  # It names the draft, which nobody asked for.
            raise OSError(error.errno, error.strerror, str(target)) from None
        yield draft
        written = [path.relative_to(draft) for path in draft.rglob("*") if path.is_file()]
        check_foreign_files(target, [str(path) for path in written], files)
        for name in files:
            (target / name).unlink(missing_ok=True)
        for path in sorted(written, key=lambda path: path.name == "result.json"):
            (target / path).parent.mkdir(parents=True, exist_ok=True)
            (draft / path).replace(target / path)
        shutil.rmtree(draft)
        for emptied in sorted({(target / name).parent for name in files} - {target}, reverse=True):
            with suppress(OSError):  # Not empty, or never there.
                emptied.rmdir()
    except BaseException:
        shutil.rmtree(draft, ignore_errors=True)
        for path in missing:
            with suppress(OSError):  # Not empty, or never made.
                path.rmdir()
        raise


def check_foreign_files(folder: str | Path, names: Sequence[str], files: Sequence[str]) -> None:
    """Check that no file in ``names`` exists in the folder, except those in ``files`` of an earlier run.

    Raises:
        FileExistsError: names the first.
    """
    for name in sorted(set(names) - set(files)):
        path = Path(folder) / name
        if path.exists():
            raise FileExistsError(errno.EEXIST, "it is there, and no earlier run of this command wrote it", str(path))
