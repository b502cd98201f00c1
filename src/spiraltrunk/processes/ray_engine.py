"""Jobs on a Ray cluster, or on a Ray of this machine alone, with the contract of `pool.run_jobs`.

Ray hands a task of a worker or node that dies to another one. Results come back one by one and are yielded at once, so
that the caller has kept whatever had ended when this process dies. At most two tasks for each processor are pending.

Ray's dashboard, its telemetry and its messages of workers are off. Its ports execute code for whoever reaches them:
https://docs.ray.io/en/latest/ray-security/index.html
"""

from __future__ import annotations

import os
import secrets
import shutil
import signal
import sys
import tempfile
import threading
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar, final

from spiraltrunk.errors import MissingPackage, RunError
from spiraltrunk.processes.pool import THREADS, Outcome
from spiraltrunk.processes.worker import format_error

Job = TypeVar("Job")
Result = TypeVar("Result")

RETRIES = 3
"""How often a task is run again whose worker or node has died; a task that kills its worker each time has failed."""

_PENDING = 2
"""Tasks for each processor that are handed to Ray at a time, so that no worker waits for its next."""

_PATIENCE = 1.0
"""Longest time for which Ray is waited for before signals are heard [s]."""

_STORE = 100 * 2**20
"""Memory of the object store of a Ray of this machine [byte]; results are some hundred bytes, Ray's least is 75 MiB."""

_LONGEST = 25
"""Longest name of a folder for temporary files below which Ray's sockets can be: theirs may have 107 characters."""

_ENVIRONMENT = {
    "RAY_USAGE_STATS_ENABLED": "0",
    "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0",  # Else Ray warns that this will be its default.
}


@final
@dataclass(frozen=True, kw_only=True)
class RayEngine:
    """Runs jobs on Ray.

    Workers find modules where they are installed on their node, and else at this process's own search path, which a
    file system that all nodes share makes valid everywhere. Relative paths of files count from this process's folder.
    """

    address: str | None = None
    """Head of the cluster, as "10.0.0.1:6379", or "auto" for the one of this node; None starts a Ray here."""

    def __call__(
        self, work: Callable[[Job], Result], jobs: Iterable[Job], workers: int
    ) -> Generator[Outcome[Job, Result], None, None]:
        """Outcomes in the order of completion. Closing the iterator stops the tasks, and a Ray that was started here.

        Args:
            work: a callable that can be pickled, such as a function of a module.
            jobs: its arguments, each used once.
            workers: processes of a Ray of this machine; a cluster has its own.

        Raises:
            MissingPackage: without Ray.
            RunError: where there is no cluster at the address, it has no processor, or its workers cannot import the
                work.
        """
        ray = load_ray()
        with _connect(ray, self.address, workers):
            if not ray.cluster_resources().get("CPU"):
                raise RunError("the Ray cluster has no processors; allowed: nodes with --num-cpus of 1 or more")
            yield from _run(ray, work, jobs)


def load_ray() -> Any:
    """Ray's module.

    Raises:
        MissingPackage: where it is not installed.
    """
    for name, value in _ENVIRONMENT.items():
        os.environ.setdefault(name, value)
    try:
        import ray
    except ModuleNotFoundError:
        message = "the package 'ray' is not installed: pip install 'spiraltrunk[cluster]'"
        raise MissingPackage(message) from None
    return ray


@contextmanager
def _connect(ray: Any, address: str | None, workers: int) -> Iterator[None]:
    """Connect to a cluster, or start a Ray; one that the caller has connected to stays."""
    if ray.is_initialized():
        yield
        return
    folder = None if address is not None else _make_folder()
    asked: dict[str, Any] = {"address": address}
    if folder is not None:
        asked = {"address": "local", "num_cpus": workers, "object_store_memory": _STORE, "_temp_dir": folder}
    with _redirect_output(), _use_token(is_own=folder is not None):
        try:
            _start(ray, asked)
            yield
        finally:
            with suppress(Exception):
                ray.shutdown()
            if folder is not None:
                shutil.rmtree(folder, ignore_errors=True)


def _make_folder() -> str:
    """A folder for Ray's files, where its sockets' names are short enough for the operating system."""
    usual = tempfile.gettempdir()
    return tempfile.mkdtemp(prefix="ray-", dir=usual if len(usual) <= _LONGEST else "/tmp")


