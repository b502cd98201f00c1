"""How the model's laws are compiled and shared among the cores."""

from __future__ import annotations

import hashlib
import logging
import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, TypeVar, final

from numba import njit
from numba.core import event

_F = TypeVar("_F", bound=Callable[..., Any])


@final
class _Notice(event.Listener):
    """Logs once why nothing comes; what is found on disc is not compiled and not told."""

    is_told = False

    def on_start(self, event: event.Event) -> None:
        if not self.is_told:
            self.is_told = True
            words = "compiling the models, once after they were installed or changed: up to some minutes"
            logging.getLogger("spiraltrunk").info(words)

    def on_end(self, event: event.Event) -> None:
        pass


event.register("numba:compile", _Notice())  # type: ignore[no-untyped-call]


def hash_files(files: Iterable[Path]) -> str:
    """SHA-256 of the files' contents, in the order of their paths.

    Raises:
        FileNotFoundError: where there is no file, since a digest of nothing would never change.
    """
    found = sorted(files)
    if not found:
        raise FileNotFoundError("no source file to hash: the digest would not change with the code")
    return hashlib.sha256(b"".join(file.read_bytes() for file in found)).hexdigest()


def compiler(stamp: str, *, is_inlined: bool = False, owns_arrays: bool = True) -> Callable[[_F], _F]:
    """A decorator that compiles functions which call each other, from files whose `hash_files` is ``stamp``.

    The machine code is kept on disc, for as long as the stamp does not change: Numba by itself looks at the file of a
    function alone, and would go on with old code of the functions that it calls. It runs free of Python's lock, so that
    threads share a batch, and a division by zero is an infinity, which the callers refuse.

    Args:
        stamp: as above.
        is_inlined: whether a function is compiled in those alone that call it. Machine code holds that of all the
            functions it calls, so of a large one that few call this spares a copy.
        owns_arrays: whether a function makes arrays, or returns them to one that counts who refers to them. One that
            does neither can do without counting, which takes a fourth of an equilibrium's time.
    """
    options: dict[str, Any] = {
        "cache": True, "error_model": "numpy", "inline": "always" if is_inlined else "never", "nogil": True,
        "no_cfunc_wrapper": True, "_nrt": owns_arrays,
    }  # fmt: skip

    def compiled(function: _F) -> _F:
        law: Any = njit(**options)(function)
        stored = getattr(getattr(law, "_cache", None), "_cache_file", None)
        if stored is not None:  # With NUMBA_DISABLE_JIT there is none.
            stored._source_stamp = stamp
        return law

    return compiled


def share(solve: Callable[[int, int], object], count: int, chunk: int) -> None:
    """Call ``solve(first, last)`` on chunks of 0 to ``count`` in as many threads as there are cores.

    The first chunk is solved alone, so that what must be compiled is compiled once; on one core all are. Between chunks
    Ctrl-C is heard.
    """
    if count <= chunk:
        solve(0, count)
        return
    spans = [(first, min(first + chunk, count)) for first in range(0, count, chunk)]
    cores = len(os.sched_getaffinity(0))
    alone = 1 if cores > 1 else len(spans)
    for span in spans[:alone]:
        solve(*span)
    if alone == len(spans):
        return
    pool = ThreadPoolExecutor(cores)
    try:
        list(pool.map(lambda span: solve(*span), spans[alone:]))
    finally:
        pool.shutdown(cancel_futures=True)
