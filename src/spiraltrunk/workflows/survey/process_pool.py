"""Jobs in processes of their own: one that raises or dies costs its job alone, and all of them end at once.

The pools of the standard library give up as a whole when a process dies, and do not say at which job it died.
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
"""What a process says once it has imported its work."""

_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
"""Variables by which libraries learn how many threads they may use."""

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""What a terminal sends to every process: the one that the user started alone shall answer."""


@final
@dataclass(frozen=True, kw_only=True)
class Outcome(Generic[Job, Result]):
    """What came of a job."""

    job: Job
    """The job."""
    result: Result | None
    """What the work returned; None where it did not."""
    fault: str | None = None
    """Why it did not: what it raised, or how its process died."""


def run_jobs(
    work: Callable[[Job], Result], jobs: Iterable[Job], workers: int
) -> Generator[Outcome[Job, Result], None, None]:
    """Outcomes as they come. To leave early, close the iterator: then no process stays.

    Args:
        work: a function of a module, importable where processes start afresh.
        jobs: what it is called with, each once.
        workers: how many processes share the jobs.

    Raises:
        RunError: where a process ends before it could take a job.
    """
    waiting = iter(jobs)
    hands: list[_Hand[Job, Result]] = []
    try:
        for job in islice(waiting, workers):
            hands.append(_Hand(work, job))
        while hands:
            pipes = {hand.pipe: hand for hand in hands}
            for pipe in connection.wait(list(pipes)):
                hand = pipes[pipe]  # type: ignore[index]
                outcome = hand.take()
                if outcome is not None:
                    _go_on(hands, hand, work, waiting)
                    yield outcome
    finally:
        for hand in hands:
            hand.stop()


def _go_on(
    hands: list[_Hand[Job, Result]], hand: _Hand[Job, Result], work: Callable[[Job], Result], waiting: Iterator[Job]
) -> None:
    """Give the next job to the process that has ended its own, or to a new one in its place."""
    for job in islice(waiting, 1):
        if not hand.is_gone:
            hand.give(job)
            return
        hands.append(_Hand(work, job))
    hands.remove(hand)
    hand.stop()


@final
class _Hand(Generic[Job, Result]):
    """A process and the job that it has."""

    def __init__(self, work: Callable[[Job], Result], job: Job) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self.is_ready, self.is_gone = False, False
        self.process = context.Process(target=_labour, args=(theirs,), daemon=True)
        with _deaf():
            self.process.start()
        theirs.close()
        self.give(work)
        self.give(job)

    def give(self, what: Job | Callable[[Job], Result]) -> None:
        """Send a job, or the work before the first; where the process has died, `take` will tell."""
        self.job = what
        with suppress(OSError):
            self.pipe.send(what)

    def take(self) -> Outcome[Job, Result] | None:
        """What came of the job; None where the process said that it is ready."""
        try:
            said = self.pipe.recv()
        except (EOFError, OSError):
            return self._bury()
        if said == _READY:
            self.is_ready = True
            return None
        result, fault = said
        return Outcome(job=self.job, result=result, fault=fault)  # type: ignore[arg-type]

    def stop(self) -> None:
        """End the process at once: it keeps nothing that another needs."""
        self.process.kill()
        self.process.join()
        self.pipe.close()

    def _bury(self) -> Outcome[Job, Result]:
        self.is_gone = True
        self.process.join()
        how = _name_exit(self.process.exitcode)
        if not self.is_ready:
            raise RunError(f"a process ended before its first trial ({how}); what it said is above")
        return Outcome(job=self.job, result=None, fault=f"its process died ({how})")  # type: ignore[arg-type]


def _labour(pipe: connection.Connection) -> None:
    """Work in a process of its own until the other end of the pipe is closed."""
    for name in _THREADS:
        os.environ[name] = "1"
    os.dup2(2, 1)  # The answer's standard output is no place for what a library prints.
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
    """An error in one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())[:most]


def _name_exit(code: int | None) -> str:
    try:
        return signal.Signals(-(code or 0)).name
    except ValueError:
        return f"exit code {code}"


@contextmanager
def _deaf() -> Iterator[None]:
    """Within the block no signal of the terminal is heard; what starts in it never hears one."""
    resource_tracker.ensure_running()  # Else it starts within, and lets them through.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
