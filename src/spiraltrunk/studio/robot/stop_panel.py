"""The STOP button: in a panel of its own over the scene, so that no scrolling and no other tab hides it."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any, final

from spiraltrunk.studio.page.identity import run_script
from spiraltrunk.studio.page.page import Page

_STYLE = """
const id = {id};
const style = document.createElement("style");
style.textContent = `[id="${{id}}"] {{ height: 4.2em !important; background: #C80000 !important;
  color: white !important; font-size: 1.25em; font-weight: 800; letter-spacing: .06em;
  border: 3px solid #7A0000 !important; }}
  [id="${{id}}"] * {{ font-weight: inherit !important; }}
  [id="${{id}}"]:focus-visible {{ outline: 4px solid #56B4E9; outline-offset: 2px; }}`;
document.head.append(style);
window.addEventListener("keydown", (event) => {{
  const button = document.getElementById(id);
  if (event.key === "Escape" && button) button.click();
}}, true);
"""
"""Viser's buttons have one height, and its own keys are not heard from within a text box."""


@final
class StopPanel:
    """A large red STOP, by mouse, by the key Escape from anywhere in the page, and by the list of commands (Ctrl-K).

    It is never disabled. Its act runs at once, beside whatever the page's own thread does.
    """

    def __init__(self, page: Page, stop: Callable[[], None]) -> None:
        self._page, self._stop = page, stop
        self._panel: Any = page.gui.add_panel(visible=False)
        with self._panel.add_tab("Robot"):
            self._button = page.gui.add_button(
                "STOP  (Esc)", color=(200, 0, 0), hint="Stop the robot at once; every page may"
            )
        self._panel.float(x=-15, y=-15, width=230)
        self._button.on_click(lambda _: page.try_act(stop))
        command = page.gui.add_command(
            "STOP the robot", description="torque ramps to zero within 40 ms", hotkey="escape"
        )
        command.on_trigger(lambda _: page.try_act(stop))
        run_script(page.client, _STYLE.format(id=json.dumps(self._button._impl.uuid)))

    def show(self, visible: bool) -> None:
        """Show or hide it."""
        if self._panel.visible != visible:
            self._panel.visible = visible
