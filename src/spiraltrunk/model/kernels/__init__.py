"""Compiled laws of the equilibrium: scalar code for Numba, one trunk at a time, no checks (those are made outside)."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import njit


def _hash_sources() -> str:
    files = sorted(Path(__file__).parent.glob("*.py"))
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


STAMP = _hash_sources()
"""What the machine code on disc must have been compiled from.

Numba looks at the file of a kernel alone and would go on with old code of the kernels that it calls.
"""


def compiled(function: Callable[..., Any]) -> Any:
    """How every kernel is compiled.

    Kept on disc; free of Python's lock, so that threads share a batch; a division by zero is an infinity, which the
    solver refuses.
    """
    kernel = njit(cache=True, error_model="numpy", nogil=True)(function)
    stored = getattr(getattr(kernel, "_cache", None), "_cache_file", None)
    if stored is not None:  # With NUMBA_DISABLE_JIT there is none.
        stored._source_stamp = STAMP
    return kernel
