"""Tab *Measure*."""

from __future__ import annotations

from pathlib import Path
from typing import Any, final

import numpy as np

from spiraltrunk.design import TrunkDesign, load_design
from spiraltrunk.design.schema import MOST_BYTES
from spiraltrunk.mocap.recordings.axes import NAMED
from spiraltrunk.mocap.session.prediction import MODELS
from spiraltrunk.mocap.signal.registration import KINDS
from spiraltrunk.studio.drawing.camera import aim_at_trunk
from spiraltrunk.studio.measure import jobs, texts
from spiraltrunk.studio.measure.picture import MeasurePicture
from spiraltrunk.studio.measure.runner import TOPIC, Runner
from spiraltrunk.studio.measure.take_folder import TakeFolder, find_folder, keep_folder
from spiraltrunk.studio.measure.view import Compared, CompareView
from spiraltrunk.studio.page.buttons import add_button, add_upload
from spiraltrunk.studio.page.controls import Choice, Slider
from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.page.scale import Scale
from spiraltrunk.studio.page.theme import GRAY
from spiraltrunk.studio.server.message_guard import MOST_UPLOAD
from spiraltrunk.workflows.validate.overlay import RunOverlay

_BY_NAME = "by the file's name"
_SEED = 0
"""Seed of the virtual session."""


