"""JIT compilation of the model kernels with Numba, and their parallel execution."""

from __future__ import annotations

import gc
import hashlib
import logging
import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, TypeVar, cast, final

from numba import njit
from numba.core import event

from spiraltrunk.model import linking, shared_kernel
from spiraltrunk.model.kernel_cache import keep
from spiraltrunk.model.linking import LINKED_WHOLE, PART
from spiraltrunk.model.shared_kernel import SharedKernel

_F = TypeVar("_F", bound=Callable[..., Any])

_OPTIONS: dict[str, Any] = {"error_model": "numpy", "nogil": True, "no_cfunc_wrapper": True}
"""Numba's options of every kernel."""


@final
class _Notice(event.Listener):
    """Log once that kernels are being compiled; kernels loaded from the disc cache are not logged.

    Meanwhile Python does not look for garbage, of which the compiler makes little: that takes a fifth of the time.
    """

    is_told, depth, was_collecting = False, 0, False

    def on_start(self, event: event.Event) -> None:
        if not self.is_told:
            self.is_told = True
            words = "compiling the models, once after they were installed or changed: up to 15 s a model"
            logging.getLogger("spiraltrunk").info(words)
        if self.depth == 0:
            self.was_collecting = gc.isenabled()
            gc.disable()
        self.depth += 1

    def on_end(self, event: event.Event) -> None:
        self.depth -= 1
        if self.depth == 0 and self.was_collecting:
            gc.enable()


event.register("numba:compile", _Notice())  # type: ignore[no-untyped-call]


def hash_files(files: Iterable[Path]) -> str:
    """SHA-256 of the files' contents, in the order of their paths, and of the three files that say how to compile them.

    Raises:
        FileNotFoundError: where there is no file, since a digest of nothing would never change.
    """
    found = sorted(files)
    if not found:
        raise FileNotFoundError("no source file to hash: the digest would not change with the code")
    compiling = map(Path, (__file__, linking.__file__, shared_kernel.__file__))
    return hashlib.sha256(b"".join(file.read_bytes() for file in (*found, *compiling))).hexdigest()


def compiler(
    stamp: str, *, owns_arrays: bool = True, is_alone: bool = False, calls: SharedKernel | None = None
) -> Callable[[_F], _F]:
    """A decorator that compiles functions which call each other, from files whose `hash_files` is ``stamp``.

    Numba by itself optimises a function and makes it machine code before it goes into those that call it, where that is
    done again. Here it is done once, in the function that Python calls, which takes half of the time.

    The machine code is kept on disc, for as long as the stamp does not change: Numba by itself looks at the file of a
    function alone, and would go on with old code of the functions that it calls. It runs free of Python's lock, so that
    threads share a batch, and a division by zero is an infinity, which the callers refuse.

    Args:
        stamp: as above.
        owns_arrays: whether a function makes arrays, or returns them to one that counts who refers to them. One that
            does neither can do without counting, which takes a fourth of an equilibrium's time.
        is_alone: whether a function is optimised by itself first, as Numba does it, which keeps its loops vectorised.
        calls: a kernel that it calls through a pointer, or one of those that it calls does.
    """
    options, compile_function = _OPTIONS | {"_nrt": owns_arrays}, cast("Any", njit)

    def compiled(function: _F) -> _F:
        law: Any = compile_function(**options, pipeline_class=LINKED_WHOLE)(function)
        if law is function:  # With NUMBA_DISABLE_JIT.
            return function
        keep(law, stamp)
        if calls is not None:
            _compile_beside(law, calls)
        if not is_alone:
            part: Any = compile_function(**options, no_cpython_wrapper=True, pipeline_class=PART)(function)
            law.get_call_template, law.get_overload = part.get_call_template, part.get_overload
        return law

    return compiled


def compile_shared(function: _F, stamp: str) -> _F:
    """The kernel of a `SharedKernel`, which Python does not call."""
    compile_function: Any = njit
    law = compile_function(**_OPTIONS, _nrt=False, no_cpython_wrapper=True, pipeline_class=LINKED_WHOLE)(function)
    if law is not function:
        keep(law, stamp)
    return cast("_F", law)


def _compile_beside(law: Any, called: SharedKernel) -> None:
    """Let a kernel's compilation begin with that of the one it calls, and wait for that before it can be called."""
    compile_itself, add_itself = law._compiler.compile, law.add_overload

    def compile_both(*signature: Any) -> Any:
        called.begin()
        return compile_itself(*signature)

    def add_after(result: Any) -> None:
        called.finish()
        add_itself(result)

    law._compiler.compile, law.add_overload = compile_both, add_after


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
