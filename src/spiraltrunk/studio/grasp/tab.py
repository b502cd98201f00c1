"""The tab *Grasp*."""

from __future__ import annotations

import secrets
from dataclasses import replace
from typing import Any, final

import numpy as np

from spiraltrunk import strategies
from spiraltrunk.design import TrunkDesign
from spiraltrunk.errors import SpiralTrunkError, StudioError
from spiraltrunk.studio.drawing.camera import TabCamera
from spiraltrunk.studio.grasp.jobs import Scene, prepare
from spiraltrunk.studio.grasp.kept import KeptGrasp, find_grasp, keep_grasp
from spiraltrunk.studio.grasp.object_picker import ObjectPicker
from spiraltrunk.studio.grasp.request import GraspRequest
from spiraltrunk.studio.grasp.run_panel import RunPanel
from spiraltrunk.studio.grasp.save_panel import SavePanel
from spiraltrunk.studio.grasp.stage_view import CAMERA, FIELD, LOOK_AT, StageView
from spiraltrunk.studio.grasp.texts import NO_OBJECT, RANKING, describe_choice, format_ranking
from spiraltrunk.studio.page.buttons import add_button
from spiraltrunk.studio.page.controls import Choice, Slider
from spiraltrunk.studio.page.job import STOPPED, Job
from spiraltrunk.studio.page.markdown import escape_markdown
from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.page.scale import Scale
from spiraltrunk.studio.page.theme import GRAY
from spiraltrunk.workflows.grasp.choice.auto import AUTO
from spiraltrunk.workflows.grasp.choice.candidates import STAGES, Candidate
from spiraltrunk.workflows.grasp.recording import Recording

FIRST = "wrap-vertical"
"""Strategy that a page opens on, as the command does."""

REST = 0.3
"""Time without a further change after which the models are asked [s]."""

_SEED = Scale(label="Seed", unit="", least=0, most=999, step=1, hint="Draws the object's true place, size and mass")
_FRICTION = Scale(
    label="Cable friction", unit="", least=0.0, most=1.0, step=0.01, hint="Coefficient between cables and their holes"
)


def list_strategies(stage: str) -> tuple[str, ...]:
    """Names of the strategies for a stage: the choice, those that lift, those that push."""
    return AUTO, *(name for name in strategies.NAMES if strategies.get(name).support == stage)


