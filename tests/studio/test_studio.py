"""Pages of a studio, in a real browser."""

import json
import pathlib
import socket
import threading
import time
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import pytest

from spiraltrunk.errors import StudioError
from spiraltrunk.studio.page.buttons import add_button
from spiraltrunk.studio.page.controls import Choice, Slider
from spiraltrunk.studio.page.scale import Scale

TABS = []
SCALE = Scale(label="Size", unit="mm", least=1, most=100, step=0.1, hint="Size of the ball")


class BallTab:
    """A ball of a size."""

    def __init__(self, page, title="Ball"):
        self.page, self.name, self.title = page, title.lower(), title
        self.closed = False
        TABS.append(self)

    def build(self):
        self.size = Slider(self.page, SCALE, 20.0, self.draw)
        self.kind = Choice(self.page, "Kind", ("round", "flat"), "round", lambda _: None, hint="Kind of ball")
        add_button(self.page, "Fail", self.fail, hint="Fails")
        self.draw(20.0)

    def draw(self, size):
        self.page.scene.add_icosphere(f"/{self.name}/ball", radius=size / 60, color=(0, 114, 178))

    def fail(self):
        raise StudioError("the ball is flat")

    def show(self):
        pass

    def hide(self):
        pass

    def read_settings(self):
        return {"size": self.size.value}

    def apply_settings(self, settings):
        self.size.set(settings["size"])
        self.draw(self.size.value)

    def close(self):
        self.closed = True


@pytest.fixture(autouse=True)
def no_tabs():
    TABS.clear()


def cube(page):
    return BallTab(page, "Cube")


def wait_until(holds, seconds=60.0):
    end = time.monotonic() + seconds
    while not holds() and time.monotonic() < end:
        time.sleep(0.05)
    assert holds()


def type_size(page, text):
    box = page.get_by_role("textbox").filter(visible=True).first
    box.fill(text)
    box.press("Enter")


def test_a_page_shows_its_first_tab_and_changes_with_its_controls(studio, open_page, take_picture):
    page = open_page(studio([BallTab, cube]))
    assert page.title() == "spiraltrunk studio"
    page.keyboard.press("Alt+2")
    page.get_by_role("button", name="Cube", pressed=True).wait_for()
    page.keyboard.press("Alt+1")
    page.get_by_role("button", name="Ball", pressed=True).wait_for()
    page.wait_for_timeout(500)
    before = take_picture(page, "before")
    type_size(page, "60")
    wait_until(lambda: TABS[0].size.value == 60.0)
    page.wait_for_timeout(500)
    after = take_picture(page, "after")
    assert (abs(after - before).sum(axis=2) > 60).mean() > 0.005


@pytest.mark.slow
def test_an_error_is_a_notice_and_a_closed_page_closes_its_tabs(studio, open_page):
    one = studio([BallTab])
    page = open_page(one)
    page.get_by_role("button", name="Fail").click()
    page.get_by_text("the ball is flat").wait_for()
    assert one.n_pages == 1
    page.close()
    wait_until(lambda: one.n_pages == 0)
    wait_until(lambda: TABS[0].closed)


@pytest.mark.slow
def test_a_refusal_replaces_the_last_one_and_goes_by_itself_and_an_error_stays(studio, open_page):
    page = open_page(studio([BallTab]))
    refusals = page.get_by_role("alert").filter(has_text="the ball is flat")
    for _ in range(3):
        page.get_by_role("button", name="Fail").click()
        page.wait_for_timeout(500)
        assert refusals.count() == 1
    TABS[0].page.notice("the export failed")
    type_size(page, "60")
    refusals.wait_for(state="detached", timeout=4000)
    page.get_by_role("button", name="Fail").click()
    refusals.wait_for()
    page.wait_for_timeout(5000)
    assert refusals.count() == 1, "there is time to read it"
    refusals.wait_for(state="detached", timeout=10_000)
    assert page.get_by_role("alert").filter(has_text="the export failed").is_visible()


@pytest.mark.slow
def test_many_errors_stay_in_the_window_and_the_page_does_not_scroll(studio, open_page):
    page = open_page(studio([BallTab]))
    for i in range(8):
        TABS[0].page.notice(f"failure {i}: " + "the disc is full, and so on; " * 12, topic=f"work {i}")
    page.get_by_text("failure 7").wait_for()
    page.wait_for_timeout(1500)  # They slide.
    told = page.get_by_role("alert").filter(has_text="failure")
    assert [text.split("\n")[1][:9] for text in told.all_inner_texts()] == ["failure 5", "failure 6", "failure 7"]
    assert page.evaluate("() => { scrollTo(0, 155); return document.documentElement.scrollTop; }") == 0
    assert page.evaluate("() => document.documentElement.scrollHeight <= innerHeight")


