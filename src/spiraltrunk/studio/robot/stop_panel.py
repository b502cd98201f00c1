"""The STOP button: over the scene, where neither a tab nor a gesture of the page hides it."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any, final

from spiraltrunk.studio.page.identity import run_script
from spiraltrunk.studio.page.page import Page

_HINT = "Stop the robot at once; every page may"

_SCRIPT = """
window.spiraltrunkStop ??= (() => {
  const stop = { id: "", isShown: false }, button = document.createElement("button");
  button.id = "spiraltrunk-stop";
  button.type = "button";
  const press = () => {
    const theirs = document.getElementById(stop.id);
    if (theirs) return theirs.click();
    const key = new KeyboardEvent("keydown", { key: "Escape", code: "Escape", bubbles: true });
    key.isOurs = true;
    document.documentElement.dispatchEvent(key);
  };
  button.addEventListener("click", press);
  window.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && !event.isOurs && stop.isShown) press();
  }, true);
  stop.refresh = () => {
    if (!button.isConnected) document.body.prepend(button);
    const theirs = document.getElementById(stop.id);
    const isLost = theirs && getComputedStyle(theirs).pointerEvents === "none";
    const text = isLost ? "STOP: no connection" : "STOP (Esc)";
    if (button.textContent !== text) button.textContent = text;
    button.dataset.lost = Boolean(isLost);
    button.hidden = !stop.isShown;
    const right = Math.max(0, ...[...document.querySelectorAll("canvas")].map((one) => one.getBoundingClientRect())
      .filter((box) => box.width > innerWidth / 4).map((box) => innerWidth - box.right));
    button.style.right = `${Math.max(0, Math.min(right + 15, innerWidth - 245))}px`;
  };
  const style = document.createElement("style");
  style.id = "spiraltrunk-stop-style";
  document.head.append(style);
  stop.enter = (id, hint) => {
    stop.id = id;
    stop.isShown = false;
    button.title = hint;
    style.textContent = `[data-floating-window]:has([id="${id}"]), [id="${id}"] { display: none !important; }
      #spiraltrunk-stop { position: fixed; bottom: 15px; z-index: 2147483647; width: 230px; height: 74px;
        pointer-events: auto; cursor: pointer; background: #C80000; color: white; border: 3px solid #7A0000;
        border-radius: 4px; font: 800 1.1rem sans-serif; letter-spacing: .06em; }
      #spiraltrunk-stop[data-lost=true] { background: #5b6168; border-color: #3a3f45; }
      #spiraltrunk-stop:focus-visible { outline: 4px solid #56B4E9; outline-offset: 2px; }`;
    stop.refresh();
  };
  setInterval(stop.refresh, 200);
  return stop;
})();
"""
"""A window of viser can be minimised, docked, covered by another or dragged away. So the button that a person sees is
an element of ours above all of them, and presses viser's, whose window is not drawn. Where the narrow layout has not
built that one, Escape triggers viser's command. Viser's own keys are not heard from within a text box. Viser's button
takes no pointer while the page has no connection: then ours says so.
"""

_ENTER = "window.spiraltrunkStop.enter({id}, {hint});"

_SHOW = "window.spiraltrunkStop.isShown = {is_shown}; window.spiraltrunkStop.refresh();"


@final
class StopPanel:
    """A large red STOP, by mouse, by the key Escape from anywhere in the page, and by the list of commands (Ctrl-K).

    It is never disabled. Its act runs at once, beside whatever the page's own thread does.
    """

    def __init__(self, page: Page, stop: Callable[[], None]) -> None:
        self._page, self._stop = page, stop
        self._panel: Any = page.gui.add_panel(visible=False)
        with self._panel.add_tab("Robot"):
            self._button = page.gui.add_button("STOP  (Esc)", color=(200, 0, 0), hint=_HINT)
        self._panel.float(x=-15, y=-15, width=230)
        self._button.on_click(lambda _: page.try_act(stop))
        command = page.gui.add_command(
            "STOP the robot", description="torque ramps to zero within 40 ms", hotkey="escape"
        )
        command.on_trigger(lambda _: page.try_act(stop))
        enter = _ENTER.format(id=json.dumps(self._button._impl.uuid), hint=json.dumps(_HINT))
        run_script(page.client, _SCRIPT + enter)

    def show(self, visible: bool) -> None:
        """Show or hide it."""
        if self._panel.visible != visible:
            self._panel.visible = visible
            run_script(self._page.client, _SHOW.format(is_shown=json.dumps(visible)))
