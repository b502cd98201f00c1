"""Export of a design's parts: started, watched, stopped, and offered as one file."""

from __future__ import annotations

import shutil
import threading
from pathlib import Path
from typing import Any, final

from spiraltrunk.cad.output.catalogue import GROUPS
from spiraltrunk.cad.output.make_part import FORMATS
from spiraltrunk.design import TrunkDesign
from spiraltrunk.studio.design.files import name_file
from spiraltrunk.studio.design.jobs import ALL, make_archive
from spiraltrunk.studio.page.buttons import add_button
from spiraltrunk.studio.page.controls import Choice
from spiraltrunk.studio.page.job import STOPPED, Job
from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.page.scratch import make_scratch

_IDLE = "Printable parts of the present design, each one checked. All parts take about a minute."


@final
class PartExport:
    """Controls of the export, and its running job."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._job: Job | None = None
        self._folder: Path | None = None
        self._design: TrunkDesign = page.design
        self._made: tuple[str, bytes] | None = None

    def build(self) -> None:
        """Add the folder."""
        page = self._page
        with page.gui.add_folder("Printable parts", expand_by_default=False):
            self._status: Any = page.gui.add_markdown(_IDLE)
            self._group = Choice(page, "Parts", ("all", *GROUPS), "all", lambda _: None, hint="Which parts to make")
            self._format = Choice(
                page, "Format", (*FORMATS, ALL), "stl", lambda _: None,
                hint="stl and 3mf for a slicer, step for CAD; all formats has the MJCF and URDF models too",
            )  # fmt: skip
            self._start: Any = add_button(
                page, "Make parts", self._begin, hint="Make and check the parts, in the background"
            )
            self._bar: Any = page.gui.add_progress_bar(0.0, visible=False)
            self._stop: Any = add_button(
                page, "Stop", self.stop, hint="Stop making parts; nothing is kept", visible=False, color="orange"
            )
            self._offer: Any = add_button(
                page, "Download parts", self._send, hint="One ZIP file with parts, bill of materials and guide",
                visible=False,
            )  # fmt: skip
        page.on_design(lambda _: self._show_made())

    def stop(self) -> None:
        """Stop what runs."""
        if self._job is not None:
            self._job.stop()

    def close(self) -> None:
        """Stop what runs, and remove its folder once it has ended."""
        job, folder = self._job, self._folder
        if job is None or folder is None:
            return
        job.stop()

        def remove() -> None:
            waiting = threading.Event()
            while job.is_running:
                waiting.wait(0.1)
            shutil.rmtree(folder, ignore_errors=True)

        threading.Thread(target=remove, name="studio export", daemon=True).start()

    def _begin(self) -> None:
        if self._job is not None:
            return
        self._design, self._made = self._page.design, None
        self._folder = make_scratch("parts")
        self._show_running(True)
        self._status.content = "Starting …"
        self._bar.value = 0.0
        self._job = self._page.start(
            make_archive, self._design, self._group.value, self._format.value, str(self._folder),
            on_report=self._show_progress, on_end=self._end,
        )  # fmt: skip

    def _show_progress(self, step: tuple[str, int, int]) -> None:
        what, done, total = step
        if what in ("pictures", "models", "archive"):
            self._bar.value = 95.0
            self._status.content = f"Writing {what} …"
            return
        self._bar.value = 90.0 * done / max(1, total)
        made = f", last: {what}" if done else ""
        self._status.content = f"{done} of {total} parts made{made}"

    def _end(self, result: bytes | None, reason: str | None) -> None:
        self._job = None
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = None
        self._show_running(False)
        if result is None:
            self._status.content = "Stopped." if reason == STOPPED else _IDLE
            if reason != STOPPED:
                self._page.tell_failure(reason or "the export ended without a result", "parts")
            return
        self._page.clear_error("parts")
        name = name_file(self._design, "-parts.zip")
        self._made = name, result
        self._show_made()
        self._offer.visible = True

    def _show_made(self) -> None:
        """Say which file is ready, and whether the design has changed since it was asked for."""
        if self._made is None or self._job is not None:
            return
        name, content = self._made
        ready = f"`{name}`, {len(content) / 1e6:.1f} MB, is ready"
        is_present = self._page.design == self._design
        told = f"{ready}." if is_present else f"{ready}, **of the design before its last change**: make them again."
        if self._status.content != told:
            self._status.content = told

    def _send(self) -> None:
        if self._made is not None:
            self._page.download(*self._made)

    def _show_running(self, is_running: bool) -> None:
        self._start.visible = not is_running
        self._bar.visible = self._stop.visible = is_running
        if is_running:
            self._offer.visible = False