@pytest.mark.slow
def test_arrow_keys_on_a_slider_leave_the_camera(studio, open_page):
    page = open_page(studio([BallTab]))
    page.wait_for_timeout(1500)
    before = tuple(TABS[0].page.client.camera.position)
    slider = page.get_by_role("slider", name="Size [mm]", exact=True)
    slider.focus()
    page.keyboard.down("ArrowRight")
    page.wait_for_timeout(800)
    page.keyboard.up("ArrowRight")
    wait_until(lambda: TABS[0].size.value > 20.0)
    page.wait_for_timeout(500)
    assert tuple(TABS[0].page.client.camera.position) == before
    page.evaluate("document.activeElement.blur()")
    page.keyboard.down("ArrowRight")
    page.wait_for_timeout(800)
    page.keyboard.up("ArrowRight")
    wait_until(lambda: tuple(TABS[0].page.client.camera.position) != before)


@pytest.mark.slow
def test_the_server_answers_while_its_tabs_are_loaded(studio, open_page):
    loaded = threading.Event()

    def load():
        loaded.wait(60)
        return [BallTab]

    one = studio(load)
    page = open_page(one, until_shown=False)  # Answered before there are tabs.
    wait_until(lambda: one.n_pages == 1)
    assert not TABS
    loaded.set()
    page.get_by_role("button", name="Ball", pressed=True).wait_for()


@pytest.mark.slow
def test_tabs_that_cannot_be_loaded_are_a_notice(studio, open_page):
    def load():
        raise StudioError("a package is missing")

    one = studio(load)
    page = open_page(one, until_shown=False)
    notice = page.get_by_text("a package is missing")
    notice.wait_for()
    assert notice.count() == 1
    assert page.get_by_role("button", pressed=True).count() == 0, "there is no tab to show"
    assert one.n_pages == 1, "the page itself stays open"


@pytest.mark.slow
def test_three_pages_keep_apart_and_a_reload_comes_back(studio, open_page):
    one = studio([BallTab, cube])
    pages = [open_page(one) for _ in range(3)]
    balls = [tab for tab in TABS if tab.title == "Ball"]
    for page, size in zip(pages, ("10", "40", "70"), strict=True):
        page.bring_to_front()
        type_size(page, size)
    wait_until(lambda: sorted(ball.size.value for ball in balls) == [10.0, 40.0, 70.0])
    pages[1].get_by_role("button", name="Cube").click()
    pages[1].get_by_role("button", name="Cube", pressed=True).wait_for()
    pages[1].reload()
    pages[1].get_by_role("button", name="Cube", pressed=True).wait_for()
    again = [tab for tab in TABS[6:] if tab.title == "Ball"]
    wait_until(lambda: again[-1].size.value == 40.0)
    assert pages[0].get_by_role("button", name="Ball", pressed=True).is_visible()


def send(page, value):
    """Send a value for the slider as a hostile page would: past the slider itself."""
    handle = TABS[0].size.handle
    loop = TABS[0].page.client._viser_server.get_event_loop()
    import asyncio

    from viser import _messages

    message = _messages.GuiUpdateMessage(uuid=handle._impl.uuid, updates=value)
    connection = TABS[0].page.client._websock_connection
    asyncio.run_coroutine_threadsafe(connection._handle_incoming_message(connection.client_id, message), loop).result(5)


NO_VALUE = "a control sent what is no number, text or choice; nothing was changed"

HOSTILE = [
    ({"value": 9999.0}, "Size was 9999; allowed: 1 to 100 mm"), ({"value": float("nan")}, NO_VALUE),
    ({"value": "text"}, "Size was 'text'; allowed: a number, 1 to 100 mm"), ({"update_cb": []}, NO_VALUE),
    ({"value": "9" * 60}, f"Size was {'9' * 40}; allowed: 1 to 100 mm"), ({"value": [1.0] * 99}, NO_VALUE),
]  # fmt: skip


