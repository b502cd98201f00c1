"""Gate of the server: which requests are answered at all.

A page in any other tab of the same browser can send requests to this computer. Their headers show it: ``Host``
(a foreign name that was made to point here) and ``Origin`` (the page that opens a WebSocket).
"""

from __future__ import annotations

import hmac
import ipaddress
import socket
from collections.abc import Mapping
from dataclasses import dataclass
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from typing import final
from urllib.parse import parse_qs, urlsplit

COOKIE = "spiraltrunk_token"
"""Cookie that holds the token, behind its name the port: cookies are shared by all ports of a host."""

LOOPBACK = ("127.0.0.1", "localhost", "::1")
"""Names of this computer for itself."""


@final
@dataclass(frozen=True, kw_only=True)
class Refusal:
    """Refusal of a request."""

    status: HTTPStatus
    """Status of the answer."""
    reason: str
    """One line for the person."""


@final
@dataclass(frozen=True, kw_only=True)
class Gate:
    """Rules by which requests are answered."""

    host: str
    """Address that the server listens on."""
    port: int
    """Its port."""
    token: str | None = None
    """What a request must know; None where only this computer can reach the server."""

    @property
    def cookie(self) -> str:
        """Name of the cookie that holds the token."""
        return f"{COOKIE}_{self.port}"

    def check(self, path: str, headers: Mapping[str, str]) -> Refusal | None:
        """Refusal of a request; None where it is allowed.

        Args:
            path: path of the request, with its query.
            headers: its headers; names in any case.
        """
        given = {name.lower(): value for name, value in headers.items()}
        host = given.get("host", "")
        if not self._is_own(host):
            return Refusal(status=HTTPStatus.FORBIDDEN, reason=f"the studio does not answer to the name {host[:80]!r}")
        is_socket = given.get("upgrade", "").lower() == "websocket"
        origin = given.get("origin")
        if origin is None and is_socket:
            return Refusal(status=HTTPStatus.FORBIDDEN, reason="a WebSocket without an origin")
        if origin is not None and origin.lower() not in (f"http://{host}".lower(), f"https://{host}".lower()):
            return Refusal(status=HTTPStatus.FORBIDDEN, reason=f"a page of {origin[:80]!r} may not use the studio")
        if self.token is not None and not self._knows_token(path, given.get("cookie", "")):
            return Refusal(
                status=HTTPStatus.UNAUTHORIZED, reason="open the studio by the whole address that it printed"
            )
        return None

    def brings_token(self, path: str) -> bool:
        """Whether the right token stands in the query of a path."""
        if self.token is None:
            return False
        given = parse_qs(urlsplit(path).query, max_num_fields=8).get("token", [""])
        return hmac.compare_digest(given[0].encode(), self.token.encode())

    def _knows_token(self, path: str, cookies: str) -> bool:
        assert self.token is not None
        try:
            if self.brings_token(path):
                return True
            found = SimpleCookie(cookies).get(self.cookie)
        except (CookieError, ValueError):
            return False
        return found is not None and hmac.compare_digest(found.value.encode(), self.token.encode())

    def _is_own(self, host: str) -> bool:
        """Whether a ``Host`` header names this server; where a token is asked for, any address may stand there."""
        try:
            name = (urlsplit(f"//{host}").hostname or "").lower()
        except ValueError:
            return False
        if name in LOOPBACK or name == self.host.lower():
            return True
        return self.token is not None and (_is_address(name) or name in _list_own_names())


def is_loopback(host: str) -> bool:
    """Whether an address can be reached from this computer alone."""
    return host in LOOPBACK or (_is_address(host) and ipaddress.ip_address(host).is_loopback)


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _list_own_names() -> set[str]:
    name = socket.gethostname().lower()
    return {name, f"{name}.local"}
