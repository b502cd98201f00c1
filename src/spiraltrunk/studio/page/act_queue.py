"""Queue of a page's acts: callbacks that run one after the other in the page's thread."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from typing import final

Act = Callable[[], None]


@final
class ActQueue:
    """Acts in the order of their arrival; a newer act replaces an older one of the same key, in its place."""

    def __init__(self, run: Callable[[Act], None]) -> None:
        """Start the thread, which runs each act by ``run``."""
        self._run = run
        self._waiting: OrderedDict[object, Act] = OrderedDict()
        self._changed = threading.Condition()
        self._is_closed = False
        self._thread = threading.Thread(target=self._work, name="studio page", daemon=True)
        self._thread.start()

    def put(self, key: str | None, act: Act) -> None:
        """Add an act; None as key stands for itself alone."""
        with self._changed:
            if not self._is_closed:
                self._waiting[object() if key is None else key] = act
                self._changed.notify()

    def close(self, last: Act, patience: float) -> None:
        """Drop what waits, run ``last`` after the present act, and end the thread.

        Args:
            last: the last act.
            patience: longest wait for it [s].
        """
        with self._changed:
            self._waiting.clear()
            self._waiting[object()] = last
            self._is_closed = True
            self._changed.notify()
        if threading.current_thread() is not self._thread:
            self._thread.join(patience)

    def _work(self) -> None:
        while (act := self._take()) is not None:
            self._run(act)
            del act

    def _take(self) -> Act | None:
        with self._changed:
            while not self._waiting and not self._is_closed:
                self._changed.wait()
            return self._waiting.popitem(last=False)[1] if self._waiting else None
