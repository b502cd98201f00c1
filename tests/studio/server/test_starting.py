"""A page of an earlier studio connects while the server starts: it is asked to come back, and nothing fails."""

import contextlib
import threading
import time

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from viser import ViserServer
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from spiraltrunk.studio.server.gate import Gate
from spiraltrunk.studio.server.serve import open_port, start_server


def test_a_socket_that_comes_too_early_is_asked_to_come_back(monkeypatch, caplog):
    opened = open_port("127.0.0.1", 0)
    port = opened.getsockname()[1]
    seen = []

    def ask():
        origin = f"http://127.0.0.1:{port}"
        with contextlib.suppress(OSError):
            try:
                with connect(f"ws://127.0.0.1:{port}", subprotocols=["viser-v1.1.1"], origin=origin):
                    seen.append(101)
            except InvalidStatus as error:
                seen.append(error.response.status_code)

    built = ViserServer.__init__

    def build(self, *arguments, **options):
        built(self, *arguments, **options)
        asking = threading.Thread(target=ask)
        asking.start()
        asking.join(10)  # It is answered before the server counts as built.

    monkeypatch.setattr(ViserServer, "__init__", build)
    server = start_server(opened, Gate(host="127.0.0.1", port=port))
    try:
        ask()
        time.sleep(0.2)
    finally:
        server.stop()
    assert seen == [503, 101]
    assert "connection handler failed" not in caplog.text
