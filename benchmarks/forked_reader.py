"""Stands in for `spiraltrunk.files.limited_process.run_limited` where thousands of files are read.

Each file still has a process of its own with the same limits of time and memory, and how that process ends is told of
its file alone. Only the start of Python and the import of libraries are saved: the process is forked from a small one
that has imported them. As a program this file is the small process.
"""

from __future__ import annotations

import os
import pickle
import resource
import runpy
import selectors
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, BinaryIO

LIBRARIES = ("numpy", "ezc3d")
"""What the small process imports."""


class ForkedReader:
    """Processes forked from a small one, which ends with this object's process."""

    def __init__(self) -> None:
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MALLOC_ARENA_MAX": "1"}
        self.process = subprocess.Popen(
            [sys.executable, "-P", __file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment
        )

    def run(self, file: Path, task: str, sent: bytes, *, seconds: int, memory: int) -> bytes:
        """As `run_limited`.

        Raises:
            TimeoutError: where the task took longer.
            ChildProcessError: where its process ended otherwise than with a result; with its exit code.
        """
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        pickle.dump((str(file), task, sent, seconds, memory), self.process.stdin)
        self.process.stdin.flush()
        code, result = pickle.load(self.process.stdout)
        if code is None:
            raise TimeoutError(f"at most {seconds} s")
        if code or not result:
            raise ChildProcessError(code)
        return bytes(result)


def serve(requests: BinaryIO, answers: BinaryIO) -> None:
    """Fork a process for each request; answer with its exit code, None where it is late, and its result."""
    while True:
        try:
            request = pickle.load(requests)
        except EOFError:
            return
        pickle.dump(_answer(*request), answers)
        answers.flush()


def _answer(file: str, task: str, sent: bytes, seconds: int, memory: int) -> tuple[int | None, bytes]:
    source, sink = os.pipe()
    number = os.fork()
    if number == 0:
        code = 1
        try:
            os.close(source)
            _limit(seconds, memory)
            with os.fdopen(sink, "wb") as output:
                output.write(runpy.run_path(file)[f"run_{task}"](sent))
            code = 0
        finally:
            os._exit(code)
    os.close(sink)
    result = _read_until(source, time.monotonic() + seconds)
    if result is None:
        os.kill(number, 9)
    status = os.waitpid(number, 0)[1]
    return (None, b"") if result is None else (os.waitstatus_to_exitcode(status), result)


def _limit(seconds: int, memory: int) -> None:
    """What `limited_child` limits, and no output of libraries."""
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    nothing = os.open(os.devnull, os.O_RDWR)
    for number in (0, 1, 2):
        os.dup2(nothing, number)


def _read_until(source: int, end: float) -> bytes | None:
    """All that a pipe holds until it is closed; None where that is later than ``end``."""
    parts: list[Any] = []
    with os.fdopen(source, "rb", buffering=0) as pipe, selectors.DefaultSelector() as selector:
        selector.register(pipe, selectors.EVENT_READ)
        while selector.select(max(0.0, end - time.monotonic())):
            part = pipe.read(1 << 20)
            if not part:
                return b"".join(parts)
            parts.append(part)
    return None


if __name__ == "__main__":
    for library in LIBRARIES:
        __import__(library)
    serve(sys.stdin.buffer, sys.stdout.buffer)