@contextmanager
def _use_token(*, is_own: bool) -> Iterator[None]:
    """Give a Ray of this machine a token, without which its ports serve nobody; Ray itself writes one to ``~/.ray``.

    Ray switches authentication on by itself. It reads the variable once, so that a process keeps its token.
    """
    names = ("RAY_AUTH_MODE", "RAY_AUTH_TOKEN", "RAY_AUTH_TOKEN_PATH")
    before = {name: os.environ[name] for name in names if name in os.environ}
    if is_own and not before:
        os.environ["RAY_AUTH_TOKEN"] = _make_token()
    try:
        yield
    finally:
        for name in names:
            os.environ.pop(name, None)
        os.environ.update(before)


@cache
def _make_token() -> str:
    return secrets.token_hex(32)


def _start(ray: Any, asked: dict[str, Any]) -> None:
    """Start or join a cluster.

    Raises:
        RunError: where Ray refuses.
    """
    try:
        with _keep_handlers():
            ray.init(include_dashboard=False, log_to_driver=False, logging_level="ERROR", **asked)
    except (OSError, ValueError, RuntimeError) as error:
        told = f"Ray cannot join a cluster at {asked['address']!r}"
        allowed = "the address of a running cluster with this version of Ray and Python, from one of its nodes"
        if asked["address"] == "local":
            told, allowed = "Ray cannot start", "a machine on which ray.init() works, or the engine local"
        raise RunError(f"{told}: {format_error(error)}; allowed: {allowed}") from None


def _run(ray: Any, work: Callable[[Job], Result], jobs: Iterable[Job]) -> Generator[Outcome[Job, Result], None, None]:
    waiting, task = iter(jobs), _build_task(ray)
    folder, path = str(Path.cwd()), [str(Path(each).absolute()) for each in sys.path]
    sent = ray.cloudpickle.dumps(work)
    pending: dict[Any, Job] = {}
    try:
        while True:
            most = _PENDING * max(1, int(ray.cluster_resources().get("CPU", 0)))
            for job in islice(waiting, max(0, most - len(pending))):
                pending[task.remote(folder, path, THREADS, sent, ray.cloudpickle.dumps(job))] = job
            if not pending:
                return
            for done in ray.wait(list(pending), num_returns=1, timeout=_PATIENCE)[0]:
                yield _receive(ray, done, pending.pop(done))
    finally:
        for left in pending:
            with suppress(Exception):
                ray.cancel(left, force=True)


def _receive(ray: Any, done: Any, job: Job) -> Outcome[Job, Any]:
    """Outcome of a task that has ended.

    Raises:
        RunError: where the worker cannot import the work.
    """
    try:
        missing, answer = ray.get(done)
    except ray.exceptions.RayError as error:  # Its worker or node has died, again and again.
        return Outcome(job=job, result=None, fault=f"its process died ({type(error).__name__})")
    if missing:
        allowed = "allowed: the same spiraltrunk on every node, in a shared environment or by Ray's runtime_env"
        raise RunError(f"a worker of the Ray cluster cannot import its work ({missing}); {allowed}")
    result, fault, raised = answer
    return Outcome(job=job, result=result, fault=fault, error=raised)


def _build_task(ray: Any) -> Any:
    """The task that workers run. It is sent as code, so that a worker needs nothing to receive it."""

    def serve(folder: str, path: list[str], threads: tuple[str, ...], work: bytes, job: bytes) -> tuple[str, Any]:
        """Why the work cannot be imported, or an empty text; result, fault and exception of the job."""
        import os
        import pickle
        import sys
        from contextlib import suppress

        with suppress(OSError):  # A node may lack the folder; then only relative paths of files fail.
            os.chdir(folder)
        os.environ.update(dict.fromkeys(threads, "1"))
        sys.path.extend(each for each in path if each not in sys.path)
        try:
            from spiraltrunk.processes.worker import attempt

            call, argument = pickle.loads(work), pickle.loads(job)
        except Exception as error:
            return f"{type(error).__name__}: {error}"[:300], None
        return "", attempt(call, argument)

    return ray.remote(num_cpus=1, max_retries=RETRIES)(serve)


@contextmanager
def _keep_handlers() -> Iterator[None]:
    """Restore the signal handlers that Ray replaces."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def _redirect_output() -> Iterator[None]:
    """Send what Ray prints on standard output to standard error: the former is reserved for the command's result."""
    try:
        kept = os.dup(1)
    except OSError:  # Closed.
        yield
        return
    try:
        with suppress(OSError, ValueError, AttributeError):
            sys.stdout.flush()
        with suppress(OSError):
            os.dup2(2, 1)
        yield
    finally:
        with suppress(OSError, ValueError, AttributeError):
            sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)
