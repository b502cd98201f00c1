"""Start of the server, behind its gate."""

from __future__ import annotations

import errno
import socket
import threading
from collections.abc import Callable
from http import HTTPStatus
from typing import Any
from unittest import mock

import websockets.asyncio.server
from viser import ViserServer
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from spiraltrunk.errors import RunError, StudioError
from spiraltrunk.studio.server.gate import Gate, Refusal
from spiraltrunk.studio.server.head import add_head
from spiraltrunk.studio.server.message_guard import refuse_tunnels
from spiraltrunk.studio.server.waking_event import use_waking_events

MOST_MESSAGE = 8 * 2**20
"""Largest message from a page [bytes]."""

_HEADERS = {
    "X-Frame-Options": "DENY", "X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store", "Content-Security-Policy": "frame-ancestors 'none'",
}  # fmt: skip
"""Headers of every answer: no foreign page may show the studio in a frame, and no address with a token is passed on."""

_FOREIGN = (errno.EADDRNOTAVAIL, errno.EAFNOSUPPORT)
"""Errors of an address that this computer has not."""

_STARTING = threading.Lock()


def open_port(host: str, port: int) -> socket.socket:
    """A socket that listens on an address; port 0 takes a free one.

    Raises:
        StudioError: where the address cannot be used.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    opened = socket.socket(family, socket.SOCK_STREAM)
    opened.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        opened.bind((host, port))
        opened.listen(64)
    except OSError as error:
        opened.close()
        reason = error.strerror or error
        if error.errno in _FOREIGN or isinstance(error, socket.gaierror):
            allowed = "an address of this computer, such as 127.0.0.1 or 0.0.0.0"
            raise StudioError(f"host is {host}: {reason}; allowed: {allowed}") from None
        raise StudioError(
            f"port {port} of {host} cannot be opened: {reason}; end what uses it, or give another by --port"
        ) from None
    return opened


def start_server(opened: socket.socket, gate: Gate) -> ViserServer:
    """A viser server on a listening socket, whose every request passes a gate.

    Raises:
        RunError: where viser did not start through the gate, as another version of it might.
    """
    use_waking_events()
    begun, built = threading.Event(), threading.Event()
    genuine = websockets.asyncio.server.serve

    def serve_guarded(handler: Any, host: str, port: int, **options: Any) -> Any:
        begun.set()
        options["process_request"] = _guard(gate, built, options["process_request"])
        options["max_size"] = MOST_MESSAGE
        return genuine(handler, sock=opened, **options)

    with _STARTING, mock.patch.object(websockets.asyncio.server, "serve", serve_guarded), silence():
        server = ViserServer(host=gate.host, port=gate.port, label="spiraltrunk studio", verbose=False)
    built.set()
    if not begun.is_set():
        server.stop()
        raise RunError("this version of viser starts its server in another way; install the one in constraints.txt")
    refuse_tunnels(server)
    return server


def silence() -> Any:
    """Keep viser from printing: its own address, which has no token, and that it has stopped."""
    return mock.patch("rich.print", return_value=None)


def _guard(
    gate: Gate, built: threading.Event, theirs: Callable[..., Response | None]
) -> Callable[..., Response | None]:
    """Requests that the gate refuses are answered by its reason, others as before.

    Viser listens before it is built: a page that an earlier studio left open connects then, and comes back a second
    later where it is refused.
    """

    def process(connection: ServerConnection, request: Request) -> Response | None:
        headers = dict(request.headers.raw_items())
        refusal = gate.check(request.path, headers)
        if refusal is None and not built.is_set() and headers.get("Upgrade", "").lower() == "websocket":
            refusal = Refusal(status=HTTPStatus.SERVICE_UNAVAILABLE, reason="the studio is starting")
        if refusal is not None:
            return _answer(refusal)
        if "Accept-Encoding" in request.headers:
            del request.headers["Accept-Encoding"]  # The client's page is packed already, and gets our head.
        response = theirs(connection, request)
        if response is not None:
            if response.headers.get("Content-Type", "").startswith("text/html"):
                response.body = add_head(bytes(response.body))
                del response.headers["Content-Length"]
                response.headers["Content-Length"] = str(len(response.body))
            for name, value in _HEADERS.items():
                response.headers[name] = value
            if gate.brings_token(request.path):
                response.headers["Set-Cookie"] = f"{gate.cookie}={gate.token}; HttpOnly; SameSite=Strict; Path=/"
        return response

    return process


def _answer(refusal: Refusal) -> Response:
    body = f"{refusal.reason}\n".encode()
    headers = Headers({"Content-Type": "text/plain; charset=utf-8", "Content-Length": str(len(body)), **_HEADERS})
    return Response(refusal.status.value, refusal.status.phrase, headers, body)