@final
class MeasureTab:
    """Recordings over the model, and calibration from them."""

    name = "measure"
    title = "Measure"

    def __init__(self, page: Page) -> None:
        self._page = page
        self._takes = TakeFolder()
        self._view: CompareView | None = None
        self._calibrated: tuple[str, str] | None = None
        self._is_shown = self._is_due = False
        self._refusal = ""

    def build(self) -> None:
        """Add all controls."""
        self._runner = Runner(self._page)
        self._runner.on_idle = self._catch_up
        groups = self._page.gui.add_tab_group()
        with groups.add_tab("Takes"):
            self._build_takes()
        with groups.add_tab("Session"):
            self._build_session()
        with groups.add_tab("Model"):
            self._build_model()
        with groups.add_tab("Calibrate"):
            self._build_calibrate()
        self._below = self._page.gui.add_folder(None)
        self._build_picture()
        self._page.on_design(self._change_design)

    def show(self) -> None:
        """Run the comparison that was deferred while the tab was hidden, and restore the view."""
        self._is_shown = True
        self._camera.show()
        self._catch_up()

    def hide(self) -> None:
        """Remember the view."""
        self._is_shown = False
        self._camera.keep()

    def read_settings(self) -> dict[str, Any]:
        """Choices, and the folder of the recordings."""
        choices = {name: choice.value for name, choice in self._list_choices().items()}
        return {**choices, "folder": self._takes.name}

    def apply_settings(self, settings: dict[str, Any]) -> None:
        """Take choices and recordings of the page before its reload."""
        for name, choice in self._list_choices().items():
            choice.set(str(settings.get(name, "")))
        found = find_folder(str(settings.get("folder", "")))
        if found is not None:
            self._takes.close()
            self._takes = found
            self._show_takes()
            self._compare()

    def close(self) -> None:
        """Keep the recordings for a reload."""
        if self._takes.takes:
            keep_folder(self._takes)
        else:
            self._takes.close()

    def _build_takes(self) -> None:
        page = self._page
        hint = "Run of the packaged protocol that the virtual session has two takes of"
        runs = tuple(jobs.list_virtual_runs())
        self._virtual = Choice(page, "Virtual run", runs, runs[0], lambda _: None, hint=hint)
        hint = "A printed trunk by simulated cameras; it replaces all takes"
        add_button(page, "Record a virtual session", self._record_virtual, hint=hint)
        hint = "Run of the protocol that the next upload is a take of"
        self._run = Choice(page, "Upload as", self._list_runs(), _BY_NAME, lambda _: None, hint=hint)
        hint = "A take that Motive exported"
        add_upload(page, "Upload a take (CSV, C3D)", self._take_upload, hint=hint, most=MOST_UPLOAD, kinds=".csv,.c3d")
        self._list: Any = page.gui.add_html(texts.format_takes(()))

    def _build_session(self) -> None:
        page = self._page
        hint = "Axes of the export, which a file does not contain; Motive's own is y-up"
        self._axes = Choice(page, "Axes", tuple(NAMED), "y-up", lambda _: self._compare(), hint=hint)
        hint = "Your session's runs, where they are not the paper's"
        add_upload(page, "Upload a protocol (TOML)", self._take_protocol, hint=hint, most=MOST_BYTES, kinds=".toml")
        hint = "Forget all takes and an uploaded protocol"
        add_button(page, "Remove all takes", self._clear, hint=hint, color=GRAY)

    def _build_model(self) -> None:
        page = self._page
        hint = "reference: the paper's forward model; statics: equilibrium of joints, weight and cables"
        self._model = Choice(page, "Compared model", MODELS, MODELS[0], lambda _: self._compare(), hint=hint)
        hint = "Registration: by the rigid body at the base, one motion a take (run), or one a shape, which hides most"
        self._alignment = Choice(page, "Alignment", KINDS, "run", lambda _: self._compare(), hint=hint)
        add_button(page, "Download the report", self._download_report, hint="Page, figures and tables as a ZIP file")

    def _build_calibrate(self) -> None:
        page = self._page
        most = float(np.ceil(2e3 * page.design.total_mass))
        scale = Scale(
            label="Weighed mass", unit="g", least=0, most=most, step=0.1,
            hint="Mass of all sections with the gripper, no housing; 0: not weighed",
        )  # fmt: skip
        self._mass = Slider(page, scale, 0.0, lambda _: None)
        add_button(
            page, "Calibrate", self._calibrate, hint="Fit stiffness, mass, friction, slack and holes to the takes"
        )
        self._fit: Any = page.gui.add_html(texts.CALIBRATE)
        self._use: Any = add_button(
            page, "Use the calibrated design", self._use_design, hint="All tabs then show the calibrated trunk",
            visible=False,
        )  # fmt: skip
        self._save: Any = add_button(
            page, "Download the calibration", self._download_fit, hint="Design, figures and result as a ZIP file",
            visible=False,
        )  # fmt: skip

    def _build_picture(self) -> None:
        self._picture = MeasurePicture(self._page, self._page.design)
        self._camera = aim_at_trunk(self._page, self._page.design)

    def _change_design(self, _: TrunkDesign) -> None:
        self._drop_view()
        self._picture.remove()
        self._build_picture()
        self._compare()

    def _list_choices(self) -> dict[str, Choice]:
        return {"virtual": self._virtual, "axes": self._axes, "model": self._model, "alignment": self._alignment}

    def _list_runs(self) -> tuple[str, ...]:
        return (_BY_NAME, *(run.name for run in self._takes.protocol.runs))

    def _show_takes(self) -> None:
        self._list.content = texts.format_takes(self._takes.takes)
        self._run.set_options(self._list_runs())

    def _take_upload(self, name: str, content: bytes) -> None:
        self._takes.add(name, content, None if self._run.value == _BY_NAME else self._run.value)
        self._show_takes()
        self._compare()

    def _take_protocol(self, name: str, content: bytes) -> None:
        self._takes.set_protocol(content, name)
        self._show_takes()
        self._compare()
        self._page.notice(f"protocol {self._takes.protocol.name!r}: {len(self._takes.protocol.runs)} runs", "done")

    def _clear(self) -> None:
        self._runner.stop()
        self._takes.clear()
        self._show_takes()
        self._compare()

    def _record_virtual(self) -> None:
        run, folder = self._virtual.value, self._takes.next_file("")

        def done(files: list[str]) -> None:
            self._takes.set_virtual(folder, run, files)
            self._show_takes()
            self._compare()

        self._runner.start(
            jobs.record_virtual, self._page.design, run, _SEED, str(folder), done=done, failed=self._tell_failure
        )

    def _ask(self) -> jobs.Question:
        return jobs.Question(
            design=self._page.design, protocol=self._takes.protocol_file, takes=self._takes.list_by_run(),
            axes=self._axes.value, model=self._model.value, alignment=self._alignment.value,
        )  # fmt: skip

    def _compare(self) -> None:
        """Compare all takes with the model, or wait until the tab is shown."""
        waits = self._runner.is_busy and not self._runner.is_running(jobs.compare_takes)
        if waits:
            self._page.notice("compared anew once the work that runs has ended", "warning")
        self._is_due = waits or not self._is_shown
        if self._is_due:
            return
        if not self._takes.takes:
            self._drop_view()
            self._runner.say(texts.EMPTY)
            return
        self._runner.start(jobs.compare_takes, self._ask(), done=self._draw, failed=self._refuse)

    def _catch_up(self) -> None:
        """Run a comparison that was deferred."""
        if self._is_due and self._is_shown and not self._runner.is_busy:
            self._compare()

    def _tell_failure(self, reason: str) -> None:
        self._page.tell_failure(reason, TOPIC)

    def _refuse(self, reason: str) -> None:
        """Show the reason, and remove the take that cannot be read; the others are compared without it."""
        guilty = [take for take in self._takes.takes if take.file in reason]
        told = self._takes.name_files(reason)
        self._runner.say(texts.format_failed(told))
        if guilty:
            self._page.notice(told, "refusal")
        if len(guilty) == 1 and guilty[0].file.startswith(str(self._takes.folder / "upload")):
            self._takes.remove(guilty[0])
            self._show_takes()
            if self._takes.takes:  # What was there before is compared without it.
                self._refusal = told
                self._compare()
                return
        self._drop_view()

    def _draw(self, found: tuple[tuple[RunOverlay, ...], dict[str, Any]]) -> None:
        runs, result = found
        self._page.clear_refusal()
        if self._refusal:  # Of a take that was removed, for some seconds more.
            self._page.notice(self._refusal, "refusal")
        self._refusal = ""
        result["notes"] = [self._takes.name_files(note) for note in result["notes"]]
        self._drop_view()
        names = {take.file: take.name for take in self._takes.takes}
        self._view = CompareView(
            self._page, self._below, self._picture, Compared(runs=runs, result=result, names=names)
        )

    def _drop_view(self) -> None:
        if self._view is not None:
            self._view.remove()
            self._view = None
        self._picture.draw_straight()

    def _is_ready(self) -> bool:
        """Whether there are takes and nothing else runs; says so where not."""
        if not self._takes.takes:
            self._page.notice("there is no take; upload one, or record a virtual session", "refusal")
        elif self._runner.is_busy:
            self._page.notice("other work runs; wait, or stop it", "refusal")
        return bool(self._takes.takes) and not self._runner.is_busy

    def _download_report(self) -> None:
        if not self._is_ready():
            return

        def done(file: str) -> None:
            self._page.download("validation.zip", Path(file).read_bytes())

        self._runner.start(
            jobs.write_report, self._ask(), str(self._takes.next_file("")), done=done, failed=self._tell_failure
        )

    def _calibrate(self) -> None:
        if not self._is_ready():
            return

        def done(found: tuple[dict[str, Any], str, str]) -> None:
            result, design, packed = found
            self._calibrated = (design, packed)
            self._fit.content = texts.format_calibration(result)
            self._use.visible = self._save.visible = True

        place = str(self._takes.next_file(""))
        self._runner.start(
            jobs.calibrate_takes, self._ask(), self._mass.value, place, done=done, failed=self._tell_failure
        )

    def _use_design(self) -> None:
        if self._calibrated is not None:
            self._page.set_design(load_design(self._calibrated[0]))
            self._page.notice("all tabs show the calibrated design", "done")

    def _download_fit(self) -> None:
        if self._calibrated is not None:
            self._page.download("calibration.zip", Path(self._calibrated[1]).read_bytes())
