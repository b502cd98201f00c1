"""The C library's heap of a process that serves pages for hours."""

from __future__ import annotations

import ctypes

_TRIM_THRESHOLD, _MMAP_THRESHOLD, _ARENA_MAX = -1, -3, -8
"""Parameters of glibc's ``mallopt``."""

LARGE = 128 * 1024
"""Size from which a block has a mapping of its own, which goes back to the system when it is freed [bytes]: glibc's
own at first, which it raises with every larger block that is freed."""

HEAPS = 2
"""Largest number of heaps [-] (ours): glibc gives up to eight for each core to threads."""


def bound_heap() -> bool:
    """Let freed memory go back to the system, and tell whether the C library can: glibc.

    Acts of a page free arrays and messages in many threads. In many heaps, and between blocks that stay, what was freed
    is kept: in 267 acts a server grew by 10 MB with 57 MB given out all the time, and by 1.4 MB with its heap bounded
    (`benchmarks/studio_server.py`).
    """
    try:
        setter = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError, TypeError):
        return False
    wanted = ((_MMAP_THRESHOLD, LARGE), (_TRIM_THRESHOLD, LARGE), (_ARENA_MAX, HEAPS))
    return all(setter(name, value) == 1 for name, value in wanted)
