"""Process pool in which an exception or the death of a process costs one job, and which can be stopped at once.

The pools of the standard library are unusable after the death of a process, do not say which job it had, and leave
processes behind where the parent is killed.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import islice
from multiprocessing import Pipe, connection
from multiprocessing.reduction import ForkingPickler
from multiprocessing.spawn import get_preparation_data
from typing import Any, Generic, TypeVar, final

from spiraltrunk.errors import RunError
from spiraltrunk.processes import worker as worker_process

Job = TypeVar("Job")
Result = TypeVar("Result")

THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
"""Variables that limit the threads of libraries."""

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Signals that a terminal sends to all its processes; the main process alone handles them."""

_PROGRAM = "import sys; sys.path[:] = {path!r}; from spiraltrunk.processes.worker import serve; serve({arguments})"
"""What a process runs: it finds modules where its parent does."""


@final
@dataclass(frozen=True, kw_only=True)
class Outcome(Generic[Job, Result]):
    """Outcome of a job."""

    job: Job
    """The job."""
    result: Result | None
    """Return value of the work; None for a fault."""
    fault: str | None = None
    """The exception, or the exit of the process."""
    error: Exception | None = None
    """The exception itself, where it can be sent between processes."""

    def unwrap(self) -> Result:
        """The result.

        Raises:
            Exception: the work's own.
            RunError: where it cannot be sent, or the process died.
        """
        if self.fault is not None:
            raise self.error or RunError(self.fault)
        return self.result  # type: ignore[return-value]


Engine = Callable[[Callable[[Any], Any], Iterable[Any], int], Generator[Outcome[Any, Any], None, None]]
"""What runs jobs in processes: takes the work, the jobs and the number of processes, as `run_jobs`."""


def run_jobs(
    work: Callable[[Job], Result], jobs: Iterable[Job], workers: int
) -> Generator[Outcome[Job, Result], None, None]:
    """Outcomes in the order of completion. Closing the iterator stops all processes.

    Args:
        work: a callable that can be pickled, such as a function of a module.
        jobs: its arguments, each used once.
        workers: number of processes.

    Raises:
        RunError: where a process ends before it could take a job.
        OSError: where a process cannot be started.
    """
    waiting = iter(jobs)
    pool: list[_Worker[Job, Result]] = []
    try:
        first = list(islice(waiting, workers))
        for _ in first:
            pool.append(_Worker())
        for worker, job in zip(pool, first, strict=True):
            worker.begin(work, job)
        while pool:
            pipes = {worker.pipe: worker for worker in pool}
            for pipe in connection.wait(list(pipes)):
                worker = pipes[pipe]  # type: ignore[index]
                outcome = worker.receive()
                if outcome is not None:
                    _continue(pool, worker, work, waiting)
                    yield outcome
    finally:
        for worker in pool:
            worker.kill()
        for worker in pool:
            worker.close()


def _continue(
    pool: list[_Worker[Job, Result]],
    worker: _Worker[Job, Result],
    work: Callable[[Job], Result],
    waiting: Iterator[Job],
) -> None:
    """Give the next job to a worker that has completed one, or to a new worker if its process died."""
    for job in islice(waiting, 1):
        if not worker.is_dead:
            worker.send(job)
            return
        pool.append(_Worker())
        pool[-1].begin(work, job)
    pool.remove(worker)
    worker.kill()
    worker.close()


@final
class _Worker(Generic[Job, Result]):
    """A process and its current job. The process ends when this end of its pipe is closed."""

    def __init__(self) -> None:
        if worker_process.is_importing_main:
            allowed = "allowed: where that is guarded by if __name__ == '__main__'"
            raise RunError(f"a process imports its main module, which starts processes; {allowed}")
        self.pipe, theirs = Pipe()
        self.is_ready, self.is_dead = False, False
        self.job: Job | None = None
        is_main = threading.current_thread() is threading.main_thread()
        arguments = f"{theirs.fileno()}, {os.getpid()}, is_main={is_main}"
        program = _PROGRAM.format(path=[os.path.abspath(path) for path in sys.path], arguments=arguments)  # noqa: PTH100
        flags = subprocess._args_from_interpreter_flags()  # type: ignore[attr-defined]
        with theirs, _mask_signals():
            self.process = subprocess.Popen(
                [sys.executable, *flags, "-c", program], pass_fds=[theirs.fileno()], stdin=subprocess.DEVNULL,
                env=os.environ | dict.fromkeys(THREADS, "1"),
            )  # fmt: skip

    def begin(self, work: Callable[[Job], Result], job: Job) -> None:
        """Send the work and the first job, and before them how to import the main module, if they need it."""
        self.job = job
        messages = [bytes(ForkingPickler.dumps(part)) for part in (work, job)]
        main = get_preparation_data("worker") if any(b"__main__" in message for message in messages) else {}
        main.pop("authkey", None)  # A key is not sent.
        with suppress(OSError):
            self.pipe.send(main)
            for message in messages:
                self.pipe.send_bytes(message)

    def send(self, job: Job) -> None:
        """Send a job; the death of the process is detected by `receive`."""
        self.job = job
        with suppress(OSError):
            self.pipe.send(job)

    def receive(self) -> Outcome[Job, Result] | None:
        """Outcome of the job; None for the message that the process is ready."""
        try:
            message = self.pipe.recv()
        except (EOFError, OSError):
            return self._reap()
        if message == worker_process.READY:
            self.is_ready = True
            return None
        result, fault, error = message
        return Outcome(job=self.job, result=result, fault=fault, error=error)  # type: ignore[arg-type]

    def kill(self) -> None:
        """Kill the process, which holds no resources."""
        self.process.kill()

    def close(self) -> None:
        """Wait for the end of the process and free the pipe."""
        self.process.wait()
        self.pipe.close()

    def _reap(self) -> Outcome[Job, Result]:
        self.is_dead = True
        reason = _name_exit(self.process.wait())
        if not self.is_ready:
            raise RunError(f"a process ended before its first job ({reason}); its messages are above")
        return Outcome(job=self.job, result=None, fault=f"its process died ({reason})")  # type: ignore[arg-type]


def _name_exit(code: int) -> str:
    try:
        return signal.Signals(-code).name
    except ValueError:
        return f"exit code {code}"


@contextmanager
def _mask_signals() -> Iterator[None]:
    """Block signals of the terminal; processes started within the block inherit the mask."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
