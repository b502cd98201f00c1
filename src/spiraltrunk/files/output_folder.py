"""Output folders: a command replaces the files that it wrote, and no other.

An output folder has a hidden folder ``.spiraltrunk``: a manifest of the files that commands wrote there, with their
SHA-256, and, while a command runs, its lock and its draft. A file that no command wrote, that another command wrote or
that was changed since is never replaced and never removed. A file that has the new content already stays as it is.

Files move in in an order that a kill at any moment leaves consistent: the manifest first takes in the new content
beside the old, then the files are replaced, then the manifest drops the old content.
"""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import final

from spiraltrunk.errors import OutputError
from spiraltrunk.files.lock import acquire_lock, release_lock, remove_abandoned
from spiraltrunk.files.manifest import Record, compute_digest, load_manifest, sync_file, write_manifest
from spiraltrunk.files.signals import hold_signals

STATE = ".spiraltrunk"
"""Name of the hidden folder."""

_ATTEMPTS = 20
"""How often a folder is made anew that another command removes as it fails."""

_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
"""Errors of writing that may come without the file's name, or with another's."""


@contextmanager
def open_output(folder: str | Path | OutputFolder, writer: str, names: Iterable[str] = ()) -> Iterator[OutputFolder]:
    """An output folder, made where it is missing and locked within the block; one that is open already stays so.

    What a command that was killed left behind is removed. Where nothing is written, nothing of it stays.

    Args:
        folder: where to write.
        writer: the command that writes, whose own files it may replace.
        names: files that it may write, as paths below the folder.

    Raises:
        OutputError: where the folder cannot be made, another process is writing to it, its manifest is damaged, or one
            of the files is there and not the command's own.
    """
    if isinstance(folder, OutputFolder):
        folder.check(names)
        yield folder
        return
    path = Path(folder)
    made = [each for each in (path, *path.parents) if not os.path.lexists(each)]
    state = path / STATE
    try:
        lock = _enter(path)
        try:
            for left in state.glob(".spiraltrunk-*"):
                remove_abandoned(left)
            shutil.rmtree(state / "draft", ignore_errors=True)
            output = OutputFolder(path, writer)
            output.check(names)
            yield output
        finally:
            shutil.rmtree(state / "draft", ignore_errors=True)
            release_lock(state / "lock", lock)
    finally:
        for each in (state, *made):
            with suppress(OSError):  # Not empty, or never made.
                each.rmdir()


def _enter(path: Path) -> int:
    """Make the folder, lock it, and return the lock's descriptor."""
    for _ in range(_ATTEMPTS):
        try:
            if path.exists() and not path.is_dir():
                raise NotADirectoryError
            (path / STATE).mkdir(parents=True, exist_ok=True)
            return acquire_lock(path / STATE / "lock")
        except FileNotFoundError:  # Another command that failed has removed it.
            continue
        except BlockingIOError:
            allowed = "allowed: another folder, or this one once that process has ended"
            raise OutputError(f"another process is writing to {str(path)!r}; {allowed}") from None
        except OSError as error:
            raise _refuse_folder(path, error) from None
    raise _refuse_folder(path, FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT)))


def _refuse_folder(path: Path, error: OSError) -> OutputError:
    for each in (path, *path.parents):
        with suppress(OSError):
            if each.exists() and not each.is_dir():
                return OutputError(f"{str(each)!r} is a file; allowed: a folder, existing or new")
    return OutputError(f"{str(path)!r} cannot be written: {error.strerror}; allowed: a folder that can be written")


