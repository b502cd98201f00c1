"""Main function of a process with limits of time and memory, which `limited_process` starts and ends.

A script: ``python -P limited_child.py FILE TASK PARENT SECONDS BYTES`` calls the function ``run_TASK`` of a file with
the bytes of standard input, and writes the bytes that it returns to standard output. It imports nothing of the package.
"""

from __future__ import annotations

import ctypes
import os
import resource
import runpy
import signal
import sys

_PR_SET_PDEATHSIG = 1
"""Option of prctl(2): the signal that a process gets at the death of its parent."""


def main() -> None:
    """Limit this process, do the task, and write its result."""
    file, task = sys.argv[1:3]
    parent, seconds, memory = map(int, sys.argv[3:])
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # The parent ends this process.
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        return
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with os.fdopen(os.dup(1), "wb") as output:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # What libraries print is no result.
        output.write(runpy.run_path(file)[f"run_{task}"](sys.stdin.buffer.read()))


if __name__ == "__main__":
    main()
