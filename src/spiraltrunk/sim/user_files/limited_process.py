"""A process of its own with limits of time and memory, for libraries that hear no Ctrl-C and trust their input."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from spiraltrunk.sim.user_files.regular_file import refusal

MEMORY_MOST = 4 << 30
"""Largest address space of the process [bytes]; MuJoCo's libraries alone take 0.3 GB."""

_CHILD = Path(__file__).with_name("limited_child.py")


def run_limited(task: str, sent: bytes, *, seconds: int, what: str) -> bytes:
    """What a task of `limited_child` writes; the process is ended with the call, also by Ctrl-C, and with its parent.

    Args:
        task: compile or decompose.
        sent: its input.
        seconds: longest time, the start of the process included [s].
        what: name of the file in errors.

    Raises:
        DesignError: where it took longer, or ended otherwise than with a result.
    """
    # One arena: each thread's own would reserve address space.
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MALLOC_ARENA_MAX": "1"}
    environment.pop("MUJOCO_GL", None)
    command = [sys.executable, "-P", str(_CHILD), task, *map(str, (os.getpid(), seconds, MEMORY_MOST))]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment
    ) as child:
        try:
            result, _ = child.communicate(sent, timeout=seconds)
        except subprocess.TimeoutExpired:
            raise refusal(what, f"too slow to {task}", f"at most {seconds} s; a coarser one is faster") from None
        finally:
            child.kill()
    if child.returncode or not result:
        limits = f"what takes at most {seconds} s and {MEMORY_MOST >> 30} GB to {task}"
        raise refusal(what, f"one at which the process ended with code {child.returncode}", limits)
    return result