@final
class OutputFolder:
    """An output folder that is open; `open_output` makes it."""

    def __init__(self, path: Path, writer: str) -> None:
        self.path = path
        """The folder."""
        self.writer = writer
        """The command that writes."""
        self.removed: list[str] = []
        """Files of an earlier run that the last draft removed."""
        self._draft = path / STATE / "draft"
        self._manifest = path / STATE / "manifest.json"
        self._records = load_manifest(self._manifest)

    def check(self, names: Iterable[str]) -> None:
        """Refuse to replace what the command did not write, or what was changed since.

        Raises:
            OutputError: with the first such file.
        """
        for name in sorted(names):
            reason = self._find_obstacle(name)
            if reason is not None:
                allowed = "allowed: another folder, or this one once that file is moved away"
                raise OutputError(f"{str(self.path / name)!r} is not replaced: {reason}; {allowed}")

    @contextmanager
    def draft(self, *, is_partial: bool = False) -> Iterator[Path]:
        """A folder to write to, whose files replace those of the output folder at the end of the block.

        Where the block raises, nothing is changed. While files move in, signals that end the command wait.
        ``result.json`` is removed first and comes last, so that it never describes other files than those beside it.

        Args:
            is_partial: whether the command's other files stay; else those that it wrote earlier are removed, except
                those that were changed since.

        Raises:
            OutputError: for a file that cannot be written, by its name in the output folder, or must not be replaced.
        """
        is_filled = False
        try:
            self._draft.mkdir()
            yield self._draft
            is_filled = True
            with hold_signals():
                self._move_in(is_partial)
        except OutputError:
            raise
        except OSError as error:
            place = self._find_place(error)
            if place is None and not is_filled:
                raise
            raise _refuse_file(place or Path(error.filename or self.path), error) from error
        finally:
            shutil.rmtree(self._draft, ignore_errors=True)

    def add_log(self, name: str) -> Path:
        """Take in a file that the command appends to, and return its path; its content is for its reader to check.

        Raises:
            OutputError: where the file is there and not the command's own.
        """
        self.check([name])
        if name not in self._records:
            self._record({name: Record(self.writer, ())})
        return self.path / name

    def _find_obstacle(self, name: str) -> str | None:
        """Why the file must not be replaced, if so."""
        place = self.path / name
        for above in place.parents:
            if above == self.path:
                break
            if os.path.lexists(above) and not above.is_dir():
                return f"{str(above)!r} is no folder"
        if not os.path.lexists(place):
            return None
        record = self._records.get(name)
        if record is None:
            return f"no run of '{self.writer}' wrote it"
        if record.writer != self.writer:
            return f"'{record.writer}' wrote it, and this is '{self.writer}'"
        if self._has_content(name, record.sha256) or (record.sha256 == () and _is_plain(place)):
            return None
        return f"it was changed since '{self.writer}' wrote it"

    def _has_content(self, name: str, digests: Collection[str]) -> bool:
        """Whether a file is there, with one of these contents."""
        place = self.path / name
        try:
            return _is_plain(place) and compute_digest(place) in digests
        except OSError:  # Not readable.
            return False

    def _move_in(self, is_partial: bool) -> None:
        """Replace the output folder's files by the draft's."""
        written = sorted(str(path.relative_to(self._draft)) for path in self._draft.rglob("*") if path.is_file())
        new = {name: compute_digest(sync_file(self._draft / name)) for name in written}
        new = {name: digest for name, digest in new.items() if not self._has_content(name, {digest})}
        self.check(new)
        own = [name for name, record in self._records.items() if record.writer == self.writer and record.sha256]
        stale = [] if is_partial else [name for name in own if name not in written]
        before = {name: self._records[name].sha256 if name in self._records else () for name in new}
        self._record({name: Record(self.writer, (*before[name], digest)) for name, digest in new.items()})
        if "result.json" in new:
            (self.path / "result.json").unlink(missing_ok=True)
        self._remove(stale)
        for name in sorted(new, key=lambda name: name == "result.json"):
            place = self.path / name
            place.parent.mkdir(parents=True, exist_ok=True)
            (self._draft / name).replace(place)
        for name in stale:
            del self._records[name]
        self._record({name: Record(self.writer, (digest,)) for name, digest in new.items()})

    def _remove(self, names: Sequence[str]) -> None:
        """Remove files that were not changed since, and folders that are then empty."""
        self.removed = [name for name in names if self._has_content(name, self._records[name].sha256)]
        for name in self.removed:
            (self.path / name).unlink()
        folders = {above for name in self.removed for above in (self.path / name).parents if self.path in above.parents}
        for folder in sorted(folders, reverse=True):
            with suppress(OSError):  # Not empty.
                folder.rmdir()

    def _record(self, records: dict[str, Record]) -> None:
        """Store records."""
        self._records |= records
        write_manifest(self._manifest, self._records)

    def _find_place(self, error: OSError) -> Path | None:
        """The draft's file that could not be written, by its name in the output folder; None for another file."""
        for name in (error.filename2, error.filename):
            with suppress(TypeError, ValueError):
                return self.path / Path(name).relative_to(self._draft)
        if error.errno not in _FULL:
            return None
        drafts = [path for path in self._draft.rglob("*") if path.is_file()]
        if not drafts:
            return self.path
        return self.path / max(drafts, key=lambda path: path.stat().st_mtime_ns).relative_to(self._draft)


def _is_plain(place: Path) -> bool:
    return place.is_file() and not place.is_symlink()


def _refuse_file(place: Path, error: OSError) -> OutputError:
    reason = error.strerror or str(error)
    return OutputError(f"{str(place)!r} cannot be written: {reason}; allowed: a place that can be made and written")
