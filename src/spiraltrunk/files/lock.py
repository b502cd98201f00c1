"""Locks: a file that one process at a time holds. The kernel releases it however the process ends."""

from __future__ import annotations

import errno
import fcntl
import logging
import os
from contextlib import suppress
from pathlib import Path

_UNSUPPORTED = {errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP}
"""Errors of file systems that have no locks."""


def acquire_lock(path: Path) -> int:
    """Create the file where it is missing, lock it, and return its descriptor; closing that releases the lock.

    Where the file system has no locks, a warning is logged, and the descriptor is returned all the same.

    Raises:
        BlockingIOError: where another process holds the lock.
        OSError: where the file cannot be made.
    """
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            _lock(descriptor, path)
            if _is_at(path, descriptor):  # Else its last holder has just removed it.
                return descriptor
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)


def release_lock(path: Path, descriptor: int) -> None:
    """Remove a locked file, where it is still there, and release the lock."""
    with suppress(OSError):
        if _is_at(path, descriptor):
            path.unlink()
    os.close(descriptor)


def remove_abandoned(path: Path) -> None:
    """Remove a file that was locked by a process which has ended; leave it where the process lives."""
    with suppress(OSError):  # Locked, gone, or not ours.
        descriptor = os.open(path, os.O_RDWR)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            path.unlink()
        finally:
            os.close(descriptor)


def _lock(descriptor: int, path: Path) -> None:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno not in _UNSUPPORTED:
            raise
        reason = f"{str(path)!r} cannot be locked ({error.strerror})"
        logging.getLogger("spiraltrunk").warning("%s: see that no other process writes to this folder", reason)


def _is_at(path: Path, descriptor: int) -> bool:
    """Whether the path still names the open file."""
    try:
        return os.path.samestat(path.stat(), os.fstat(descriptor))
    except FileNotFoundError:
        return False
