"""Moves of the cables: steps of each, and the limits of all moves; each value is checked on the server."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import final

from spiraltrunk.design import TrunkDesign
from spiraltrunk.errors import StudioError
from spiraltrunk.studio.page.buttons import add_button
from spiraltrunk.studio.page.controls import Slider
from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.page.scale import Scale, is_number
from spiraltrunk.studio.page.theme import GRAY
from spiraltrunk.workflows.drive.move_defaults import SPEED, TENSION
from spiraltrunk.workflows.drive.remote.requests import SPEED_LEAST, SPEED_MOST, STEP_MOST, Jog, Limit, Move, Request

_WAYS = {"let out": -1.0, "wind in": 1.0}
"""What the two buttons of a cable do."""

_OLDEST = 0.5
"""Age of a click up to which it moves a cable [s] (ours)."""


@final
class MoveControls:
    """Controls of moves; they are open while the robot is armed and this page is in control."""

    def __init__(self, page: Page, design: TrunkDesign, ask: Callable[[Request], None]) -> None:
        """Add them where the page's container is open.

        Args:
            page: the page.
            design: design of the robot.
            ask: sends a request.
        """
        self._page, self._design, self._ask = page, design, ask
        self._is_open = False
        self.step = Slider(
            page, Scale(label="Step", unit="mm", least=0.5, most=min(20.0, 1e3 * STEP_MOST), step=0.5,
                        hint="Length by which one press winds a cable in, or lets it out"), 5.0, lambda _: None,
        )  # fmt: skip
        for cable in range(design.n_cable):
            self._add_row(cable)
        add_button(page, "All cables follow", self._let_follow, hint="None holds its length any more", color=GRAY)
        with page.gui.add_folder("Limits of moves", expand_by_default=False):
            most = design.cable.tension_max
            scale = Scale(
                label="Largest tension", unit="N", least=0.0, most=most, step=0.5,
                hint="Of a cable that holds its length",
            )  # fmt: skip
            self.tension = Slider(page, scale, min(TENSION, most), lambda _: self._change_limits())
            scale = Scale(
                label="Speed", unit="mm/s", least=1e3 * SPEED_LEAST, most=1e3 * SPEED_MOST, step=1.0,
                hint="Largest speed of a cable",
            )  # fmt: skip
            self.speed = Slider(page, scale, 1e3 * SPEED, lambda _: self._change_limits())

    @property
    def sliders(self) -> tuple[Slider, Slider, Slider]:
        """Step [mm], largest tension [N] and speed [mm/s]."""
        return self.step, self.tension, self.speed

    def open(self, is_open: bool) -> None:
        """Whether changed limits are sent at once; else they are when the robot is enabled."""
        self._is_open = is_open

    def send_limits(self) -> None:
        """Tell the robot the limits."""
        self._ask(Limit(tension=self.tension.value, speed=1e-3 * self.speed.value))

    def _change_limits(self) -> None:
        if self._is_open:
            self.send_limits()

    def _add_row(self, cable: int) -> None:
        row = self._page.gui.add_button_group(
            f"Cable {cable + 1}", tuple(_WAYS), hint=f"Winds cable {cable + 1} by one step; it holds its length then"
        )
        row.on_click(lambda _: self._post_jog(cable, row.value, self.step.handle.value))

    def _post_jog(self, cable: int, way: object, step: object) -> None:
        """Queue a jog with what the controls show at the click; what is sent later does not change it."""
        clicked = time.monotonic()
        self._page.post_taken(f"jog {cable}", lambda: self._jog(cable, str(way), str(step), clicked))

    def _jog(self, cable: int, way: str, step: str, clicked: float) -> None:
        """Ask for a jog.

        Raises:
            StudioError: for what the controls do not offer, and for a click that has waited too long: nothing moves
                when nobody expects it any more.
        """
        self._page.clear_refusal()
        if way not in _WAYS:
            raise StudioError(f"a cable was told {way[:80]!r}; allowed: {', '.join(_WAYS)}")
        if not (is_number(step) and self.step.scale.accepts(float(step))):
            raise StudioError(self.step.scale.refuse(step))
        waited = time.monotonic() - clicked
        if waited > _OLDEST:
            told = f"the click waited {waited:.2f} s; allowed: at most {_OLDEST:g} s; press again"
            raise StudioError(f"cable {cable + 1} was not moved: {told}")
        self._ask(Jog(cable, _WAYS[way] * 1e-3 * float(step)))

    def _let_follow(self) -> None:
        self._ask(Move((None,) * self._design.n_cable))
