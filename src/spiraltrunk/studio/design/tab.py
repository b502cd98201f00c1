"""Tab "Design"."""

from __future__ import annotations

import threading
from typing import Any, cast, final

from spiraltrunk.design import TrunkDesign, format_design
from spiraltrunk.design.toml import parse_design
from spiraltrunk.errors import DesignError
from spiraltrunk.studio.design.fields import as_labelled, describe_lost
from spiraltrunk.studio.design.figures import find_gap, format_figures, format_legend, format_warnings
from spiraltrunk.studio.design.files import DesignFiles, rename
from spiraltrunk.studio.design.make_options import PAGE_OPTIONS
from spiraltrunk.studio.design.parameters import Parameters, Vary
from spiraltrunk.studio.design.parts import PartExport
from spiraltrunk.studio.design.picture import VIEWS, DesignPicture, View
from spiraltrunk.studio.page.controls import Choice, Switch
from spiraltrunk.studio.page.page import Page

_REST = 0.7
"""Time without a change after which the design is checked [s]."""

_AFTER = 0.1
"""Time after which figures and boxes follow the picture [s]: laid out together, they would delay it by as much."""


@final
class DesignTab:
    """The design: parameters, picture, figures, warnings, file and parts."""

    name = "design"
    title = "Design"

    def __init__(self, page: Page) -> None:
        self._page = page
        self._picture = DesignPicture(page)
        self._parameters = Parameters(page, self._change)
        self._files = DesignFiles(page, page.set_design)
        self._parts = PartExport(page)
        self._is_shown = False
        self._checked: tuple[TrunkDesign, tuple[str, ...]] | None = None
        self._is_checking = False
        self._is_due = False

    def build(self) -> None:
        """Add all controls."""
        page, design = self._page, self._page.design
        self._files.build_presets()
        self._view = Choice(
            page, "View", VIEWS, VIEWS[0], lambda _: self._draw(), hint="All joints at their limit, or straight"
        )
        self._construction = Switch(
            page, "Construction", True, lambda _: self._draw(),
            hint="The spiral's contours, its rays and the outlines of the sections",
        )  # fmt: skip
        self._legend: Any = page.gui.add_html(format_legend(self._construction.value))
        self._figures: Any = page.gui.add_html(format_figures(design))
        self._warnings: Any = page.gui.add_html(format_warnings([], True))
        self._parameters.build_rules(design)
        self._files.build_files()
        self._parameters.build_parts(design)
        self._parts.build()
        page.on_design(self._take_design)

    def show(self) -> None:
        """Draw what changed while hidden."""
        self._is_shown = True
        self._draw()
        self._picture.fit()
        self._page.later("design check", self._check, _REST)

    def hide(self) -> None:
        """Draw no more."""
        self._is_shown = False

    def read_settings(self) -> dict[str, Any]:
        """The design as the text of a file, and the view."""
        return {
            "design": format_design(self._page.design), "view": self._view.value,
            "construction": self._construction.value,
        }  # fmt: skip

    def apply_settings(self, settings: dict[str, Any]) -> None:
        """Take design and view."""
        self._view.set(str(settings.get("view")))
        self._construction.set(settings.get("construction") is not False)
        text = settings.get("design")
        if isinstance(text, str):
            self._page.set_design(parse_design(text.encode(), "the design of before"))

    def close(self) -> None:
        """Stop the export."""
        self._parts.close()

    def _change(self, vary: Vary) -> None:
        """Change the design; a refusal is shown in labels and units of the controls."""
        before = self._page.design
        try:
            design = rename(vary(before))
        except DesignError as error:
            raise as_labelled(error) from None
        if design != before:
            self._page.set_design(design)
            if lost := describe_lost(before, design):
                self._page.notice(lost, "warning")
        else:
            self._parameters.show(design)

    def _take_design(self, design: TrunkDesign) -> None:
        if self._is_shown:
            self._draw()
            self._page.client.flush()
            self._page.later("design camera", self._settle, _REST)
        if not self._is_due:
            self._is_due = True
            self._page.later("design figures", self._show_figures, _AFTER)
        self._page.later("design check", self._check, _REST)

    def _show_figures(self) -> None:
        """Show what is written about the design that the page has by now."""
        self._is_due = False
        design = self._page.design
        with self._page.client.atomic():
            self._figures.content = format_figures(design)
            self._files.show(design)
            self._parameters.show(design)
        self._show_warnings()

    def _draw(self) -> None:
        self._picture.draw(self._page.design, cast(View, self._view.value), self._construction.value)
        legend = format_legend(self._construction.value)
        if self._legend.content != legend:
            self._legend.content = legend

    def _settle(self) -> None:
        if self._is_shown:
            self._picture.settle()

    def _check(self) -> None:
        """Look for faults in a thread of its own, one check at a time."""
        design = self._page.design
        if self._is_checking or not self._is_shown or (self._checked is not None and self._checked[0] == design):
            return
        self._is_checking = True

        def work() -> None:
            from spiraltrunk.workflows.export.faults import find_faults

            try:
                faults = find_faults(design, PAGE_OPTIONS)
            except Exception as error:  # A check that itself fails is told as one.
                faults = (f"the check of the parts failed: {error}",)
            self._page.post(lambda: self._take_faults(design, faults))

        threading.Thread(target=work, name="studio design check", daemon=True).start()

    def _take_faults(self, design: TrunkDesign, faults: tuple[str, ...]) -> None:
        self._is_checking = False
        self._checked = design, faults
        self._show_warnings()
        if design != self._page.design:
            self._page.later("design check", self._check, _REST)

    def _show_warnings(self) -> None:
        design = self._page.design
        is_checked = self._checked is not None and self._checked[0] == design
        faults = self._checked[1] if is_checked and self._checked is not None else ()
        gap = find_gap(design)
        content = format_warnings([*([gap] if gap else []), *faults], not is_checked)
        if self._warnings.content != content:
            self._warnings.content = content
