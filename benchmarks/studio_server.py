"""Whether the studio's server grows: hundreds of acts of one page without a browser, and what its heap keeps.

A program takes the place of the browser. It answers the heartbeats of the connected twin, which come `--haste` times as
often as usual, and sends the values of sliders. Tabs are shown and a grasp is played in the page's own thread. After
each part of the time one line tells Python's objects, what the C library has given out and what it keeps free, and the
resident memory, all after `malloc_trim`. Objects and what is given out tell a leak; what is kept free tells how the
heap is set (`spiraltrunk.studio.server.heap`, left out with `--unbound`). The memory of the page in a real browser is
`studio_hours.py`'s.

    python benchmarks/studio_server.py --minutes 7
"""

from __future__ import annotations

import argparse
import ctypes
import gc
import os
import random
import re
import struct
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import msgspec
import zstandard
from viser import _messages
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from spiraltrunk.design import presets
from spiraltrunk.studio.page.frame import Frame
from spiraltrunk.studio.robot import hub as hub_module
from spiraltrunk.studio.robot.hub import RobotHub
from spiraltrunk.studio.server.heap import bound_heap
from spiraltrunk.studio.studio import Studio, StudioOptions
from spiraltrunk.studio.tabs import build_tabs

TABS = ("Design", "Shape", "Grasp", "Measure", "Robot")

CAMERA = _messages.ViewerCameraMessage(
    wxyz=(1.0, 0.0, 0.0, 0.0), position=(1.0, 0.0, 0.0), fov=1.0, near=0.01, far=100.0, image_height=800,
    image_width=1280, look_at=(0.0, 0.0, 0.0), up_direction=(0.0, 0.0, 1.0),
)  # fmt: skip
"""With it a page of viser begins."""

BEAT = re.compile(rb"request_uuid.([0-9a-f]{16}-\d+)", re.DOTALL)
"""Name of a question of the heartbeat, in msgpack."""

FIRST_SLIDERS = 6
"""Sliders of a tab that are moved [-]."""

FIELDS = (
    "arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks", "fordblks", "keepcost"
)  # fmt: skip
"""Names of the fields of `Heap`."""


class Heap(ctypes.Structure):
    """What glibc's ``mallinfo2`` returns."""

    _fields_ = [(name, ctypes.c_size_t) for name in FIELDS]


def main() -> None:
    """Act, and print."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--minutes", type=float, default=7.0, help="time of acts (default 7)")
    parser.add_argument("--every", type=float, default=45.0, help="seconds between two lines (default 45)")
    parser.add_argument("--haste", type=float, default=5.0, help="times as many heartbeats (default 5)")
    parser.add_argument("--seed", type=int, default=1, help="seed of the acts")
    parser.add_argument("--unbound", action="store_true", help="leave the C library's heap as it is")
    given = parser.parse_args()
    if not given.unbound and not bound_heap():
        print("the C library is not glibc: its heap is as it is")
    hub_module.BEAT_PERIOD /= given.haste
    hub = RobotHub(presets.PAPER)
    frames = keep_frames()
    studio = Studio(presets.PAPER, build_tabs(lambda: hub), StudioOptions(port=0))
    try:
        with open_page(studio.address) as page:
            wait_for(lambda: bool(frames))
            act(page, frames[0], given)
    finally:
        studio.stop()
        hub.close()


def keep_frames() -> list[Frame]:
    """Frames of the pages that are opened from now on."""
    frames: list[Frame] = []
    build = Frame.__init__

    def keep(self: Frame, *arguments: Any) -> None:
        build(self, *arguments)
        frames.append(self)

    Frame.__init__ = keep  # type: ignore[method-assign]
    return frames


@contextmanager
def open_page(address: str) -> Iterator[ClientConnection]:
    """A connection of a page that answers the heartbeats."""
    host = address.rstrip("/")
    with connect(
        host.replace("http", "ws", 1) + "/", subprotocols=["viser-v1.1.1"], origin=host, max_size=None  # type: ignore[list-item,arg-type]
    ) as socket:  # fmt: skip
        send(socket, CAMERA)
        threading.Thread(target=answer, args=(socket,), daemon=True).start()
        yield socket


def send(socket: ClientConnection, message: Any) -> None:
    """Send a message as the browser's client does."""
    socket.send(msgspec.msgpack.encode(message.as_serializable_dict()))