@final
class GraspTab:
    """Pickers, run, timeline, plots and files of a grasp by the hybrid robot."""

    name = "grasp"
    title = "Grasp"

    def __init__(self, page: Page) -> None:
        self._page = page
        self._view = StageView(page.scene, f"/{self.name}/stage")
        self._is_shown = False
        self._is_stale = True
        self._preparing: Job | None = None
        self._candidates: tuple[Candidate, ...] = ()
        self._camera = TabCamera(page, np.array(CAMERA), np.array(LOOK_AT), field=FIELD)
        self._asked: tuple[Any, ...] = ()
        self._done: KeptGrasp | None = None
        self._last: KeptGrasp | None = None
        self._is_restored = False

    @property
    def panel(self) -> RunPanel:
        """Run, timeline and plots."""
        return self._run

    def build(self) -> None:
        """Add all controls."""
        page = self._page
        self._object = ObjectPicker(page, self._change)
        stage = strategies.get(FIRST).support
        hint = "What carries the object before the grasp: the ground, or two strings"
        self._stage = Choice(page, "Stage", STAGES, stage, self._change_stage, hint=hint)
        hint = "How the trunk takes the object; auto asks the models and tries the best"
        self._strategy = Choice(page, "Strategy", list_strategies(stage), FIRST, self._change_strategy, hint=hint)
        self._told: Any = page.gui.add_markdown(RANKING)
        with page.gui.add_folder("Which strategy can take it", expand_by_default=False):
            self._ranking: Any = page.gui.add_markdown(RANKING)
        with page.gui.add_folder("Options", expand_by_default=False):
            self._friction = Slider(page, _FRICTION, page.design.cable.friction, lambda _: self._change())
            self._seed = Slider(page, _SEED, 0.0, lambda _: self._change())
        self._run = RunPanel(page, self._view, read=self._read, on_start=self._put_aside, on_result=self._offer)
        hint = "What was picked since stays as it is"
        self._back: Any = add_button(page, "Last grasp", self._show_last, hint=hint, visible=False, color=GRAY)
        self._save = SavePanel(page)
        page.on_design(self._take_design)
        page.on_dark(self._view.set_dark)

    def show(self) -> None:
        """Ask the models where something has changed, and restore the view."""
        self._is_shown = True
        self._camera.show()
        if self._is_stale:
            self._prepare()

    def hide(self) -> None:
        """Stop playing, and remember the camera."""
        self._is_shown = False
        self._run.pause()
        self._camera.keep()

    def read_settings(self) -> dict[str, Any]:
        """What is picked, the grasp that is shown, and on a page that is closed the one that was running."""
        return {
            **self._object.read_settings(), "stage": self._stage.value, "strategy": self._strategy.value,
            "friction": self._friction.value, "seed": self._seed.value,
            "grasp": "" if (kept := self._find_kept()) is None else kept.name,
            "running": self._run.running if self._page.is_closed else "",
        }  # fmt: skip

    def apply_settings(self, settings: dict[str, Any]) -> None:
        """Pick what an earlier page had picked."""
        self._object.apply_settings(settings)
        self._stage.set(str(settings.get("stage")))
        self._strategy.set_options(list_strategies(self._stage.value))
        self._strategy.set(str(settings.get("strategy")))
        for name, slider in (("friction", self._friction), ("seed", self._seed)):
            if isinstance(settings.get(name), int | float):
                slider.set(settings[name])
        self._is_stale = True
        self._done = find_grasp(str(settings.get("grasp", "")))
        if self._done is not None:
            self._is_restored = True
            self._run.open(self._done)
            self._save.offer(self._done)
        running = settings.get("running")
        if isinstance(running, str) and running:
            self._run.tell_reload(running)

    def close(self) -> None:
        """Stop what runs; a grasp that has ended is kept for a reload."""
        kept = self._find_kept()
        self._run.pause()
        self._run.stop()
        if kept is not None:
            keep_grasp(kept)

    def _find_kept(self) -> KeptGrasp | None:
        """The grasp that a reload comes back to: the one in view, else while it runs again the one before."""
        if self._done is None and self._last is not None and self._run.is_running:
            return self._last if self._last.request == self._run.request else None
        return self._done

    def _read(self) -> GraspRequest:
        """What the person asks for.

        Raises:
            SpiralTrunkError: where the object is missing, or cannot be built.
        """
        name, shape = self._object.read()
        design = self._page.design
        design = replace(design, cable=replace(design.cable, friction=self._friction.value))
        return GraspRequest(
            design=design, shape=shape, name=name, option=self._object.option, strategy=self._strategy.value,
            stage=self._stage.value, seed=round(self._seed.value),
        )  # fmt: skip

    def _change_stage(self, stage: str) -> None:
        self._strategy.set_options(list_strategies(stage))
        self._change()

    def _change_strategy(self, _: str) -> None:
        self._show_choice()
        self._change()

    def _take_design(self, design: TrunkDesign) -> None:
        self._friction.set(design.cable.friction)
        self._change()

    def _change(self) -> None:
        """Something was picked: what is shown no longer fits it."""
        self._is_stale, self._is_restored = True, False
        self._run.hide_note()
        if self._is_shown:
            self._page.later("grasp prepare", self._prepare, REST)

    def _prepare(self) -> None:
        """Show the scene and ask the models, in a process; one at a time, the last request counts."""
        if self._preparing is not None:
            self._preparing.stop()
            return
        self._is_stale = False
        try:
            request = self._read()
        except SpiralTrunkError as error:
            self._candidates, self._asked = (), ()
            self._told.content, self._ranking.content = escape_markdown(str(error)), NO_OBJECT
            return
        asked = request.design, request.name, request.shape.mass, request.stage
        if asked != self._asked:  # Another strategy or seed changes no ranking.
            self._candidates, self._asked = (), asked
            self._told.content = self._ranking.content = RANKING
        n_shown = self._run.n_shown
        self._preparing = self._page.start(
            prepare, request, on_report=lambda scene: self._take_scene(scene, request, n_shown),
            on_end=self._take_ranking,
        )  # fmt: skip

    def _take_scene(self, scene: Scene, request: GraspRequest, n_shown: int) -> None:
        """Show a scene, unless its grasp is in view, or there have been more grasps since than ``n_shown``."""
        if self._is_restored:  # The grasp of before the reload stays in view.
            self._is_restored = False
        elif self._done is not None and self._done.request == request:
            pass
        elif self._run.n_shown == n_shown and not (self._run.is_running or self._is_stale):
            self._put_aside()
            self._run.show_scene(scene)

    def _put_aside(self) -> None:
        """Take the grasp out of view, and offer to show it again."""
        if self._done is not None:
            self._set_last(self._done)
        self._done = None
        self._save.clear()

    def _set_last(self, last: KeptGrasp | None) -> None:
        """Offer to show a grasp again that another choice took out of view; None offers nothing."""
        self._last = last
        if last is not None:
            self._back.label = f"Show again: {last.request.title}"
        self._back.visible = last is not None

    def _show_last(self) -> None:
        """Show the grasp that another choice took out of view."""
        if self._run.is_running:
            raise StudioError("a grasp is being computed; wait for its end, or stop it")
        if self._last is not None:
            self._done, last = self._last, self._last
            self._set_last(None)
            self._run.open(last)
            self._save.offer(last)

    def _take_ranking(self, candidates: tuple[Candidate, ...] | None, reason: str | None) -> None:
        self._preparing = None
        if self._is_stale:
            if self._is_shown:
                self._prepare()
        elif candidates is not None:
            self._candidates = candidates
            self._ranking.content = format_ranking(candidates)
            self._show_choice()
        elif reason != STOPPED:
            self._candidates = ()
            self._told.content = f"The models cannot tell: {escape_markdown(str(reason))}"

    def _show_choice(self) -> None:
        if self._candidates:
            self._told.content = describe_choice(self._strategy.value, self._candidates)

    def _offer(self, request: GraspRequest, recording: Recording, result: dict[str, Any]) -> None:
        self._done = KeptGrasp(name=secrets.token_hex(8), request=request, recording=recording, result=result)
        self._set_last(None)
        self._save.offer(self._done)
