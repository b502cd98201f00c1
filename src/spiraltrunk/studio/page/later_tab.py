"""A tab whose packages are imported when it is built."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, final

from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.page.tab import Tab


@final
class LaterTab:
    """A tab that is there by its title alone until it is built: the page opens before its packages are imported."""

    def __init__(self, page: Page, *, title: str, load: Callable[[], Callable[[Page], Tab]]) -> None:
        """Keep the title.

        Args:
            page: the page.
            title: the tab's title, which is its name in lower case too.
            load: imports the tab, and gives its constructor.
        """
        self.title, self.name = title, title.lower()
        self._page, self._load = page, load
        self._tab: Tab | None = None

    @property
    def tab(self) -> Tab:
        """The tab itself, which has been built."""
        assert self._tab is not None
        return self._tab

    def build(self) -> None:
        """Import the tab, and build it."""
        self._tab = self._load()(self._page)
        self._tab.build()

    def show(self) -> None:
        """Become the visible tab."""
        self.tab.show()

    def hide(self) -> None:
        """Become invisible."""
        self.tab.hide()

    def read_settings(self) -> dict[str, Any]:
        """Settings that come back after a reload."""
        return self.tab.read_settings()

    def apply_settings(self, settings: dict[str, Any]) -> None:
        """Take settings of an earlier page."""
        self.tab.apply_settings(settings)

    def close(self) -> None:
        """Stop what the tab started."""
        self.tab.close()
