"""A line of text beside the trunk, which tells what its picture is."""

from __future__ import annotations

from typing import Any

from spiraltrunk.design import TrunkDesign
from spiraltrunk.studio.page.page import Page


def add_note(page: Page, name: str, design: TrunkDesign, text: str) -> Any:
    """Add the text below the tip of the straight trunk, and return its node."""
    place = (0.0, -1.06 * design.length, 0.0)
    return page.scene.add_label(name, text, position=place, anchor="center-center")
