"""A long computation in a process of its own; it can be stopped at any moment, and the page never waits for it."""

from __future__ import annotations

import os
import shutil
import tempfile
import threading
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, final

from spiraltrunk.errors import DriveError, RunError, SpiralTrunkError
from spiraltrunk.studio.page.scratch import make_scratch

Work = Callable[..., Any]
"""``work(report, *arguments)``, a function of a module."""

STOPPED = "stopped"
"""Reason of a job that the user stopped."""

SERIOUS = (OSError, RunError, DriveError)
"""Errors of what was under way; any other of ours refuses what was given."""

_PATIENCE = 3.0
"""Time that the process has to end by itself [s]."""


@final
class Refusal(str):
    """Reason of a job that refused what it was given."""

    __slots__ = ()


@final
class Job:
    """A function that runs in a process of its own."""

    def __init__(self, work: Work, arguments: tuple[Any, ...]) -> None:
        context = get_context("spawn")
        self._ours, theirs = context.Pipe()
        self._theirs: Connection | None = theirs
        self._process = context.Process(target=_run, args=(theirs, work, arguments), daemon=True)
        self._folder: Path | None = None
        self._is_stopped = threading.Event()

    @property
    def is_running(self) -> bool:
        """Whether its process lives."""
        return self._process.is_alive()

    def start(self, on_report: Callable[[Any], None], on_end: Callable[[Any, str | None], None]) -> None:
        """Start the process, and a thread that passes on its reports."""

        def listen() -> None:
            answer: tuple[Any, str | None] = (None, "its process could not be ended")
            try:
                answer = self._listen(on_report)
            finally:
                on_end(*answer)

        threading.Thread(target=listen, name="studio job", daemon=True).start()

    def stop(self) -> None:
        """End the work; does not wait."""
        self._is_stopped.set()
        with suppress(OSError, ValueError, AttributeError):
            self._process.terminate()

    def _listen(self, on_report: Callable[[Any], None]) -> tuple[Any, str | None]:
        """Result and reason of the end."""
        answer: tuple[Any, str | None] = (None, None)
        try:
            self._folder = make_scratch("job")
            self._process.start()
            if self._is_stopped.is_set():  # Before there was a process to end.
                self._process.terminate()
            assert self._theirs is not None
            self._theirs.close()
            self._ours.send(str(self._folder))
            while True:
                kind, value = self._ours.recv()
                if kind == "report":
                    on_report(value)
                elif kind == "refusal":
                    answer = (None, Refusal(value))
                else:
                    answer = (value, None) if kind == "result" else (None, value)
        except EOFError:
            pass
        except OSError as error:
            answer = (None, str(error))
        except Exception as error:  # A listener's, or a report that cannot be read.
            answer = (None, f"{type(error).__name__}: {error}")
        finally:
            self._end()
        if self._is_stopped.is_set():
            return None, STOPPED
        if answer == (None, None) and self._process.exitcode:
            return None, f"its process ended with exit code {self._process.exitcode}"
        return answer

    def _end(self) -> None:
        self._ours.close()
        with suppress(AssertionError):  # Never started.
            self._process.join(_PATIENCE)
            if self._process.is_alive():
                self._process.kill()
                self._process.join()
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)


def _run(pipe: Connection, work: Work, arguments: tuple[Any, ...]) -> None:
    """Main function of the process, whose temporary files are in a folder that its parent removes."""
    tempfile.tempdir = pipe.recv()
    parent = os.getppid()
    threading.Thread(target=_watch, args=(parent,), daemon=True).start()
    sending = threading.Lock()

    def say(kind: str, value: Any) -> None:
        with sending:
            pipe.send((kind, value))

    try:
        say("result", work(lambda value: say("report", value), *arguments))
    except (SpiralTrunkError, OSError) as error:
        say("error" if isinstance(error, SERIOUS) else "refusal", str(error) or type(error).__name__)
    except Exception as error:
        say("error", f"{type(error).__name__}: {error}")


def _watch(parent: int) -> None:
    """End with the parent, however it ended."""
    sleeping = threading.Event()
    while os.getppid() == parent:
        sleeping.wait(0.5)
    os._exit(1)
