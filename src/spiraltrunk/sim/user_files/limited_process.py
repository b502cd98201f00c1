"""Tasks on users' files within limits of time and memory."""

from __future__ import annotations

from pathlib import Path

from spiraltrunk.files import limited_process
from spiraltrunk.sim.user_files.regular_file import refusal

MEMORY_MOST = 4 << 30
"""Largest address space of the process [bytes]; MuJoCo's libraries alone take 0.3 GB."""

_TASKS = Path(__file__).with_name("limited_tasks.py")


def run_limited(task: str, sent: bytes, *, seconds: int, what: str) -> bytes:
    """What a task of `limited_tasks` returns, in a process of its own (`files.limited_process.run_limited`).

    Args:
        task: compile or decompose.
        sent: its input.
        seconds: longest time, the start of the process included [s].
        what: name of the file in errors.

    Raises:
        DesignError: where it took longer, or ended otherwise than with a result.
    """
    try:
        return limited_process.run_limited(_TASKS, task, sent, seconds=seconds, memory=MEMORY_MOST)
    except TimeoutError:
        raise refusal(what, f"too slow to {task}", f"at most {seconds} s; a coarser one is faster") from None
    except ChildProcessError as error:
        limits = f"what takes at most {seconds} s and {MEMORY_MOST >> 30} GB to {task}"
        raise refusal(what, f"one at which the process ended with code {error}", limits) from None
