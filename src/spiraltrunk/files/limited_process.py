"""A process of its own with limits of time and memory, for libraries that hear no Ctrl-C and trust their input."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

_CHILD = Path(__file__).with_name("limited_child.py")


def run_limited(file: Path, task: str, sent: bytes, *, seconds: int, memory: int) -> bytes:
    """What the function ``run_TASK`` of a file returns for ``sent``.

    The process is ended with the call, also by Ctrl-C, and with its parent.

    Args:
        file: Python source, which is run without the package.
        task: the function's name behind ``run_``.
        sent: its argument.
        seconds: longest time, the start of the process included [s].
        memory: largest address space of the process [bytes].

    Raises:
        TimeoutError: where it took longer.
        ChildProcessError: where it ended otherwise than with a result; with its exit code.
    """
    # One arena: each thread's own would reserve address space.
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MALLOC_ARENA_MAX": "1"}
    environment.pop("MUJOCO_GL", None)
    command = [sys.executable, "-P", str(_CHILD), str(file), task, *map(str, (os.getpid(), seconds, memory))]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment
    ) as child:
        try:
            result, _ = child.communicate(sent, timeout=seconds)
        except subprocess.TimeoutExpired:
            raise TimeoutError(f"at most {seconds} s") from None
        finally:
            child.kill()
    if child.returncode or not result:
        raise ChildProcessError(child.returncode)
    return result
