"""Process pool in which an exception or the death of a process costs one job, and which can be stopped at once.

The pools of the standard library are unusable after the death of a process, and do not say which job it had.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import islice
from multiprocessing import connection, resource_tracker
from typing import Generic, TypeVar, final

from spiraltrunk.errors import RunError

Job = TypeVar("Job")
Result = TypeVar("Result")

_READY = "ready"
"""Message of a process that has imported its work."""

_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
"""Variables that limit the threads of libraries."""

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Signals that a terminal sends to all its processes; the main process alone handles them."""


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


def run_jobs(
    work: Callable[[Job], Result], jobs: Iterable[Job], workers: int
) -> Generator[Outcome[Job, Result], None, None]:
    """Outcomes in the order of completion. Closing the iterator stops all processes.

    Args:
        work: a function of a module, importable in spawned processes.
        jobs: its arguments, each used once.
        workers: number of processes.

    Raises:
        RunError: where a process ends before it could take a job.
    """
    waiting = iter(jobs)
    pool: list[_Worker[Job, Result]] = []
    try:
        for job in islice(waiting, workers):
            pool.append(_Worker(work, job))
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
            worker.stop()


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
        pool.append(_Worker(work, job))
    pool.remove(worker)
    worker.stop()


@final
class _Worker(Generic[Job, Result]):
    """A process and its current job."""

    def __init__(self, work: Callable[[Job], Result], job: Job) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self.is_ready, self.is_dead = False, False
        self.process = context.Process(target=_serve, args=(theirs,), daemon=True)
        with _mask_signals():
            self.process.start()
        theirs.close()
        self.send(work)
        self.send(job)

    def send(self, what: Job | Callable[[Job], Result]) -> None:
        """Send the work, then jobs; the death of the process is detected by `receive`."""
        self.job = what
        with suppress(OSError):
            self.pipe.send(what)

    def receive(self) -> Outcome[Job, Result] | None:
        """Outcome of the job; None for the message that the process is ready."""
        try:
            message = self.pipe.recv()
        except (EOFError, OSError):
            return self._reap()
        if message == _READY:
            self.is_ready = True
            return None
        result, fault = message
        return Outcome(job=self.job, result=result, fault=fault)  # type: ignore[arg-type]

    def stop(self) -> None:
        """Kill the process, which holds no resources."""
        self.process.kill()
        self.process.join()
        self.pipe.close()

    def _reap(self) -> Outcome[Job, Result]:
        self.is_dead = True
        self.process.join()
        reason = _name_exit(self.process.exitcode)
        if not self.is_ready:
            raise RunError(f"a process ended before its first trial ({reason}); its messages are above")
        return Outcome(job=self.job, result=None, fault=f"its process died ({reason})")  # type: ignore[arg-type]


def _serve(pipe: connection.Connection) -> None:
    """Main function of a process: work until the other end of the pipe is closed."""
    for name in _THREADS:
        os.environ[name] = "1"
    os.dup2(2, 1)  # Standard output is reserved for the command's result.
    work = pipe.recv()
    with suppress(EOFError, OSError):
        pipe.send(_READY)
        while True:
            pipe.send(_try(work, pipe.recv()))


def _try(work: Callable[[Job], Result], job: Job) -> tuple[Result | None, str | None]:
    try:
        return work(job), None
    except Exception as error:
        return None, format_error(error)


def format_error(error: Exception, most: int = 300) -> str:
    """An exception in one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())[:most]


def _name_exit(code: int | None) -> str:
    try:
        return signal.Signals(-(code or 0)).name
    except ValueError:
        return f"exit code {code}"


@contextmanager
def _mask_signals() -> Iterator[None]:
    """Block signals of the terminal; processes started within the block inherit the mask."""
    resource_tracker.ensure_running()  # Started within the block, it would unblock them.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
