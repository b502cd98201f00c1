"""Files that are there whole or not at all."""

from __future__ import annotations

import errno
import secrets
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def write_draft(path: str | Path) -> Iterator[Path]:
    """A path to write to, put in place of ``path`` at the end of the block, or removed where the block raises.

    The draft lies in the same folder, which is made where it is missing, and ends alike, as writers choose their format
    by the ending.
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
def write_folder(folder: str | Path, files: Sequence[str]) -> Iterator[Path]:
    """A draft folder to write to; at the end of the block its files move to ``folder``, which is made where missing.

    Of what was there ``files`` go then, so that nothing of an earlier run stays; ``result.json`` comes last. Where the
    block raises, everything is as it was.

    Args:
        folder: where to.
        files: paths below it that an earlier run may have left there.

    Raises:
        OSError: where the folder cannot be made or written, or holds another's file of the same name.
    """
    target = Path(folder)
    made = [path for path in (target, *target.parents) if not path.exists()]
    draft = target / f".{secrets.token_hex(8)}"
    try:
        _make_folder(draft, target)
        yield draft
        written = [path for path in draft.rglob("*") if path.is_file()]
        refuse_strangers(target, [str(path.relative_to(draft)) for path in written], files)
        for name in files:
            (target / name).unlink(missing_ok=True)
        for path in sorted(written, key=lambda path: path.name == "result.json"):
            goal = target / path.relative_to(draft)
            goal.parent.mkdir(parents=True, exist_ok=True)
            path.replace(goal)
        shutil.rmtree(draft)
        for emptied in sorted({(target / name).parent for name in files} - {target}, reverse=True):
            with suppress(OSError):  # Not empty, or never there.
                emptied.rmdir()
    except BaseException:
        shutil.rmtree(draft, ignore_errors=True)
        for path in made:
            with suppress(OSError):  # Somebody else has put something there, or it was never made.
                path.rmdir()
        raise


def refuse_strangers(folder: str | Path, names: Sequence[str], files: Sequence[str]) -> None:
    """See that no file that is to be written is there already, but for those of an earlier run.

    Raises:
        FileExistsError: names the first.
    """
    for name in sorted(set(names) - set(files)):
        path = Path(folder) / name
        if path.exists():
            raise FileExistsError(errno.EEXIST, "it is there, and no earlier run of this command wrote it", str(path))


def _make_folder(draft: Path, target: Path) -> None:
    """Make the draft and the folders above it; an error names the folder that was asked for."""
    try:
        draft.mkdir(parents=True)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(target)) from None
