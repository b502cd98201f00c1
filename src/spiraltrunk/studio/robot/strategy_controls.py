"""A strategy on the twin: which one, for which object."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, final

from spiraltrunk import strategies
from spiraltrunk.studio.page.buttons import add_button
from spiraltrunk.studio.page.controls import Choice
from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.robot.texts import format_closed, format_run
from spiraltrunk.workflows.drive.remote.requests import Request, Run
from spiraltrunk.workflows.drive.remote.state import RobotState


@final
class StrategyControls:
    """Choice of strategy and object, a button, and the phase."""

    def __init__(self, page: Page, ask: Callable[[Request], None]) -> None:
        """Add them where the page's container is open; ``ask`` sends a request."""
        self._ask = ask
        names = strategies.NAMES
        self._strategy = Choice(page, "Strategy", names, names[0], self._offer, hint="What the twin does")
        self._object = Choice(
            page, "Object", strategies.get(names[0]).objects, "", lambda _: None, hint="What it does it with"
        )
        self._run = add_button(
            page,
            "Run on the twin",
            self._start,
            hint="Homes and arms a twin with arm and object, and runs the strategy",
        )
        self._text: Any = page.gui.add_html("")

    def draw(self, state: RobotState | None, *, is_open: bool, is_mine: bool) -> None:
        """Show the phase, and open or close the controls; closed ones say why."""
        for handle in (self._strategy.handle, self._object.handle, self._run):
            if handle.disabled == is_open:
                handle.disabled = not is_open
        text = format_run(state)
        if state is not None and not is_open and not state.run:
            text = format_closed(state, is_mine=is_mine) + text
        if self._text.content != text:
            self._text.content = text

    def _offer(self, name: str) -> None:
        self._object.set_options(strategies.get(name).objects)

    def _start(self) -> None:
        self._ask(Run(self._strategy.value, self._object.value))
