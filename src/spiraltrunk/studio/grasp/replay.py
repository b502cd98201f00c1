"""A recording as one HTML file that plays and scrubs in any browser, without a server or a network."""

from __future__ import annotations

import html
import secrets
from pathlib import Path

from viser import ViserServer

from spiraltrunk.files.atomic import write_text
from spiraltrunk.studio.grasp.stage_view import CAMERA, FIELD, LOOK_AT, StageView
from spiraltrunk.studio.server.gate import Gate
from spiraltrunk.studio.server.serve import open_port, silence, start_server
from spiraltrunk.workflows.grasp.recording import RATE, Recording

_HOST = "127.0.0.1"

_LABEL_PLACE = (0.19, 0.05, 1.75)
"""Place of the right end of the label with phase and action [m]: over the arm, left of the strings of a hung object."""

_UNIT = """<style>
  .mantine-NumberInput-wrapper::after { content: "s"; position: absolute; right: 0.25em; line-height: 1;
    top: calc(50% - 0.5em); font: 12px ui-monospace, monospace; pointer-events: none; }
  .mantine-NumberInput-input { text-align: left !important; }
</style>"""
"""The unit of viser's box of the time, which has none."""


def write_replay(recording: Recording, path: str | Path, *, is_dark: bool = False) -> None:
    """Write a replay to an HTML file.

    Raises:
        OSError: where the file cannot be written.
        RunError: where viser does not start.
    """
    write_text(Path(path), format_replay(recording, is_dark=is_dark))


def format_replay(recording: Recording, *, is_dark: bool = False) -> str:
    """A recording as an HTML page that holds viser's viewer and all poses.

    Viser records what a server sends. This one has a page of nobody: it listens on this computer alone, for as long as
    the recording takes, behind a token that nobody is told.

    Args:
        recording: what is shown.
        is_dark: whether the page has a dark background.

    Raises:
        RunError: where viser does not start.
    """
    opened = open_port(_HOST, 0)
    gate = Gate(host=_HOST, port=opened.getsockname()[1], token=secrets.token_urlsafe(16))
    server = start_server(opened, gate)
    try:
        server.scene.set_up_direction("+z")
        _aim(server)
        view, frames = StageView(server.scene, "/stage", is_dark=is_dark), recording.frames
        view.draw(recording.meshes, frames)
        label = server.scene.add_label("/label", _describe(recording, 0), position=_LABEL_PLACE, anchor="center-right")
        serializer = server.get_scene_serializer()
        with server.atomic():  # Nobody is there to send anything to.
            for i in range(len(frames)):
                if i and (frames.phase[i], frames.action[i]) != (frames.phase[i - 1], frames.action[i - 1]):
                    label.text = _describe(recording, i)
                view.show(frames, i)
                serializer.insert_sleep(1.0 / RATE)
        page = str(serializer.as_html(dark_mode=is_dark))
    finally:
        with silence():
            server.stop()
    return page.replace("<title>Viser</title>", f"<title>{html.escape(recording.title)}</title>{_UNIT}", 1)


def _aim(server: ViserServer) -> None:
    camera = server.initial_camera
    camera.position, camera.look_at, camera.fov = CAMERA, LOOK_AT, FIELD


def _describe(recording: Recording, index: int) -> str:
    return f"{recording.frames.phase[index]}: {recording.frames.action[index]}"
