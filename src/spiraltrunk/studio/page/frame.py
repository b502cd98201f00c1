"""Frame of a page: its theme, its tab bar, and the tabs behind it."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import Any, final

from viser import SceneNodeHandle

from spiraltrunk.studio.page.access import open_access
from spiraltrunk.studio.page.file_drop import open_drop
from spiraltrunk.studio.page.identity import run_script
from spiraltrunk.studio.page.lights import light_scene
from spiraltrunk.studio.page.number_boxes import open_number_boxes
from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.page.tab import Tab
from spiraltrunk.studio.page.theme import BRAND, set_theme

_MARK = """
const shown = {title}, hints = {hints}, titles = Object.keys(hints);
if (!document.getElementById("spiraltrunk-style")) {{
  const style = document.createElement("style");
  style.id = "spiraltrunk-style";
  style.textContent = "button[data-shown=true] {{ background: {color} !important; color: white !important; }}";
  document.head.append(style);
}}
const mark = (tries) => {{
  const buttons = [...document.querySelectorAll("button")].filter((one) => titles.includes(one.textContent));
  for (const one of buttons) {{
    one.dataset.shown = one.textContent === shown;
    one.setAttribute("aria-pressed", one.textContent === shown);
    one.title = hints[one.textContent];
  }}
  let part = buttons[0];
  while (part && part.previousElementSibling?.textContent !== "") part = part.parentElement;
  if (part) part.previousElementSibling.style.display = "none";
  if (buttons.length < titles.length && tries > 0) setTimeout(() => mark(tries - 1), 100);
}};
mark(30);
"""
"""Viser's row of buttons does not show which was pressed last, leaves room for a label, and has one hint for all, which
hides the page's title: the page mends that."""

HINTS = {
    "Design": "Parameters of a trunk, what it can grasp, its parts to print",
    "Shape": "Pull the cables: shape, joint angles and tensions by both models",
    "Grasp": "Simulate how trunk and arm take an object",
    "Measure": "Compare motion capture with the models, and calibrate",
    "Robot": "Drive the twin or the robot: home, enable, jog, stop",
}
"""What each tab is for, by its title."""

_LATER = 0.7
"""Time after which the tabs that are not shown are built [s]: before, they would delay the one that is."""


@final
class Frame:
    """Tabs of a page, of which one is shown."""

    def __init__(
        self, page: Page, kinds: Sequence[Callable[[Page], Tab]], save: Callable[[dict[str, Any]], None]
    ) -> None:
        """Lay out the page, in its thread; each tab is built when it is shown first, or soon after.

        Args:
            page: the page.
            kinds: constructors of the tabs, in the order of the bar.
            save: keeps the page's settings.
        """
        self._page = page
        self._save = save
        self._tabs: dict[str, Tab] = {}
        self._unbuilt: dict[str, Tab] = {}
        self._folders: dict[str, Any] = {}
        self._roots: dict[str, SceneNodeHandle] = {}
        self._shown = ""
        self._lay_out()
        tabs = [kind(page) for kind in kinds]
        bar = page.gui.add_button_group("", tuple(tab.title for tab in tabs))
        bar.on_click(lambda _: page.later("tab", lambda: self.show(str(bar.value))))
        for tab in tabs:
            self._add(tab)
        self._add_commands(tabs)
        self._dark: Any = page.gui.add_checkbox("Dark", initial_value=False, hint="Light figures on a dark ground")
        self._dark.on_update(lambda _: page.later("dark", self._set_theme))
        self._set_theme()
        page.on_close(self.close)

    def show(self, title: str) -> None:
        """Show the tab of a title; unknown titles are left out."""
        if title not in self._tabs or title == self._shown:
            return
        self._build(title)
        if self._shown:
            self._tabs[self._shown].hide()
        self._shown = title
        with self._page.client.atomic():
            for name, folder in self._folders.items():
                folder.visible = name == title
                self._roots[name].visible = name == title
        self._mark()
        self._tabs[title].show()
        self.save()

    def restore(self, settings: dict[str, Any], first: str = "") -> None:
        """Take settings of an earlier page, and show its tab; a new page shows the tab ``first``.

        A tab takes its settings before the next one is built. Otherwise the design that the first one takes would
        replace what the others have just added, and viser's client reports updates of what the same message removes.
        """
        for title, tab in self._tabs.items() if settings else ():
            self._build(title)
            kept = settings.get(tab.name)
            if isinstance(kept, dict):
                self._page.try_act(lambda tab=tab, kept=kept: tab.apply_settings(kept))  # type: ignore[misc]
        if settings.get("dark") is True:
            self._dark.value = True
            self._set_theme()
        shown = settings.get("shown")
        titles = [title for title in (shown, first, *self._tabs) if title in self._tabs]
        self.show(titles[0])
        for title in tuple(self._unbuilt):
            self._page.later(f"build {title}", lambda title=title: self._build(title), _LATER)  # type: ignore[misc]

    def save(self) -> None:
        """Keep the settings of all tabs."""
        built = [tab for title, tab in self._tabs.items() if title not in self._unbuilt]
        settings = {tab.name: tab.read_settings() for tab in built}
        self._save({**settings, "shown": self._shown, "dark": bool(self._dark.value)})

    def close(self) -> None:
        """Keep the settings, and close all tabs."""
        self._page.try_act(self.save)
        for title, tab in self._tabs.items():
            if title not in self._unbuilt:
                self._page.try_act(tab.close)

    def _set_theme(self) -> None:
        set_theme(self._page.client, is_dark=bool(self._dark.value))
        self._page.set_dark(bool(self._dark.value))

    def _add_commands(self, tabs: Sequence[Tab]) -> None:
        """Tabs by keyboard: Alt with a digit, or the list of commands that Ctrl-K opens."""
        for i, tab in enumerate(tabs):
            digit: Any = str(i + 1)
            command = self._page.gui.add_command(f"Show {tab.title}", hotkey=digit, modifier="alt")
            command.on_trigger(self._build_switch(tab.title))

    def _build_switch(self, title: str) -> Callable[[object], None]:
        return lambda _: self._page.later("tab", lambda: self.show(title))

    def _lay_out(self) -> None:
        self._page.gui.set_panel_label("spiraltrunk studio")
        self._page.gui.main_panel.dock_right()
        self._page.gui.main_panel.set_width(400)
        self._page.scene.set_up_direction("+z")
        light_scene(self._page.scene)
        open_access(self._page.client)
        open_drop(self._page.client)
        open_number_boxes(self._page.client)

    def _add(self, tab: Tab) -> None:
        root = self._page.scene.add_frame(f"/{tab.name}", show_axes=False, visible=False)
        folder = self._page.gui.add_folder(tab.title, visible=False)
        self._tabs[tab.title], self._folders[tab.title], self._roots[tab.title] = tab, folder, root
        self._unbuilt[tab.title] = tab

    def _build(self, title: str) -> None:
        tab = self._unbuilt.pop(title, None)
        if tab is not None:
            with self._folders[title]:
                tab.build()

    def _mark(self) -> None:
        color = "rgb({}, {}, {})".format(*BRAND)
        hints = {title: f"{HINTS.get(title, title)} (Alt+{i})" for i, title in enumerate(self._tabs, 1)}
        script = _MARK.format(title=json.dumps(self._shown), hints=json.dumps(hints), color=color)
        run_script(self._page.client, script)
