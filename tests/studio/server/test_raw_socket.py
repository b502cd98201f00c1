"""Attacks by a raw WebSocket, past the page: what a program on this computer, or a page of another site, could send."""

import struct
import time
from contextlib import ExitStack, contextmanager
from functools import partial

import pytest

pytest.importorskip("viser", reason="viser is not installed")

import msgspec
from viser import _messages
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from spiraltrunk.design import presets
from spiraltrunk.studio.robot import hub as hub_module
from spiraltrunk.studio.robot.hub import RobotHub
from spiraltrunk.studio.robot.tab import RobotTab
from spiraltrunk.studio.server.serve import MOST_MESSAGE

PROTOCOL = ["viser-v1.1.1"]

CAMERA = _messages.ViewerCameraMessage(
    wxyz=(1.0, 0.0, 0.0, 0.0), position=(1.0, 0.0, 0.0), fov=1.0, near=0.01, far=100.0, image_height=800,
    image_width=1280, look_at=(0.0, 0.0, 0.0), up_direction=(0.0, 0.0, 1.0),
)  # fmt: skip


class FakeLink:
    """A link that keeps what it is asked."""

    def __init__(self, setup, *, on_state, on_refusal, on_end):
        self.setup, self.asked, self._on_end = setup, [], on_end

    def start(self):
        pass

    def ask(self, request, asker=""):
        self.asked.append(request)

    def close(self):
        self._on_end(None)

    def join(self):
        pass


@pytest.fixture
def hub(monkeypatch):
    monkeypatch.setattr(hub_module, "RobotLink", FakeLink)
    one = RobotHub(presets.PAPER)
    yield one
    one.close()


@contextmanager
def open_socket(studio, *, query="", cookie=None):
    """A WebSocket with the right origin."""
    host = studio.address.split("?")[0].rstrip("/").replace("0.0.0.0", "127.0.0.1")
    headers = {} if cookie is None else {"Cookie": cookie}
    with connect(
        host.replace("http", "ws", 1) + "/" + query, subprotocols=PROTOCOL, origin=host, additional_headers=headers,
        max_size=None, close_timeout=0.5,  # Unread messages keep the answer to a closing from being seen.
    ) as socket:  # fmt: skip
        socket.send(pack(CAMERA))  # A page of viser begins with it.
        yield socket


def read_all(socket):
    while True:
        socket.recv(timeout=20)


def pack(message):
    return msgspec.msgpack.encode(message.as_serializable_dict())


def wait_until(holds, seconds=20.0):
    end = time.monotonic() + seconds
    while not holds() and time.monotonic() < end:
        time.sleep(0.05)
    assert holds()


def find_tab(hub, number):
    """The robot's tab of a page, and its controls by label."""
    wait_until(lambda: len(hub._watchers) > number)
    tab = hub._watchers[number]._tab
    wait_until(lambda: hasattr(tab, "_stop"))
    handles = tab._page.client.gui._gui_input_handle_from_uuid.values()
    return tab, {getattr(one._impl.props, "label", "") or one._impl.uuid: one for one in handles}


def test_a_socket_with_a_wrong_token_is_refused(studio):
    one = studio([], host="0.0.0.0")
    token = one.address.partition("?token=")[2]
    port = one._gate.port
    for query, cookie in (
        ("", None), ("?token=wrong", None), ("?token=", None), (f"?token={token[:-1]}", None), ("?token=%ff", None),
        ("", f"spiraltrunk_token_{port}=wrong"), ("", f"spiraltrunk_token={token}"), (f"?TOKEN={token}", None),
    ):  # fmt: skip
        with pytest.raises(InvalidStatus) as refused, open_socket(one, query=query, cookie=cookie):
            pass
        assert refused.value.response.status_code == 401
    for query, cookie in ((f"?token={token}", None), ("", f"spiraltrunk_token_{port}={token}")):
        with open_socket(one, query=query, cookie=cookie) as socket:
            assert socket.subprotocol == PROTOCOL[0]


def test_bytes_that_are_no_message_end_that_page_alone(studio, hub):
    one = studio([partial(RobotTab, hub=hub)])
    with open_socket(one) as good:
        find_tab(hub, 0)
        for junk in (b"", b"\xff" * 100, msgspec.msgpack.encode({"type": "NoSuchMessage"}), struct.pack("<Q", 2**63)):
            with open_socket(one) as bad:
                bad.send(junk)
                time.sleep(0.2)
        with open_socket(one) as bad:
            bad.send(bytes(MOST_MESSAGE + 1))
            with pytest.raises(ConnectionClosed):
                read_all(bad)
        wait_until(lambda: one.n_pages == 1)
        good.send(pack(_messages.GuiUpdateMessage(uuid="no such control", updates={"value": 1.0})))
        good.ping().wait(10)
    wait_until(lambda: one.n_pages == 0)


def test_a_page_without_control_cannot_move_the_robot_by_hidden_buttons(studio, hub):
    one = studio([partial(RobotTab, hub=hub)])
    with ExitStack() as sockets:
        sockets.enter_context(open_socket(one))
        owner, _ = find_tab(hub, 0)
        thief = sockets.enter_context(open_socket(one))
        _, controls = find_tab(hub, 1)
        owner._page.post(owner._connect)
        wait_until(lambda: hub.owner == owner.name_of_page)
        asked = hub._link.asked
        asked.clear()
        for label in ("Home", "Enable", "Disable", "I found the cause: clear the fault", "All cables follow",
                      "Run on the twin", "Move to the pose", "Disconnect", "Take control", "Connect"):  # fmt: skip
            thief.send(pack(_messages.GuiUpdateMessage(uuid=controls[label]._impl.uuid, updates={"value": True})))
        for label, values in (("Cable 1", ("wind in", "9999", 5.0)), ("Step [mm]", (9999.0, float("nan"), "text"))):
            for value in values:
                thief.send(pack(_messages.GuiUpdateMessage(uuid=controls[label]._impl.uuid, updates={"value": value})))
        thief.send(pack(_messages.GuiUpdateMessage(uuid=owner._buttons["home"]._impl.uuid, updates={"value": True})))
        time.sleep(1.5)
        assert asked == []
        assert hub.owner == owner.name_of_page
        stop = next(one for label, one in controls.items() if label.startswith("STOP"))
        thief.send(pack(_messages.GuiUpdateMessage(uuid=stop._impl.uuid, updates={"value": True})))
        wait_until(lambda: len(asked) == 1)  # Stop is for everyone.
