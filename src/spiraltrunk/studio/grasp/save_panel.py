"""Files of a grasp, made in the background and offered for download."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, final

from spiraltrunk.files.results import format_json
from spiraltrunk.studio.grasp.jobs import Progress, draw_film, draw_replay, draw_strip
from spiraltrunk.studio.grasp.kept import KeptGrasp
from spiraltrunk.studio.grasp.request import GraspRequest
from spiraltrunk.studio.page.buttons import add_button
from spiraltrunk.studio.page.job import STOPPED, Job, Work
from spiraltrunk.studio.page.markdown import escape_markdown
from spiraltrunk.studio.page.page import Page
from spiraltrunk.workflows.grasp.recording import Recording


@final
class SavePanel:
    """Buttons of the files of the grasp that is shown; one file at a time is made."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._request: GraspRequest | None = None
        self._recording: Recording | None = None
        self._result: dict[str, Any] | None = None
        self._job: Job | None = None
        self._folder: Any = page.gui.add_folder("Save", visible=False)
        with self._folder:
            self._command: Any = page.gui.add_markdown("")
            self._buttons = [
                self._add("Replay (HTML)", self._save_replay, "One file that plays in any browser, to share"),
                self._add("Film strip (PNG)", self._save_strip, "The moments of the grasp on a sheet"),
                self._add("Video (MP4)", self._save_film, "The grasp in real time; takes about a minute"),
                self._add("Result (JSON)", self._save_result, "Verdict and all figures"),
            ]
            self._state: Any = page.gui.add_markdown("", visible=False)
            self._bar: Any = page.gui.add_progress_bar(0.0, visible=False, animated=True)
            hint = "End what is being made; nothing is saved"
            self._stop: Any = add_button(page, "Stop saving", self.stop, hint=hint, visible=False, color="orange")

    def offer(self, grasp: KeptGrasp) -> None:
        """Offer the files of a grasp."""
        self._request, self._recording, self._result = grasp.request, grasp.recording, grasp.result
        label = f"*{escape_markdown(grasp.request.name)}* by *{grasp.request.strategy}*"
        self._command.content = (
            f"{label}. The same by a command: `{grasp.request.command} --out DIR --replay FILE.html`"
        )
        self._folder.visible = True

    def clear(self) -> None:
        """Offer nothing; what is being made is stopped."""
        self.stop()
        self._folder.visible = False
        self._request = self._recording = self._result = None

    def stop(self) -> None:
        """End what is being made."""
        if self._job is not None:
            self._job.stop()

    def _add(self, label: str, act: Callable[[], None], hint: str) -> Any:
        return add_button(self._page, label, act, hint=hint)

    def _save_replay(self) -> None:
        if self._recording is not None:
            self._start("replay.html", draw_replay, self._recording)

    def _save_strip(self) -> None:
        if self._request is not None:
            self._start("filmstrip.png", draw_strip, self._request)

    def _save_film(self) -> None:
        if self._request is not None:
            self._start("grasp.mp4", draw_film, self._request)

    def _save_result(self) -> None:
        if self._result is not None:
            self._page.download("result.json", (format_json(self._result) + "\n").encode())

    def _start(self, name: str, work: Work, *arguments: Any) -> None:
        if self._job is not None:
            self._page.notice("one file at a time: wait for the one that is being made, or stop it", "refusal")
            return
        self._show(f"Making *{name}* ...", 0.0)
        self._job = self._page.start(
            work, *arguments, on_report=lambda progress: self._show_progress(name, progress),
            on_end=lambda content, reason: self._end(name, content, reason),
        )  # fmt: skip

    def _show_progress(self, name: str, progress: Progress) -> None:
        done = f" {progress.done} of {progress.total}" if progress.total else ""
        self._show(f"Making *{name}*: {progress.step}{done} ...", 100.0 * progress.done / max(1, progress.total))

    def _show(self, text: str, percent: float) -> None:
        self._state.content, self._bar.value = text, percent
        self._state.visible = self._bar.visible = self._stop.visible = True

    def _end(self, name: str, content: bytes | None, reason: str | None) -> None:
        self._job = None
        self._state.visible = self._bar.visible = self._stop.visible = False
        if content is not None:
            self._page.clear_error("save")
            self._page.download(name, content)
        elif reason != STOPPED:
            self._page.notice(f"{name}: {reason}", topic="save")
