"""Heartbeat of a page: questions that its browser answers while it draws."""

from __future__ import annotations

import secrets
import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from typing import final

from viser import ClientHandle, _messages

MOST_OPEN = 20
"""Questions without an answer, beyond which one a second is asked: a page that hangs is not flooded [-] (ours)."""

_KEY = "spiraltrunk-heartbeat"


@final
class PageHeartbeat:
    """Asks a page for a value of its storage, which viser's client answers between two frames.

    A page that is closed, reloaded, hidden behind another tab or busy does not draw, and does not answer.
    """

    def __init__(self, client: ClientHandle, on_answer: Callable[[float], None]) -> None:
        """A heartbeat.

        Args:
            client: the page.
            on_answer: called with the time at which the question was asked that was answered, by `time.monotonic` [s].
        """
        self._connection = client._websock_connection
        self._on_answer = on_answer
        self._prefix = secrets.token_hex(8)
        self._open: OrderedDict[str, float] = OrderedDict()
        self._lock = threading.Lock()
        self._count = 0
        self._connection.register_handler(_messages.LocalStorageGetItemResponseMessage, self._take)

    def ask(self) -> None:
        """Ask once."""
        now = time.monotonic()
        with self._lock:
            newest = next(reversed(self._open.values()), -1.0)
            if len(self._open) >= MOST_OPEN and now < newest + 1.0:
                return
            self._count += 1
            name = f"{self._prefix}-{self._count}"
            self._open[name] = now
            while len(self._open) > 2 * MOST_OPEN:
                self._open.popitem(last=False)
        self._connection.queue_message(_messages.LocalStorageGetItemRequestMessage(key=_KEY, request_uuid=name))

    def _take(self, _: int, message: _messages.LocalStorageGetItemResponseMessage) -> None:
        with self._lock:
            asked = self._open.pop(message.request_uuid, None)
        if asked is not None:
            self._on_answer(asked)
