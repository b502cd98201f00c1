"""What a page sends is checked before viser acts on it: values alone, and files of limited size."""

import asyncio
import math
from types import SimpleNamespace

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from viser import _messages

from spiraltrunk.studio.server import message_guard
from spiraltrunk.studio.server.message_guard import MOST_TEXT, MOST_TRANSFERS, MOST_UPLOAD, guard_client, is_plain


class FakeClient:
    """A client of viser that keeps what passes the guard."""

    def __init__(self):
        self.handlers, self.passed, self.sent, self.complaints, self.texts = {}, [], [], [], []
        self.gui = SimpleNamespace(
            _current_file_upload_states={}, _handle_gui_updates=self._update,
            _handle_file_transfer_start=lambda _, message: self.passed.append(message),
            _handle_file_transfer_part=lambda _, message: self.passed.append(message),
        )  # fmt: skip
        self._websock_connection = self
        guard_client(self, self.complaints.append, self._take_text)

    def _take_text(self, uuid, text):
        self.texts.append((uuid, text))
        return uuid == "box"

    async def _update(self, _, message):
        self.passed.append(message)

    def unregister_handler(self, kind, handler):
        assert kind not in self.handlers

    def register_handler(self, kind, handler):
        self.handlers[kind] = handler

    def queue_message(self, message):
        self.sent.append(message)

    def send(self, message):
        result = self.handlers[type(message)](0, message)
        if asyncio.iscoroutine(result):
            asyncio.run(result)


@pytest.fixture
def client():
    return FakeClient()


def announce(size, parts=1, name="a"):
    return _messages.FileTransferStartUpload(
        source_component_uuid="button", transfer_uuid=name, filename="../../etc/passwd", mime_type="", part_count=parts,
        size_bytes=size,
    )  # fmt: skip


@pytest.mark.parametrize(
    "updates",
    [
        {"value": math.nan}, {"value": math.inf}, {"value": [1.0, math.nan]}, {"value": 2**60}, {"value": None},
        {"value": {"a": 1}}, {"value": b"x"}, {"value": "x" * (MOST_TEXT + 1)}, {"value": [0.0] * 17},
        {"update_cb": []}, {"value": 1.0, "disabled": False}, {"visible": True}, {},
    ],
)  # fmt: skip
def test_what_is_no_value_is_told_and_not_passed_on(client, updates):
    client.send(_messages.GuiUpdateMessage(uuid="a", updates=updates))
    assert client.passed == []
    assert len(client.complaints) == 1


@pytest.mark.parametrize("value", [1.5, 3, True, "text", "", (1, 2.0), ["a"]])
def test_values_pass(client, value):
    client.send(_messages.GuiUpdateMessage(uuid="a", updates={"value": value}))
    assert len(client.passed) == 1
    assert client.complaints == []
    assert is_plain(value)


def test_a_text_that_the_page_takes_does_not_reach_viser(client):
    for uuid, value in (("box", "12abc"), ("name", "12abc"), ("box", 12.0)):
        client.send(_messages.GuiUpdateMessage(uuid=uuid, updates={"value": value}))
    assert client.texts == [("box", "12abc"), ("name", "12abc")]
    assert [(each.uuid, each.updates["value"]) for each in client.passed] == [("name", "12abc"), ("box", 12.0)]
    assert client.complaints == []


@pytest.mark.parametrize("message", [announce(MOST_UPLOAD + 1), announce(-1), announce(10, -1), announce(10, 10**9)])
def test_a_file_of_a_wrong_size_is_told_and_its_progress_ends(client, message):
    client.send(message)
    assert client.passed == []
    assert len(client.complaints) == 1
    assert "allowed: at most 25 MB" in client.complaints[0]
    ack, removal = client.sent
    assert (ack.transfer_uuid, ack.transferred_bytes) == ("a", ack.total_bytes)
    assert removal.uuid == "upload-a", "what was refused is not called uploaded"


def test_files_at_a_time_are_limited(client):
    client.send(announce(MOST_UPLOAD))
    assert len(client.passed) == 1
    client.gui._current_file_upload_states.update((str(i), {}) for i in range(MOST_TRANSFERS))
    client.send(announce(10))
    assert len(client.passed) == 1
    assert "wait, and try again" in client.complaints[0]


def test_a_file_that_grows_is_dropped(client):
    running = client.gui._current_file_upload_states
    running["a"] = {"transferred_bytes": 90, "total_bytes": 100}
    part = {"source_component_uuid": "button", "transfer_uuid": "a", "part_index": 0}
    client.send(_messages.FileTransferPart(content=b"x" * 10, **part))
    assert len(client.passed) == 1
    client.send(_messages.FileTransferPart(content=b"x" * 11, **part))
    assert len(client.passed) == 1
    assert running == {}
    assert "larger than announced" in client.complaints[0]


def test_the_guard_takes_the_place_of_all_of_visers_own_handlers(client):
    assert set(client.handlers) == {
        _messages.GuiUpdateMessage, _messages.FileTransferStartUpload, _messages.FileTransferPart
    }  # fmt: skip
    assert message_guard.MOST_UPLOAD == 25_000_000
