"""Kernels that others call through a pointer: compiled once for all of them, and beside them where a core is free.

A kernel that Python calls holds the code of all kernels below it. One that several of those need, and that is large, is
compiled by itself instead. While a kernel that calls it is compiled, a second process compiles it into the cache on
disc, from which this process loads it then. Where that process cannot start, fails or takes too long, this process
compiles it. The machine code is the same either way.
"""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, final

import numba.core.codegen
from numba.core.typing.templates import Signature

from spiraltrunk.processes.parent_death import end_with_parent

_CORE: Any = numba.core
"""Numba's compiler, which has no types, and through it llvmlite."""

_GUARD = "SPIRALTRUNK_COMPILES"
"""Variable that is set in a process that compiles for another one, which starts no further one."""

_PATIENCE = 120.0
"""Longest wait for the second process [s]."""

_PROGRAM = "import sys; sys.path[:] = {path!r}; from {module} import {name}; {name}.serve({parent})"
"""What the second process runs: it finds modules where this one does."""


@final
class SharedKernel:
    """A kernel that others call through a pointer.

    Args:
        kernel: Numba's dispatcher of it.
        sign: its signature, asked for when it is compiled.
        place: module and name where this object stands, by which the second process finds it.
    """

    def __init__(self, kernel: Any, sign: Callable[[], Signature], place: tuple[str, str]) -> None:
        self._kernel, self._sign, self._place = kernel, sign, place
        self._pointer, self._lock = ctypes.c_void_p(), threading.RLock()
        self._process: subprocess.Popen[bytes] | None = None
        self._symbol = ".".join(("spiraltrunk", *place))
        _CORE.codegen.ll.add_symbol(self._symbol, ctypes.addressof(self._pointer))

    def sign(self) -> Signature:
        """Its signature, of which there is one."""
        return self._sign()

    def generate(self, context: Any, builder: Any, call: Signature, values: Any) -> Any:
        """LLVM code of an intrinsic that calls it: through the cell at the symbol's address, which `finish` fills."""
        module, cgutils = builder.module, _CORE.cgutils
        cell = module.globals.get(self._symbol)
        if cell is None:
            cell = cgutils.ir.GlobalVariable(module, cgutils.voidptr_t, self._symbol)
        kind = context.call_conv.get_function_type(call.return_type, call.args)
        function = builder.bitcast(builder.load(cell), kind.as_pointer())
        status, result = context.call_conv.call_function(builder, function, call.return_type, call.args, values)
        with cgutils.if_unlikely(builder, status.is_error):
            context.call_conv.return_status_propagate(builder, status)
        return result

    def begin(self) -> None:
        """Start the second process, unless the machine code is there or one core has to do."""
        with self._lock:
            if self._pointer.value is None and self._process is None and not self._load() and self._can_start():
                self._start()

    def finish(self) -> None:
        """Load the machine code, or compile it: from then on it can be called."""
        with self._lock:
            if self._process is not None:
                self._wait()
            if self._pointer.value is None:
                self._kernel.compile(self._sign().args)
                self._point()

    def serve(self, parent: int) -> None:
        """Compile in the second process, which ends with its parent."""
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # The parent ends this process.
        threading.Thread(target=_wait_for_close, daemon=True).start()
        if end_with_parent(parent):
            self._kernel.compile(self._sign().args)

    def _load(self) -> bool:
        """Whether the machine code is on disc; it is loaded then."""
        kernel, key = self._kernel, self._sign().args
        found = kernel._cache.load_overload(key, kernel.targetctx)
        if found is not None:
            kernel.add_overload(found)
            self._point()
        return found is not None

    def _point(self) -> None:
        done = self._kernel.overloads[tuple(self._sign().args)]
        self._pointer.value = done.library.get_pointer_to_function(done.fndesc.llvm_func_name)

    def _can_start(self) -> bool:
        """Whether a second process can compile: two cores, a cache that is written, and Python's own program."""
        is_python = Path(sys.executable or "").name.startswith("python") and not getattr(sys, "frozen", False)
        is_kept = self._kernel._cache.cache_path is not None and self._kernel._cache._enabled
        return is_python and is_kept and _CORE.config.NUMBA_NUM_THREADS > 1 and _GUARD not in os.environ

    def _start(self) -> None:
        path, (module, name) = [os.path.abspath(part) for part in sys.path], self._place  # noqa: PTH100
        program = _PROGRAM.format(path=path, module=module, name=name, parent=os.getpid())
        flags = subprocess._args_from_interpreter_flags()  # type: ignore[attr-defined]
        folder = _CORE.config.CACHE_DIR
        more = {_GUARD: "1"} | ({"NUMBA_CACHE_DIR": str(folder)} if folder else {})
        with suppress(OSError):
            self._process = subprocess.Popen(
                [sys.executable, *flags, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL, env=os.environ | more,
            )  # fmt: skip

    def _wait(self) -> None:
        process, self._process = self._process, None
        assert process is not None
        try:
            with suppress(subprocess.TimeoutExpired):
                process.wait(_PATIENCE)
        finally:  # Ctrl-C ends it as well.
            process.kill()
            process.wait()
            process.stdin.close()  # type: ignore[union-attr]


def _wait_for_close() -> None:
    """End this process when standard input is closed, which the kernel does at any death of the parent."""
    os.read(0, 1)
    os._exit(0)