def answer(socket: ClientConnection) -> None:
    """Answer the heartbeats until the connection is closed."""
    while True:
        try:
            part = socket.recv()
        except ConnectionClosed:
            return
        size, packed = struct.unpack_from("<QQ", part)
        inner = zstandard.ZstdDecompressor().decompress(part[16 : 16 + packed], max_output_size=size)
        for name in BEAT.findall(inner):
            reply = _messages.LocalStorageGetItemResponseMessage(value=None, error=None, request_uuid=name.decode())
            send(socket, reply)


def wait_for(holds: Any, seconds: float = 120.0) -> None:
    """Wait until something holds."""
    end = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > end:
            raise TimeoutError("the studio did not come that far")
        time.sleep(0.1)


def act(socket: ClientConnection, frame: Frame, given: argparse.Namespace) -> None:
    """Open every tab, connect the twin, run a grasp; then act at random and report."""
    page, tabs = frame._page, frame._tabs

    def post(do: Any) -> None:
        page.post(do)

    def show(title: str) -> None:
        post(lambda: frame.show(title))

    time.sleep(6.0)  # What a page builds by itself after it has opened.
    for title in TABS:
        show(title)
        time.sleep(4.0)
    robot, run = tabs["Robot"]._tab, tabs["Grasp"].panel  # type: ignore[attr-defined]
    for do in (robot._connect, robot._take):
        post(do)
        time.sleep(4.0)
    post(run.run)
    time.sleep(3.0)
    wait_for(lambda: not run.is_running)
    sliders = find_sliders(page.gui)
    draw, acts, began = random.Random(given.seed), 0, time.monotonic()
    report(0.0, acts)
    due = began + given.every
    while time.monotonic() < began + 60 * given.minutes:
        title = draw.choice(TABS)
        acts += 1
        show(title)
        time.sleep(0.3)
        if title == "Grasp":
            post(run.toggle)
            time.sleep(1.2)
            post(run.toggle)
        elif sliders.get(title):
            move(socket, draw, sliders[title])
        else:
            time.sleep(0.8)
        if time.monotonic() >= due:
            due += given.every
            report(time.monotonic() - began, acts)


def find_sliders(gui: Any) -> dict[str, list[Any]]:
    """The first sliders of each tab, by its title."""
    found: dict[str, list[Any]] = {}
    for handle in list(gui._gui_input_handle_from_uuid.values()):
        if type(handle).__name__ != "GuiSliderHandle":
            continue
        parent, title = handle._impl.parent_container_id, ""
        while parent != "root":
            folder = getattr(gui._container_handle_from_uuid[parent], "_impl", None)
            title, parent = ("", "root") if folder is None else (folder.props.label, folder.parent_container_id)
        found.setdefault(title, []).append(handle)  # Under "" those within tabs of a tab.
    return {title: handles[:FIRST_SLIDERS] for title, handles in found.items()}


def move(socket: ClientConnection, draw: random.Random, sliders: list[Any]) -> None:
    """Move four sliders by two steps, and back."""
    for _ in range(4):
        slider = draw.choice(sliders)
        props, here = slider._impl.props, slider.value
        step = draw.choice((-2, 2)) * props.step
        for value in (min(max(here + step, props.min), props.max), here):
            send(socket, _messages.GuiUpdateMessage(uuid=slider._impl.uuid, updates={"value": value}))
            time.sleep(0.15)


def report(seconds: float, acts: int) -> None:
    """One line of what the process holds, after the C library has given back what it can."""
    gc.collect()
    library = ctypes.CDLL("libc.so.6")
    library.mallinfo2.restype = Heap
    library.malloc_trim(0)
    heap, pages = library.mallinfo2(), int(Path("/proc/self/statm").read_text().split()[1])
    resident = pages * os.sysconf("SC_PAGE_SIZE") / 2**20
    given_out, free = (heap.uordblks + heap.hblkhd) / 2**20, heap.fordblks / 2**20
    print(
        f"{seconds / 60:.1f} min, {acts} acts: {len(gc.get_objects())} objects, {given_out:.1f} MB given out, "
        f"{free:.1f} MB kept free, {resident:.1f} MB resident",
        flush=True,
    )


if __name__ == "__main__":
    main()
