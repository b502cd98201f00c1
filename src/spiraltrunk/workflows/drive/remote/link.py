"""The other end of the robot's process: starts it, asks it, hears it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import get_context
from typing import final

from spiraltrunk.errors import RunError
from spiraltrunk.workflows.drive.remote.requests import Close, Request, check_request
from spiraltrunk.workflows.drive.remote.robot_process import serve_robot
from spiraltrunk.workflows.drive.remote.setup import RobotSetup
from spiraltrunk.workflows.drive.remote.state import RobotState

LONGEST_END = 5.0
"""Time that the process has to let go and end [s] (ours)."""


@final
class RobotLink:
    """A robot in a process of its own; every call returns at once, and is safe from any thread.

    The process ends by itself, with the robot safe, when this end of its pipe is closed, by whatever.

    Args:
        setup: the robot.
        on_state: called with each state, ten times a second, in a thread of the link.
        on_refusal: called with who asked and the reason.
        on_end: called at the end with its reason, None where it was asked for.
    """

    def __init__(
        self,
        setup: RobotSetup,
        *,
        on_state: Callable[[RobotState], None],
        on_refusal: Callable[[str, str], None],
        on_end: Callable[[str | None], None],
    ) -> None:
        self.setup = setup
        self._on_state, self._on_refusal, self._on_end = on_state, on_refusal, on_end
        context = get_context("spawn")
        self._ours, self._theirs = context.Pipe()
        self._process = context.Process(target=serve_robot, args=(self._theirs, setup), name="robot", daemon=True)
        self._sending = threading.Lock()
        self._is_closing = False
        self._thread = threading.Thread(target=self._listen, name="robot link", daemon=True)

    def start(self) -> None:
        """Start the process; its first state shows that the robot is there."""
        self._thread.start()

    def ask(self, request: Request, asker: str = "") -> None:
        """Send a request.

        Args:
            request: the request.
            asker: who is told where the robot refuses it.

        Raises:
            DriveError: for a value that is out of its range; nothing is sent then.
            RunError: where the process has ended.
        """
        check_request(self.setup.design, request)
        try:
            with self._sending:
                self._ours.send((asker, request))
        except (OSError, ValueError):
            raise RunError("the robot is not connected") from None

    def close(self) -> None:
        """Let the robot go, and end the process; does not wait, harmless when called again."""
        self._is_closing = True
        with suppress(RunError):
            self.ask(Close())

    def join(self, timeout: float = LONGEST_END) -> None:
        """Wait until it has ended [s]."""
        self._thread.join(timeout)

    def _listen(self) -> None:
        reason: str | None = "the robot's process ended unexpectedly"
        try:
            self._process.start()
            self._theirs.close()
            while True:
                kind, *values = self._ours.recv()
                if kind == "state":
                    self._on_state(*values)
                elif kind == "refused":
                    self._on_refusal(*values)
                else:
                    reason = values[0]
        except (EOFError, ConnectionError):  # Reset where the process has left a request unread.
            pass
        except OSError as error:
            reason = str(error)
        except Exception as error:  # A listener's, or an answer that cannot be read: the robot is let go.
            reason = f"{type(error).__name__}: {error}"
        try:
            self._end()
        finally:
            self._on_end(None if self._is_closing and reason is None else reason)

    def _end(self) -> None:
        with self._sending, suppress(OSError):
            self._ours.close()
        with suppress(AssertionError):  # Never started.
            self._process.join(LONGEST_END)
            if self._process.is_alive():
                self._process.kill()
                self._process.join()
