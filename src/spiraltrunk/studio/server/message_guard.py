"""Checks of messages from a page: values alone, and files of limited size. Viser itself checks neither."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, final

from viser import ClientHandle, ViserServer, _messages

MOST_UPLOAD = 25_000_000
"""Largest file that a page may send [bytes]."""

MOST_TRANSFERS = 4
"""Files that one page may send at a time [-]."""

MOST_TEXT = 20_000
"""Longest text in a control [-]."""


def refuse_tunnels(server: ViserServer) -> None:
    """Refuse viser's message by which a page opens a tunnel from the internet to this server."""
    for kind in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
        server._websock_server.unregister_handler(kind)


def guard_client(
    client: ClientHandle, complain: Callable[[str], None], take_text: Callable[[str, str], bool] = lambda *_: False
) -> None:
    """Check the messages of a page before viser acts on them; what is refused is reported and changes nothing.

    Args:
        client: the page.
        complain: gets each reason.
        take_text: gets identity and text of each control that sends a text, and returns whether it was meant for it
            alone: what a number box cannot take comes as the text that was typed.
    """
    _Guard(client, complain, take_text).install()


@final
class _Guard:
    def __init__(
        self, client: ClientHandle, complain: Callable[[str], None], take_text: Callable[[str, str], bool]
    ) -> None:
        self._gui = client.gui
        self._connection = client._websock_connection
        self._complain = complain
        self._take_text = take_text

    def install(self) -> None:
        pairs: tuple[tuple[type, Any, Any], ...] = (
            (_messages.GuiUpdateMessage, self._gui._handle_gui_updates, self._update),
            (_messages.FileTransferStartUpload, self._gui._handle_file_transfer_start, self._start),
            (_messages.FileTransferPart, self._gui._handle_file_transfer_part, self._take_part),
        )
        for kind, theirs, ours in pairs:
            self._connection.unregister_handler(kind, theirs)
            self._connection.register_handler(kind, ours)

    async def _update(self, client_id: Any, message: _messages.GuiUpdateMessage) -> None:
        """Pass on a new value of a control; any other property is the server's."""
        if set(message.updates) != {"value"} or not is_plain(message.updates["value"]):
            self._complain("a control sent what is no number, text or choice; nothing was changed")
            return
        value = message.updates["value"]
        if isinstance(value, str) and self._take_text(message.uuid, value):
            return
        await self._gui._handle_gui_updates(client_id, message)

    def _start(self, client_id: Any, message: _messages.FileTransferStartUpload) -> None:
        """Begin a file whose size is allowed."""
        size, parts = message.size_bytes, message.part_count
        if not (0 <= size <= MOST_UPLOAD and 0 <= parts <= MOST_UPLOAD // 1000):
            self._refuse(message, size, f"the file has {size / 1e6:.2f} MB; allowed: at most {MOST_UPLOAD / 1e6:g} MB")
        elif len(self._gui._current_file_upload_states) >= MOST_TRANSFERS:
            self._refuse(
                message, size, f"more files are sent at a time; allowed: {MOST_TRANSFERS}; wait, and try again"
            )
        else:
            self._gui._handle_file_transfer_start(client_id, message)
            if parts == 0:
                self._remove_progress(message)

    def _take_part(self, client_id: Any, message: _messages.FileTransferPart) -> None:
        """Take a part of a file; one that grows beyond its announced size is dropped."""
        running = self._gui._current_file_upload_states
        state = running.get(message.transfer_uuid)
        if state is not None and state["transferred_bytes"] + len(message.content) > state["total_bytes"]:
            running.pop(message.transfer_uuid, None)
            self._refuse(message, state["total_bytes"], "the file is larger than announced; allowed: its true size")
            return
        self._gui._handle_file_transfer_part(client_id, message)
        if state is not None and message.transfer_uuid not in running:
            self._remove_progress(message)

    def _refuse(self, message: Any, size: int, reason: str) -> None:
        """Tell why a file is not taken, and end and remove the progress that the page shows of it."""
        self._connection.queue_message(
            _messages.FileTransferPartAck(
                source_component_uuid=message.source_component_uuid, transfer_uuid=message.transfer_uuid,
                transferred_bytes=size, total_bytes=size,
            )
        )  # fmt: skip
        self._remove_progress(message)
        self._complain(reason)

    def _remove_progress(self, message: Any) -> None:
        """Remove the progress of a transfer that has ended: whether the file was of use, the tab that gets it tells."""
        progress = _messages.RemoveNotificationMessage(uuid=f"upload-{message.transfer_uuid}")
        self._connection.queue_message(progress)


def is_plain(value: Any) -> bool:
    """Whether a value is a finite number, a short text, a truth value or a short list of them."""
    if isinstance(value, bool | int):
        return not isinstance(value, int) or abs(value) < 2**53
    if isinstance(value, float):
        return math.isfinite(value)
    if isinstance(value, str):
        return len(value) <= MOST_TEXT
    return isinstance(value, list | tuple) and len(value) <= 16 and all(map(is_plain, value))
