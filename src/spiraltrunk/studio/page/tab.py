"""Interface of a tab of the page."""

from __future__ import annotations

from typing import Any, Protocol


class Tab(Protocol):
    """One tab: controls in the side panel, and nodes of the scene below ``/NAME``.

    Its constructor takes the `Page`. All methods are called in the page's own thread, one after the other.
    """

    name: str
    """Its name, in lower case; also the root of its nodes in the scene."""
    title: str
    """Its title."""

    def build(self) -> None:
        """Add controls and nodes; called once, within the tab's container, before any other method."""

    def show(self) -> None:
        """Become the visible tab: draw what was put off while hidden."""

    def hide(self) -> None:
        """Become invisible: stop what only moves the picture."""

    def read_settings(self) -> dict[str, Any]:
        """Settings that come back after a reload, as JSON values."""

    def apply_settings(self, settings: dict[str, Any]) -> None:
        """Take settings of an earlier page; what does not fit is left out."""

    def close(self) -> None:
        """The page is gone: stop what the tab started, the robot first."""
