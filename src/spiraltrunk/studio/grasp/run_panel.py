"""Run of a grasp: started, shown as it is computed, stopped; then its timeline, plots and result."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, final

from spiraltrunk.sim.body_meshes import ModelMeshes
from spiraltrunk.strategies.moves import PHASES
from spiraltrunk.studio.grasp.course_plots import CoursePlots
from spiraltrunk.studio.grasp.jobs import Scene, run_grasp
from spiraltrunk.studio.grasp.kept import KeptGrasp
from spiraltrunk.studio.grasp.player import Player
from spiraltrunk.studio.grasp.request import GraspRequest
from spiraltrunk.studio.grasp.stage_view import StageView
from spiraltrunk.studio.grasp.texts import (
    START,
    describe_frame,
    describe_phases,
    describe_reload,
    describe_result,
    format_figures,
)
from spiraltrunk.studio.page.buttons import add_button
from spiraltrunk.studio.page.controls import Slider
from spiraltrunk.studio.page.job import STOPPED, Job
from spiraltrunk.studio.page.markdown import escape_markdown
from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.page.scale import Scale
from spiraltrunk.workflows.grasp.recording import RATE, Frames, Recording, join_frames

SLOW = 3
"""Frames after which timeline, text and plots follow the picture while it plays [-]."""

LATE = 10
"""Reports after which the plots follow a run [-]."""

_TIMELINE = Scale(
    label="Time", unit="s", least=0.0, most=1.0, step=1.0 / RATE, digits=3, hint="Drag to any moment of the grasp"
)
"""Scale of the timeline, of which a step is one frame."""


@final
class RunPanel:
    """Buttons, progress, timeline, result and plots of one grasp at a time."""

    def __init__(
        self,
        page: Page,
        view: StageView,
        *,
        read: Callable[[], GraspRequest],
        on_start: Callable[[], None],
        on_result: Callable[..., None],
    ) -> None:
        """Add the controls.

        Args:
            page: the page.
            view: where the robot is drawn.
            read: what the person asks for; raises an error in words.
            on_start: called when a grasp is started.
            on_result: called with request, recording and result of a grasp that ended.
        """
        self._page, self._view, self._read = page, view, read
        self._on_start, self._on_result = on_start, on_result
        self._job: Job | None = None
        self._request: GraspRequest | None = None
        self.n_shown = 0
        """Grasps that were started or opened [-]."""
        self._meshes: ModelMeshes | None = None
        self._parts: list[Frames] = []
        self._frames: Frames | None = None
        self._index = 0
        self._player = Player(page, self._play_to, self._show_buttons)
        gui = page.gui
        self._note: Any = gui.add_markdown("", visible=False)
        self._state: Any = gui.add_markdown(START)
        self._run: Any = add_button(page, "Run grasp", self.run, hint="Simulate the grasp and show it", icon=None)
        hint = "End the run; what was computed so far can be looked at"
        self._stop: Any = add_button(page, "Stop", self.stop, hint=hint, visible=False, color="orange")
        self._bar: Any = gui.add_progress_bar(0.0, visible=False, animated=True)
        self._timeline_folder: Any = gui.add_folder(None, visible=False)
        with self._timeline_folder:
            self._timeline = Slider(page, _TIMELINE, 0.0, self._scrub)
            self._phases: Any = gui.add_markdown("")
            hint = "Play in real time, from the start where it has ended"
            self._play: Any = add_button(page, "Play", self.toggle, hint=hint, color="green")
        self._result: Any = gui.add_markdown("", visible=False)
        self.plots = CoursePlots(page)
        self._table_folder: Any = gui.add_folder("Figures", visible=False, expand_by_default=False)
        with self._table_folder:
            self._table: Any = gui.add_markdown("")

    @property
    def is_running(self) -> bool:
        """Whether a grasp is being computed."""
        return self._job is not None

    @property
    def running(self) -> str:
        """Object and strategy of the grasp that is being computed; empty where none is."""
        return "" if self._job is None or self._request is None else self._request.label

    @property
    def request(self) -> GraspRequest | None:
        """What was asked for last; None before."""
        return self._request

    def run(self) -> None:
        """Start the grasp that is asked for."""
        if self._job is not None:
            return
        request = self._request = self._read()
        self.n_shown += 1
        self._on_start()
        self.clear()
        self.hide_note()
        self._state.content = "Starting the simulation; the first one on a computer compiles for up to a minute ..."
        self._run.visible, self._stop.visible, self._bar.visible, self._bar.value = False, True, True, 0.0
        self._job = self._page.start(
            run_grasp, request, on_report=self._take,
            on_end=lambda result, reason: self._end(request, result, reason),
        )  # fmt: skip

    def stop(self) -> None:
        """End the run."""
        if self._job is not None:
            self._job.stop()

    def pause(self) -> None:
        """Stop playing."""
        self._player.pause()
        self._show_buttons()

    def show_scene(self, scene: Scene) -> None:
        """Show a scene in which nothing moves yet, unless a grasp is being computed."""
        if self._job is None:
            self.clear()
            with self._page.client.atomic():
                self._view.draw(scene.meshes, scene.frames)

    def clear(self) -> None:
        """Forget the former grasp."""
        self._player.pause()
        self._parts, self._frames, self._index = [], None, 0
        self._timeline_folder.visible = self._result.visible = self._table_folder.visible = False
        self._state.content = START
        self.plots.clear()

    def open(self, grasp: KeptGrasp) -> None:
        """Show a grasp that has ended, with its timeline, the last frame first, and its result."""
        self.n_shown += 1
        self.clear()
        self._request, self._meshes, frames = grasp.request, grasp.recording.meshes, grasp.recording.frames
        with self._page.client.atomic():
            self._view.draw(self._meshes, frames)
        self._open_timeline(frames)
        self._show_result(grasp.request, grasp.result)

    def tell_reload(self, running: str) -> None:
        """Tell that a reload stopped a grasp, and which one is shown instead.

        Args:
            running: object and strategy of the grasp that was stopped.
        """
        shown = "" if self._frames is None or self._request is None else self._request.label
        text = describe_reload(running, shown)
        self._note.content, self._note.visible = f"**Note:** {escape_markdown(text)}", True
        self._page.notice(text, "warning")

    def hide_note(self) -> None:
        """Forget that a reload stopped a grasp."""
        self._note.visible = False

    def toggle(self) -> None:
        """Play, or stop playing."""
        if self._frames is None:
            return
        if self._player.is_playing:
            self.pause()
            return
        ended = self._index >= len(self._frames) - 1
        self._player.play(0 if ended else self._index, len(self._frames))
        self._show_buttons()

    def _take(self, report: ModelMeshes | Frames) -> None:
        """Take the meshes, then frames, and show the last one."""
        if isinstance(report, ModelMeshes):
            self._meshes = report
            return
        assert self._meshes is not None
        self._parts.append(report)
        last = len(report) - 1
        with self._page.client.atomic():
            if len(self._parts) == 1:
                self._view.draw(self._meshes, report)
            self._view.show(report, last)
            self._show_progress(report)
        if len(self._parts) % LATE == 0:
            frames = join_frames(self._parts)
            self._parts = [frames]
            self.plots.draw(frames, len(frames) - 1)

    def _show_progress(self, frames: Frames) -> None:
        last = len(frames) - 1
        self._state.content = f"Computing. {describe_frame(frames, last)}"
        phase = frames.phase[last]
        done = PHASES.index(phase) + 0.5 if phase in PHASES else 0.5
        self._bar.value = 100.0 * done / len(PHASES)

    def _end(self, request: GraspRequest, result: dict[str, Any] | None, reason: str | None) -> None:
        self._job = None
        self._run.visible, self._stop.visible, self._bar.visible = True, False, False
        if self._parts:
            self._open_timeline(join_frames(self._parts))
        else:
            self._state.content = START
        self._parts = []
        if result is None:
            self._show_end(request, reason)
            return
        self._page.clear_error("grasp")
        self._show_result(request, result)
        if self._frames is not None and self._meshes is not None:
            title = f"{request.title}: {result['reason']}"
            self._on_result(request, Recording(title=title, meshes=self._meshes, frames=self._frames), result)

    def _show_result(self, request: GraspRequest, result: dict[str, Any]) -> None:
        self._result.content = f"{_head(request)} {describe_result(result)}"
        self._result.visible = True
        self._table.content, self._table_folder.visible = format_figures(result), bool(self._frames)

    def _show_end(self, request: GraspRequest, reason: str | None) -> None:
        if reason == STOPPED:
            rest = "" if self._frames is None else " The frames so far are in the timeline."
            self._result.content = f"{_head(request)} **Stopped.**{rest}"
        else:
            self._result.content = f"{_head(request)} **Not run:** {escape_markdown(str(reason))}"
            self._page.tell_failure(reason or "the grasp ended without a result", "grasp")
        self._result.visible = True

    def _open_timeline(self, frames: Frames) -> None:
        """Offer all frames, the last one shown."""
        self._frames, last = frames, len(frames) - 1
        self._timeline.set_scale(_scale_to(float(frames.time[last])))
        self._phases.content = describe_phases(frames)
        self._timeline_folder.visible = True
        self.plots.draw(frames, last)
        self._show_frame(last)
        self._show_buttons()

    def _show_buttons(self) -> None:
        self._play.label = "Pause" if self._player.is_playing else "Play"

    def _scrub(self, time: float) -> None:
        if self._frames is not None:
            self.pause()
            self._show_frame(min(round(time * RATE), len(self._frames) - 1))

    def _play_to(self, index: int) -> None:
        """Show a frame while it plays; timeline, text and plots follow every `SLOW` frames."""
        assert self._frames is not None
        if index % SLOW == 0 or index == len(self._frames) - 1:
            self._show_frame(index)
            return
        self._index = index
        with self._page.client.atomic():
            self._view.show(self._frames, index)

    def _show_frame(self, index: int) -> None:
        assert self._frames is not None
        self._index = index
        time = float(self._frames.time[index])
        with self._page.client.atomic():
            self._view.show(self._frames, index)
            self._timeline.set(time)
            self._state.content = describe_frame(self._frames, index)
            self.plots.mark(time)


def _head(request: GraspRequest) -> str:
    """What a result is of."""
    return f"*{escape_markdown(request.name)}* by *{request.strategy}*:"


def _scale_to(end: float) -> Scale:
    """Timeline up to a time [s], rounded up so that the last frame lies on it."""
    return replace(_TIMELINE, most=max(math.ceil(10.0 * end - 1e-6) / 10.0, 0.1))
