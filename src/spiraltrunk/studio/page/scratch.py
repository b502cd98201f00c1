"""Temporary files of the studio: one folder a server, which the next server removes where this one was killed."""

from __future__ import annotations

import atexit
import fcntl
import os
import shutil
import tempfile
import threading
import time
from pathlib import Path

_PREFIX = "spiraltrunk-studio-"

_LOCK = "in_use"
"""File that a server holds a lock on for as long as it lives, however it ends."""

_YOUNG = 60.0
"""Age up to which a folder without that file may still get it [s]."""

_opening = threading.Lock()
_roots: list[Path] = []
"""The folder of this process, once it is made."""


def make_scratch(name: str) -> Path:
    """A new, empty folder.

    Raises:
        OSError: where it cannot be made, as on a full disc.
    """
    return Path(tempfile.mkdtemp(prefix=f"{name}-", dir=_find_root()))


def remove_scratch() -> None:
    """Remove the folder of this process, with all in it; one that ends without its exit handlers calls it."""
    with _opening:
        while _roots:
            shutil.rmtree(_roots.pop(), ignore_errors=True)


def _find_root() -> Path:
    with _opening:
        if not _roots or not _roots[-1].is_dir():
            parent = Path(tempfile.gettempdir())
            _remove_left(parent)
            root = Path(tempfile.mkdtemp(prefix=_PREFIX, dir=parent))
            _hold(root)
            atexit.register(shutil.rmtree, root, ignore_errors=True)
            _roots.append(root)
        return _roots[-1]


def _remove_left(parent: Path) -> None:
    """Remove the folders of servers that are gone."""
    for folder in parent.glob(f"{_PREFIX}*"):
        try:
            is_left = folder.stat().st_uid == os.getuid() and _is_left(folder)
        except OSError:  # Another server removes it.
            continue
        if is_left:
            shutil.rmtree(folder, ignore_errors=True)


def _is_left(folder: Path) -> bool:
    try:
        with (folder / _LOCK).open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except FileNotFoundError:
        return time.time() - folder.stat().st_mtime > _YOUNG
    except BlockingIOError:
        return False
    return True


def _hold(folder: Path) -> None:
    """Lock it until this process ends; the file is never closed."""
    descriptor = os.open(folder / _LOCK, os.O_CREAT | os.O_RDWR, 0o600)
    fcntl.flock(descriptor, fcntl.LOCK_EX)
