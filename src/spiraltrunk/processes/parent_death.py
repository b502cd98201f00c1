"""The end of a process at the death of its parent, by the kernel."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from contextlib import suppress

_PR_SET_PDEATHSIG = 1
"""Option of prctl(2): the signal that a process gets at the death of the thread that started it."""


def end_with_parent(parent: int) -> bool:
    """Have Linux kill this process at the death of the thread that started it; False where ``parent`` died before.

    Elsewhere it does nothing, and is True.
    """
    if sys.platform != "linux":
        return True
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    return os.getppid() == parent
