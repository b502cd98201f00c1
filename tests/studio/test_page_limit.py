"""Pages beyond the limit: they get a notice, and what they send is limited as that of others."""

import threading
from unittest.mock import MagicMock

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from viser import _messages

from spiraltrunk.studio.studio import MOST_PAGES, Studio


def test_a_page_too_many_is_told_and_guarded():
    studio, client = Studio.__new__(Studio), MagicMock(client_id=MOST_PAGES)
    studio._lock, studio._pages = threading.Lock(), {i: (MagicMock(), "") for i in range(MOST_PAGES)}
    studio._open(client)
    assert client.add_notification.call_args.args[0] == "Too many pages"
    guarded = {call.args[0] for call in client._websock_connection.register_handler.call_args_list}
    assert guarded >= {_messages.GuiUpdateMessage, _messages.FileTransferStartUpload, _messages.FileTransferPart}
    assert studio.n_pages == MOST_PAGES
