"""Presets, and design files to and from the person's computer."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from typing import final

from spiraltrunk.design import TrunkDesign, format_design, presets
from spiraltrunk.design.schema import MOST_BYTES, as_typed
from spiraltrunk.design.toml import parse_design
from spiraltrunk.errors import DesignError, StudioError
from spiraltrunk.studio.page.buttons import add_button, add_upload
from spiraltrunk.studio.page.controls import Choice
from spiraltrunk.studio.page.page import Page

OWN = "own design"
"""Entry of the list of presets for a design that is no preset."""

FILE = "trunk.toml"
"""Name of the file that is offered."""


@final
class DesignFiles:
    """Controls of presets and files."""

    def __init__(self, page: Page, take: Callable[[TrunkDesign], None]) -> None:
        self._page = page
        self._take = take

    def build_presets(self) -> None:
        """Add the list of presets."""
        options = (OWN, *presets.NAMES)
        self._choice = Choice(
            self._page, "Preset", options, find_preset(self._page.design), self._load_preset,
            hint="A known robot to begin with; it replaces the present design",
        )  # fmt: skip

    def build_files(self) -> None:
        """Add the buttons of files."""
        add_button(self._page, f"Save {FILE}", self._save, hint="The design file, for every command of spiraltrunk")
        add_upload(
            self._page, f"Load {FILE}", self._load, most=MOST_BYTES, kinds=".toml",
            hint="A design file from this computer; it replaces the present design",
        )  # fmt: skip

    def show(self, design: TrunkDesign) -> None:
        """Show which preset a design is."""
        found = find_preset(design)
        if self._choice.value != found:
            self._choice.set(found)

    def _load_preset(self, name: str) -> None:
        if name != OWN:
            self._take(presets.get(name))
        elif (found := find_preset(self._page.design)) != OWN:
            self.show(self._page.design)
            raise StudioError(f"the design is the preset {found}; it becomes your own once a parameter is changed")

    def _save(self) -> None:
        self._page.download(FILE, format_design(self._page.design).encode())

    def _load(self, name: str, content: bytes) -> None:
        self._take(read_upload(name, content))
        self._page.notice(f"{name} is the design now", "done")


def read_upload(name: str, content: bytes) -> TrunkDesign:
    """Design in a file that a page sent.

    Raises:
        DesignError: for what is no design; names the key.
        StudioError: for a design that names a file of this computer as its arm, or whose arm lacks its mount site or
            has another number of joints.
    """
    design = parse_design(content, name)
    if design.arm.is_file:
        raise StudioError(
            f"{name}: arm.model is a path; allowed in the studio: the name of a described arm, such as panda"
        )
    _check_arm(design, name)
    return design


def _check_arm(design: TrunkDesign, name: str) -> None:
    from spiraltrunk.sim.robot.arm import check_arm

    try:
        check_arm(design.arm)
    except DesignError as error:
        raise StudioError(f"{name}: {as_typed(error)}") from None


def find_preset(design: TrunkDesign) -> str:
    """Name of the preset that a design is, or `OWN`."""
    return presets.find_name(design) or OWN


def rename(design: TrunkDesign) -> TrunkDesign:
    """The design; one that has the name of a preset and differs from it gets another name."""
    if design.name in presets.NAMES and design != presets.get(design.name):
        return replace(design, name=f"my-{design.name}")
    return design


def name_file(design: TrunkDesign, ending: str) -> str:
    """Name of a file that is offered: letters, digits, dashes and underscores of the design's name."""
    return (re.sub(r"[^A-Za-z0-9_-]+", "-", design.name).strip("-")[:60] or "trunk") + ending
