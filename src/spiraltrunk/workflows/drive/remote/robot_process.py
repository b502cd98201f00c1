"""Main function of the robot's process.

The driver's loop has an interpreter of its own here, which no page slows down. Whoever started the process holds the
other end of its pipe; where that is closed, as by the death of its holder, the robot lets go and the process ends.
"""

from __future__ import annotations

import math
import signal
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import final

from spiraltrunk.errors import SpiralTrunkError
from spiraltrunk.workflows.drive.remote.outbox import Outbox
from spiraltrunk.workflows.drive.remote.pace import Pace
from spiraltrunk.workflows.drive.remote.requests import Alive, Close, Disarm, Leave, Limit, Request, Run, Stop
from spiraltrunk.workflows.drive.remote.service import RobotService
from spiraltrunk.workflows.drive.remote.setup import RobotSetup
from spiraltrunk.workflows.drive.remote.strategy_run import run_strategy
from spiraltrunk.workflows.drive.robot import RENEWAL
from spiraltrunk.workflows.drive.twin.twin_robot import TwinRobot

REPORT_PERIOD = 0.1
"""Time between two states that are reported [s] (ours)."""

_SETTINGS = (Alive, Stop, Disarm, Leave, Limit, Close)
"""What is carried out while a strategy runs."""


class _Closed(Exception):
    """The other end of the pipe is closed, or said so."""


def serve_robot(pipe: Connection, setup: RobotSetup) -> None:
    """Serve a robot until the pipe is closed; it lets go then.

    Args:
        pipe: requests come in as ``(asker, request)``; ``("state", state)``, ``("refused", asker, text)`` and at last
            ``("end", reason)`` go out.
        setup: the robot.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the holder of the pipe, and thereby this process.
    signal.signal(signal.SIGTERM, _close)
    outbox, reason = Outbox(pipe), None
    try:
        with setup.build() as robot:
            service = RobotService(robot, patience=setup.patience)
            RobotServer(pipe, service, outbox.put, pace=setup.pace).serve()
    except _Closed:
        pass
    except (SpiralTrunkError, OSError) as error:
        reason = str(error) or type(error).__name__
    except Exception as error:
        reason = f"{type(error).__name__}: {error}"
    outbox.put("end", reason)
    outbox.close()


def _close(*_: object) -> None:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    raise _Closed


@final
class RobotServer:
    """Requests in, cycles, states out."""

    def __init__(
        self,
        pipe: Connection,
        service: RobotService,
        put: Callable[..., None],
        *,
        pace: float = 1.0,
    ) -> None:
        """A server.

        Args:
            pipe: where requests come from.
            service: the robot.
            put: sends a message, such as ``put("state", state)``.
            pace: simulated time of a twin over the computer's [-].
        """
        self._pipe, self._service, self._put = pipe, service, put
        self._is_twin = isinstance(service.robot, TwinRobot)
        self._pace = Pace(RENEWAL / pace)
        self._told = -math.inf
        self._run: Run | None = None

    def serve(self) -> None:
        """Serve until the pipe is closed.

        Raises:
            _Closed: then.
            DriveError: where the driver's loop ended.
        """
        while True:
            self.attend()
            self._service.step(time.monotonic())
            if self._run is not None:
                self._carry_out(self._run)

    def attend(self) -> None:
        """Wait until the next cycle of the twin is due, carry out what was asked meanwhile, and report the state."""
        self._receive(self._pace.wait(time.monotonic()) if self._is_twin else 0.0)
        now = time.monotonic()
        self._pace.begin(now)
        self._service.watch_page(now)
        if now >= self._told + REPORT_PERIOD:
            self._told = now
            self._put("state", self._service.read_state(now, self._pace.summarise() if self._is_twin else None))

    def _receive(self, wait: float) -> None:
        """Carry out requests for so long [s], at least those that are here."""
        end = time.monotonic() + wait
        try:
            while self._pipe.poll(max(0.0, end - time.monotonic())):
                self._handle(*self._pipe.recv())
        except (EOFError, OSError):
            raise _Closed from None

    def _handle(self, asker: str, request: Request) -> None:
        if isinstance(request, Close):
            raise _Closed
        try:
            self._dispatch(request)
        except SpiralTrunkError as error:
            self._put("refused", asker, str(error))

    def _dispatch(self, request: Request) -> None:
        service = self._service
        if service.run and not isinstance(request, _SETTINGS):
            raise SpiralTrunkError("a strategy runs; stop it first")
        service.handle(request, time.monotonic())
        if isinstance(request, Run):
            self._run = request

    def _carry_out(self, request: Run) -> None:
        """Run the strategy on a twin of its own, in place of the robot."""
        service, resting, self._run = self._service, self._service.robot, None
        service.run, service.result = "homing", ""

        def attend(robot: TwinRobot, phase: str | None) -> None:
            service.robot = robot
            service.run = service.run if phase is None else phase
            self.attend()

        try:
            service.result = run_strategy(resting.design, request, attend)
        except (SpiralTrunkError, ValueError) as error:
            service.result = f"{request.strategy} ended early: {error}"
        finally:
            service.robot, service.run = resting, ""
