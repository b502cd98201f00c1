"""Settings of pages, kept while the server runs, so that a reload comes back where it was."""

from __future__ import annotations

import json
import threading
from collections import OrderedDict
from typing import Any, final

MOST_PAGES = 32
"""Pages whose settings are kept; the one unused longest goes first [-]."""

MOST_LENGTH = 200_000
"""Longest settings of a page as JSON [-]."""


@final
class PageStore:
    """Settings by page. A page that is open twice, as after a browser's "duplicate tab", is two pages."""

    def __init__(self) -> None:
        self._saved: OrderedDict[str, str] = OrderedDict()
        self._open: set[str] = set()
        self._left = threading.Condition()

    def enter(self, page: str, other: str, patience: float = 2.0) -> tuple[str, dict[str, Any]]:
        """Name and settings of a page that opens.

        Args:
            page: its name.
            other: its name where a page of that name is open already.
            patience: time in which a page that is being reloaded is closed [s].
        """
        with self._left:
            self._left.wait_for(lambda: page not in self._open, patience)
            settings = json.loads(self._saved.get(page, "{}"))
            name = other if page in self._open else page
            self._open.add(name)
            return name, settings

    def save(self, page: str, settings: dict[str, Any]) -> None:
        """Keep settings; those that are too long are not kept."""
        text = json.dumps(settings, allow_nan=False)
        with self._left:
            if len(text) <= MOST_LENGTH:
                self._saved[page] = text
                self._saved.move_to_end(page)
            while len(self._saved) > MOST_PAGES:
                self._saved.popitem(last=False)

    def leave(self, page: str) -> None:
        """A page was closed; its settings stay."""
        with self._left:
            self._open.discard(page)
            self._left.notify_all()