@pytest.mark.slow
def test_values_off_the_scale_change_nothing(studio, open_page):
    page = open_page(studio([BallTab]))
    handle = TABS[0].size.handle
    callbacks = list(handle._impl.update_cb)
    for value, words in HOSTILE:
        send(page, value)
        wait_until(lambda: handle.value == 20.0)
        assert TABS[0].size.value == 20.0
        assert handle._impl.update_cb == callbacks
        page.get_by_text(words).wait_for()
    notices = page.get_by_role("alert").filter(has_text="Not accepted")
    wait_until(lambda: notices.count() == 1)


def fetch(address, **headers):
    try:
        with urlopen(Request(address, headers=headers), timeout=10) as answer:
            return answer.status, dict(answer.headers), answer.read()
    except HTTPError as error:
        return error.code, dict(error.headers), error.read()


def test_the_page_cannot_be_framed_and_foreign_names_are_refused(studio):
    one = studio([BallTab])
    status, headers, body = fetch(one.address)
    assert status == 200
    assert headers["X-Frame-Options"] == "DENY"
    assert b"<html" in body
    status, _, body = fetch(one.address, Host="evil.example")
    assert status == 403
    assert b"evil.example" in body
    assert fetch(one.address, Origin="http://evil.example")[0] == 403


def connect(one, **headers):
    """Status of an attempt to open a WebSocket."""
    from websockets.exceptions import InvalidStatus
    from websockets.sync.client import connect as open_socket

    address = one.address.replace("http", "ws", 1)
    origin = headers.pop("origin", None)
    try:
        with open_socket(
            address, subprotocols=["viser-v1.1.1"], origin=origin, additional_headers=headers, open_timeout=10
        ):
            return 101
    except InvalidStatus as error:
        return error.response.status_code


def test_a_socket_needs_an_origin_of_this_page(studio):
    one = studio([BallTab])
    own = one.address.rstrip("/")
    assert connect(one, origin="http://evil.example") == 403
    assert connect(one, origin="null") == 403
    assert connect(one, origin=own.replace("127.0.0.1", "localhost")) == 403
    assert connect(one) == 403
    assert connect(one, origin=own) == 101


def test_another_host_needs_the_token(studio):
    one = studio([BallTab], host="0.0.0.0")
    token = one.address.partition("?token=")[2]
    port = one.address.split(":")[2].split("/")[0]
    bare = f"http://127.0.0.1:{port}/"
    assert len(token) > 16
    assert fetch(bare)[0] == 401
    assert fetch(f"{bare}?token=wrong")[0] == 401
    assert fetch(f"{bare}?token={token}")[0] == 200


@pytest.mark.slow
def test_a_page_with_the_token_keeps_it(studio, open_page):
    one = studio([BallTab], host="0.0.0.0")
    token = one.address.partition("?token=")[2]
    bare = f"http://127.0.0.1:{one.address.split(':')[2].split('/')[0]}/"
    page = open_page(one, own=True, address=f"{bare}?token={token}")
    page.goto(bare)  # The cookie has the token now.
    tab = page.get_by_role("button", name="Ball", pressed=True)
    tab.wait_for()
    assert tab.is_visible()
    assert page.url == bare, "the token is not in the address"
    (cookie,) = page.context.cookies()
    assert (cookie["value"], cookie["httpOnly"], cookie["sameSite"]) == (token, True, "Strict")


def test_a_busy_or_wrong_address_is_one_line(studio):
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(StudioError, match=f"port {port} of 127.0.0.1 cannot be opened"):
            studio([BallTab], port=port)
    with pytest.raises(StudioError, match="allowed: 0 to 65535"):
        studio([BallTab], port=70000)
    for host in ("192.0.2.1", "no such host"):
        with pytest.raises(StudioError, match=f"host is {host}: .*; allowed: an address of this computer"):
            studio([BallTab], host=host)


def test_no_tunnel_is_opened_on_request(studio):
    from viser import _messages

    server = studio([BallTab])._server._websock_server
    assert not server._incoming_handlers.keys() & {_messages.ShareUrlRequest, _messages.ShareUrlDisconnect}


@pytest.mark.slow
def test_two_hundred_reloads_do_not_grow_the_memory(studio, open_page):
    def read_memory():
        with pathlib.Path("/proc/self/status").open() as status:
            return next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))

    page = open_page(studio([BallTab, cube]))
    seen = []
    for i in range(200):
        page.reload()
        page.get_by_role("button", name="Ball", pressed=True).wait_for()
        TABS.clear()
        if i in (19, 199):
            seen.append(read_memory())
    print(json.dumps(seen))
    assert seen[1] < 1.1 * seen[0]
