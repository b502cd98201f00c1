"""Tab *Shape*."""

from __future__ import annotations

import math
from typing import Any, final

import numpy as np

from spiraltrunk.design import TrunkDesign
from spiraltrunk.studio.drawing.camera import aim_at_trunk
from spiraltrunk.studio.page.controls import Slider, Switch
from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.page.scale import Scale
from spiraltrunk.studio.shape import texts
from spiraltrunk.studio.shape.cable_controls import CableControls
from spiraltrunk.studio.shape.compile_models import compile_models
from spiraltrunk.studio.shape.picture import ShapePicture
from spiraltrunk.studio.shape.plots import ShapePlots
from spiraltrunk.studio.shape.state import TrunkState

_compiled: set[bool] = set()
"""Whether the models are on disc, without and with friction: each process asks once."""

_PULLS = {
    "Rest": (-1.0, -1.0, -1.0), "Dorsal": (0.7, -1.0, -1.0), "Ventral": (-1.0, 0.35, 0.35), "Twist": (0.6, -0.1, -1.0)
}  # fmt: skip
"""Pulls at one click, over the stroke: of cable 1, cable 2 and the others [-]."""

_FIRST = "Dorsal"
"""Pull that a new page shows."""


@final
class ShapeTab:
    """Cables, gravity and tip of the trunk."""

    name = "shape"
    title = "Shape"

    def __init__(self, page: Page) -> None:
        self._page = page
        self._is_shown = self._is_compiling = False
        self._target: tuple[float, bool] | None = None
        self._settings: dict[str, Any] | None = None

    def build(self) -> None:
        """Add all controls; the scene is drawn when the tab is shown."""
        gui, state = self._page.gui, _start_state(self._page.design)
        self._state = state
        self._words = gui.add_html("")
        pulls = gui.add_button_group("Pull", tuple(_PULLS), hint="Pulls of the paper at one click")
        pulls.on_click(lambda _: self._page.later("shape pull", lambda: self._take_preset(str(pulls.value))))
        groups = gui.add_tab_group()
        self._folders = (groups.add_tab("Cables"), groups.add_tab("Mean and differences"))
        with groups.add_tab("Base and ghost"):
            theta = Scale(
                label="Base axis", unit="deg", least=-90, most=90, step=1,
                hint="Angle of the base axis below the horizontal, theta_0: 90 hangs, 0 lies, -90 stands",
            )  # fmt: skip
            roll = Scale(
                label="Roll", unit="deg", least=-180, most=180, step=1, hint="Rotation of the trunk about its base axis"
            )
            self._theta = Slider(self._page, theta, math.degrees(state.theta_0), lambda _: self._turn())
            self._roll = Slider(self._page, roll, math.degrees(state.roll), lambda _: self._turn())
            hint = "The paper's reference model as a ghost, for the pulls that it has a shape for"
            self._ghost = Switch(self._page, "Paper's model", True, lambda _: self._redraw(), hint=hint)
        self._below = gui.add_folder(None)
        self._build_design()
        self._page.on_design(self._change_design)

    def show(self) -> None:
        """Draw, and compile the models where they are not yet."""
        self._is_shown = True
        self._camera.show()
        self._update()

    def hide(self) -> None:
        """Remember the view."""
        self._is_shown = False
        self._camera.keep()

    def read_settings(self) -> dict[str, Any]:
        """Pulls [mm] and base [deg]."""
        state = self._state
        return {
            "pull_mm": [round(1e3 * value, 3) for value in state.pull.tolist()],
            "theta0_deg": self._theta.value, "roll_deg": self._roll.value,
            "has_ghost": self._ghost.value,
        }  # fmt: skip

    def apply_settings(self, settings: dict[str, Any]) -> None:
        """Take pulls and base where they fit the design."""
        state = self._state
        given = np.array(settings.get("pull_mm", ()), float) / 1e3
        if given.shape == state.pull.shape and np.isfinite(given).all():
            state.pull = np.clip(given, -state.design.cable_stroke, state.design.cable_stroke)
        self._theta.set(float(settings.get("theta0_deg", 90.0)))
        self._roll.set(float(settings.get("roll_deg", 0.0)))
        self._ghost.set(settings.get("has_ghost") is not False)
        state.turn(math.radians(self._theta.value), math.radians(self._roll.value))
        state.restart()
        self._controls.show(state.pull)

    def close(self) -> None:
        """Nothing runs but what the page itself stops."""

    def _build_design(self) -> None:
        """Controls, plots and scene of the present design."""
        state = self._state
        self._controls = CableControls(self._page, self._folders, state.design, state.pull, self._pull)
        with self._below:
            self._legend = self._page.gui.add_html(texts.format_legend(state.design))
            self._plots = ShapePlots(self._page, state.design)
        self._picture = ShapePicture(self._page, state.design, self._drag)
        self._camera = aim_at_trunk(self._page, state.design)

    def _change_design(self, design: TrunkDesign) -> None:
        for part in (self._controls, self._legend, self._plots, self._picture):
            part.remove()
        base = (self._state.theta_0, self._state.roll)
        self._state = _start_state(design)
        self._state.turn(*base)
        self._build_design()
        if self._is_shown:
            self._camera.show()
            self._update()

    def _take_preset(self, name: str) -> None:
        if name not in _PULLS:
            return
        state = self._state
        state.pull = _read_preset(state.design, name)
        state.restart()
        self._controls.show(state.pull)
        self._target = None
        self._update()

    def _pull(self, pull: np.ndarray) -> None:
        self._state.pull, self._target = pull, None
        self._update()

    def _turn(self) -> None:
        self._state.turn(math.radians(self._theta.value), math.radians(self._roll.value))
        self._target = None
        self._update()

    def _drag(self, target: np.ndarray, is_let_go: bool) -> None:
        """Let the tip follow its handle."""
        if not self._is_ready():
            return
        state = self._state
        distance = state.reach(target, is_final=is_let_go)
        self._target = (distance, is_let_go)
        self._controls.show(state.pull)
        self._draw()
        self._picture.mark_missed(state.tip, target, is_missed=distance > texts.OUT_OF_REACH)

    def _update(self) -> None:
        """Solve and draw, or draw the straight trunk until the models are there."""
        if not self._is_shown:
            return
        state = self._state
        if not self._is_ready():
            joints = state.design.n_joint
            self._picture.draw(np.tile(np.eye(3), (joints, 1, 1)), np.zeros(joints, bool), state.theta_0, state.roll)
            self._picture.place_handle(state.tip)
            self._compile()
            return
        state.solve()
        self._draw()
        self._picture.place_handle(state.tip)

    def _draw(self) -> None:
        from spiraltrunk.model.statics.pull_sequences import find_shut

        state = self._state
        state.compare()
        assert state.shape is not None
        assert state.paper is not None
        ghost = state.paper.shape if self._ghost.value else None
        with self._page.client.atomic():
            shut = find_shut(state.design, state.shape)
            self._picture.draw(state.shape.joint_rotation, shut, state.theta_0, state.roll)
            self._picture.draw_ghost(None if ghost is None else ghost.joint_rotation, state.theta_0)
            self._plots.draw(state.shape, ghost)
            self._words.content = texts.format_state(state, self._target)

    def _redraw(self) -> None:
        if self._is_shown and self._state.shape is not None:
            self._draw()

    def _is_ready(self) -> bool:
        return (self._state.design.cable.friction > 0) in _compiled

    def _compile(self) -> None:
        """Compile the models beside the page."""
        if self._is_compiling:
            return
        self._is_compiling = True
        has_friction = self._state.design.cable.friction > 0

        def tell(what: str) -> None:
            self._words.content = texts.format_compiling(what)

        def end(_: Any, reason: str | None) -> None:
            self._is_compiling = False
            if reason is not None:
                self._words.content = texts.format_failed(reason)
                return
            _compiled.add(has_friction)
            self._update()

        tell("starting")
        self._page.start(compile_models, self._state.design, on_report=tell, on_end=end)


def _start_state(design: TrunkDesign) -> TrunkState:
    state = TrunkState(design)
    state.pull = _read_preset(design, _FIRST)
    return state


def _read_preset(design: TrunkDesign, name: str) -> np.ndarray:
    """Pulls of a preset for a design of any number of cables, shape (n_cable,) [m]."""
    parts = _PULLS[name]
    return design.cable_stroke * np.array([parts[min(cable, 2)] for cable in range(design.n_cable)])
