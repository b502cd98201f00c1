"""The studio: a server, and a page for everyone who opens it."""

from __future__ import annotations

import secrets
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from typing import final

from viser import ClientHandle

from spiraltrunk.design import TrunkDesign
from spiraltrunk.errors import StudioError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.studio.page.frame import Frame
from spiraltrunk.studio.page.identity import ask_page
from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.page.store import PageStore
from spiraltrunk.studio.page.tab import Tab
from spiraltrunk.studio.server.gate import Gate, is_loopback
from spiraltrunk.studio.server.message_guard import guard_client
from spiraltrunk.studio.server.serve import open_port, silence, start_server

MOST_PAGES = 12
"""Pages that may be open at a time [-]."""


Tabs = Sequence[Callable[[Page], Tab]]
"""Constructors of tabs."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class StudioOptions:
    """Options of a studio."""

    host: str = "127.0.0.1"
    """Address that it listens on; any but this computer's own asks each page for a token."""
    port: int = 8080
    """Port; 0 takes a free one."""
    first: str = "Grasp"
    """Title of the tab that a new page shows; the first of the bar where there is none of this title."""


@final
class Studio:
    """A running studio."""

    def __init__(
        self, design: TrunkDesign, tabs: Tabs | Callable[[], Tabs], options: StudioOptions | None = None
    ) -> None:
        """Open the port and start to answer.

        Args:
            design: the design that a new page opens on.
            tabs: constructors of the tabs, or a function that gives them: it is called once, in a thread of its own,
                and pages that open meanwhile wait for it, so that a browser starts while packages are imported.
            options: address.

        Raises:
            StudioError: where the address cannot be used.
            RunError: where viser does not start.
        """
        options = StudioOptions() if options is None else options
        if not 0 <= options.port <= 65535:
            raise StudioError(f"port is {options.port}; allowed: 0 to 65535")
        opened = open_port(options.host, options.port)
        token = None if is_loopback(options.host) else secrets.token_urlsafe(16)
        self._gate = Gate(host=options.host, port=opened.getsockname()[1], token=token)
        self._design = design
        self._first = options.first
        self._store = PageStore()
        self._pages: dict[int, tuple[Page, str]] = {}
        self._lock = threading.Lock()
        self._tabs: Future[Tabs] = Future()
        threading.Thread(target=self._load, args=(tabs,), name="studio tabs", daemon=True).start()
        self._server = start_server(opened, self._gate)
        self._server.on_client_connect(self._open)
        self._server.on_client_disconnect(self._close)

    @property
    def address(self) -> str:
        """Address to open, with the token where there is one."""
        host = f"[{self._gate.host}]" if ":" in self._gate.host else self._gate.host
        query = "" if self._gate.token is None else f"?token={self._gate.token}"
        return f"http://{host}:{self._gate.port}/{query}"

    @property
    def needs_token(self) -> bool:
        """Whether others than this computer can reach it."""
        return self._gate.token is not None

    @property
    def n_pages(self) -> int:
        """Number of open pages [-]."""
        return len(self._pages)

    def stop(self) -> None:
        """Close all pages, with all that they started, and the server."""
        for number in tuple(self._pages):
            self._drop(number)
        with silence():
            self._server.stop()

    def _load(self, tabs: Tabs | Callable[[], Tabs]) -> None:
        try:
            self._tabs.set_result(tabs() if callable(tabs) else tabs)
        except Exception as error:  # Told on each page.
            self._tabs.set_exception(error)

    def _open(self, client: ClientHandle) -> None:
        with self._lock:
            page = None if len(self._pages) >= MOST_PAGES else Page(client, self._design)
            if page is not None:
                self._pages[client.client_id] = (page, "")
        if page is None:
            guard_client(client, lambda _: None)  # What it sends is limited all the same.
            client.add_notification("Too many pages", f"at most {MOST_PAGES} at a time; close another first")
            return
        guard_client(client, lambda reason: page.notice(reason, "refusal"), page.take_text)
        asked = ask_page(client)
        name, settings = self._store.enter(asked, secrets.token_hex(8))
        with self._lock:
            if client.client_id not in self._pages:  # Closed meanwhile.
                self._store.leave(name)
                return
            self._pages[client.client_id] = (page, name)

        def build() -> None:
            frame = Frame(page, self._tabs.result(), lambda kept: self._store.save(name, kept))
            frame.restore(settings, self._first)

        page.post(build)

    def _close(self, client: ClientHandle) -> None:
        self._drop(client.client_id)

    def _drop(self, number: int) -> None:
        with self._lock:
            page, name = self._pages.pop(number, (None, ""))
        if page is not None:
            page.close()
            self._store.leave(name)
