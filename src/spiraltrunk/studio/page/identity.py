"""Identity of a browser's page: a reload restores its settings, and two pages have settings of their own."""

from __future__ import annotations

import json
import secrets
from contextlib import suppress

from viser import ClientHandle, _messages

_KEY = "spiraltrunk-page"
_PREFIX = "viser-user:"
"""What viser puts before the names of a browser's stored values."""

_SCRIPT = """
const name = {key}, asked = {asked}, offered = {offered};
let page = offered;
try {{
  page = sessionStorage.getItem(name) || offered;
  sessionStorage.setItem(name, page);
}} catch (error) {{}}
try {{ localStorage.setItem(asked, page); }} catch (error) {{}}
"""
"""A page keeps its name in its own storage, which a reload keeps; viser reads only the storage that all pages share."""

_PATIENCE = 3.0
"""Time in which a page answers [s]."""


def ask_page(client: ClientHandle) -> str:
    """Name of a page: the one that it kept, or a new one where it has none or does not answer."""
    offered = secrets.token_hex(8)
    key = f"{_KEY}-{offered}"
    source = _SCRIPT.format(key=json.dumps(_KEY), asked=json.dumps(_PREFIX + key), offered=json.dumps(offered))
    run_script(client, source)
    answer = None
    with suppress(RuntimeError, TimeoutError):
        answer = client.local_storage.get_item(key, timeout=_PATIENCE)
        client.local_storage.remove_item(key)
    return answer if answer is not None and len(answer) == len(offered) and answer.isalnum() else offered


def run_script(client: ClientHandle, source: str) -> None:
    """Run JavaScript of ours in a page."""
    client._websock_connection.queue_message(_messages.RunJavascriptMessage(source=source))
