"""Signals that end a command: it unwinds as by Ctrl-C, from a moment at which it can be left.

A handler that raises wherever the signal finds the program leaves modules half imported, so that the process crashes as
it ends, and loses the exception where a C library calls back. This one raises only where all Python frames are of
modules that can be left. Else control is deeper in other code, and the exception is raised on the next line of the
frame that called it, by a trace function of Python's.
"""

from __future__ import annotations

import os
import signal
import sys
import time

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from types import FrameType

_MESSAGES = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated", signal.SIGHUP: "hung up"}
"""Signals that end a command, with their messages."""

_OWN = ("spiraltrunk", "__main__")
"""Modules that can be left at any moment."""

_INTERRUPTIBLE = (
    "scipy.optimize", "concurrent.futures._base", "threading", "selectors", "multiprocessing.connection", "subprocess"
)  # fmt: skip
"""Other modules in which a command stays for seconds, and that pass exceptions on: they can be left but in `_WHOLE`.

`contextlib` is not among them: contexts are entered and left whole. Nor is `importlib`.
"""

_WHOLE = ("__init__", "__enter__", "__exit__")
"""Functions of these modules that do not leave half a process, lock or thread behind."""

_COMPILERS, _COMPILING = ("numba", "llvmlite"), "_compile_for_args"
"""Modules that can be left below this function of Numba's.

Elsewhere compiled code calls them, for the type of an argument or to return an array, and ignores their exceptions: it
then goes on without, ends with a SystemError or returns a tuple with null pointers, at which Python crashes.
"""

_CACHES = ("numba.core.caching",)
"""Modules among these that would leave a temporary file."""

_REPEAT_TIME = 1.0
"""Time within which a repeated signal counts as the same [s]: ``timeout`` signals a process and then its group."""


class Terminated(KeyboardInterrupt):
    """The command was ended by a signal."""

    def __init__(self, number: int) -> None:
        self.code = 128 + number
        """Exit code, by the convention of shells."""
        super().__init__(_MESSAGES[signal.Signals(number)])


def end_at_once() -> None:
    """End the process at a signal from now on, with a line: nothing is begun yet that would have to be tidied up."""

    def end(number: int, frame: FrameType | None) -> None:
        try:
            os.write(2, f"spiraltrunk: {_MESSAGES[signal.Signals(number)]}\n".encode())
        finally:
            os._exit(128 + number)

    for number in _find_heard():
        signal.signal(number, end)


def run_interruptibly(command: Callable[[], int]) -> int:
    """Exit code of a command; signals that are ignored, as by ``nohup``, stay ignored.

    Ctrl-C and a signal are told in one line. A second signal, later than `_REPEAT_TIME`, ends the process at once.
    """
    from spiraltrunk.cli.output import INTERRUPTED, complain  # As late as this: the module has to be loaded early.

    interruption = _Interruption(sys._getframe())
    before, hook = {number: signal.getsignal(number) for number in _find_heard()}, sys.unraisablehook
    try:
        for number in before:
            signal.signal(number, interruption.handle)
        sys.unraisablehook = interruption.recover
    except ValueError:  # Not in the main thread, which alone hears signals.
        return command()
    try:
        try:
            return command()
        finally:
            interruption.is_over = True
    except KeyboardInterrupt as stop:
        return complain(str(stop) or _MESSAGES[signal.SIGINT], getattr(stop, "code", INTERRUPTED))
    finally:
        sys.unraisablehook = hook
        for number, handler in before.items():
            signal.signal(number, handler)


def _find_heard() -> list[int]:
    """Signals that are not ignored."""
    return [number for number in _MESSAGES if signal.getsignal(number) not in (signal.SIG_IGN, None)]


class _Interruption:
    """A signal, and the exception that it becomes."""

    def __init__(self, bottom: FrameType) -> None:
        self._bottom = bottom
        """Frame that calls the command."""
        self.is_over = False
        """Whether the command has ended, and nothing is left to tidy up."""
        self._hook = sys.unraisablehook
        self._stop: Terminated | None = None
        self._time = 0.0

    def handle(self, number: int, frame: FrameType | None) -> None:
        """Handle a signal that has found the program in this frame.

        Raises:
            Terminated: where that frame can be left at once.
        """
        if self._stop is not None:
            if time.monotonic() - self._time >= _REPEAT_TIME:
                os._exit(self._stop.code)
            return
        if self.is_over:
            os._exit(128 + number)
        self._stop, self._time = Terminated(number), time.monotonic()
        leaving = self._find_leaving(frame)
        _trace(leaving, self._leave)  # Also where it is raised here: code in C may call this, and lose the exception.
        if leaving is frame:
            raise self._stop

    def recover(self, unraisable: sys.UnraisableHookArgs) -> None:
        """Raise the exception once more where it was lost, as in a destructor; other lost exceptions are printed."""
        if self._stop is not None and unraisable.exc_value is self._stop:
            _trace(self._find_leaving(sys._getframe(1)), self._leave)
        else:
            self._hook(unraisable)

    def _find_leaving(self, frame: FrameType | None) -> FrameType | None:
        """The innermost frame that can be left, with all those that it is called by."""
        stack = []
        while frame is not None and frame is not self._bottom:
            stack.append(frame)
            frame = frame.f_back
        leaving = stack[0] if stack else frame
        for i, inner in enumerate(stack):
            is_compiling = any(outer.f_code.co_name == _COMPILING for outer in stack[i:])
            if not _is_interruptible(inner, is_compiling=is_compiling):
                leaving = inner.f_back
        return leaving

    def _leave(self, frame: FrameType, event: str, argument: object) -> None:
        """Raise the exception, as a trace function."""
        sys.settrace(None)
        frame.f_trace = None
        if self._stop is not None:
            raise self._stop


def _is_interruptible(frame: FrameType, *, is_compiling: bool) -> bool:
    module = frame.f_globals.get("__name__", "")
    if _is_below(module, _COMPILERS):
        return is_compiling and not _is_below(module, _CACHES)
    return _is_below(module, _OWN) or (_is_below(module, _INTERRUPTIBLE) and frame.f_code.co_name not in _WHOLE)


def _is_below(module: str, packages: tuple[str, ...]) -> bool:
    return any(module == package or module.startswith(f"{package}.") for package in packages)


def _trace(frame: FrameType | None, leave: Callable[[FrameType, str, object], None]) -> None:
    """Call a function on the next line of a frame that has called others, or as it returns."""
    if frame is not None:
        frame.f_trace = leave
        sys.settrace(lambda frame, event, argument: None)
