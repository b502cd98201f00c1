"""Wake-up of the task that sends messages to a page, which viser can lose where another thread queues a message.

Viser sets an `asyncio.Event` from the thread that queues a message, and again in the event loop. Between the moment at
which the sending task finds the event unset and that at which it waits, the first call sets the value and wakes
nobody; the second one finds the value set and wakes nobody either, nor does any later one. The page then gets no
message any more, though it stays connected. With the heartbeat of the tab Robot, ten messages a second, that happened
after about an hour (`benchmarks/studio_hours.py`).
"""

from __future__ import annotations

import asyncio
from typing import Any, final

from viser import infra


@final
class WakingEvent(asyncio.Event):
    """An event whose every `set` in the event loop wakes all that wait, also where its value was set already."""

    _value: bool
    _waiters: Any

    def set(self) -> None:
        """Set the value; in the event loop, wake what waits. In another thread, a call in the loop must follow."""
        self._value = True
        try:
            asyncio.get_running_loop()
        except RuntimeError:
            return
        for waiter in self._waiters:
            if not waiter.done():
                waiter.set_result(True)


def use_waking_events() -> None:
    """Give a `WakingEvent` to every buffer of messages that viser makes from now on."""
    buffers = infra._async_message_buffer.AsyncMessageBuffer
    genuine = buffers.__init__
    if getattr(genuine, "is_waking", False):
        return

    def begin(self: Any, *given: Any, **named: Any) -> None:
        genuine(self, *given, **named)
        self.message_event = WakingEvent()

    begin.is_waking = True  # type: ignore[attr-defined]
    buffers.__init__ = begin  # type: ignore[method-assign]
