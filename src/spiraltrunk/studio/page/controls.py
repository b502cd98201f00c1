"""Controls whose values are checked on the server: what a page sends may be anything."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, final

from spiraltrunk.studio.page.page import Page


@final
@dataclass(frozen=True, kw_only=True)
class Scale:
    """Scale of a slider, in the unit that it shows."""

    label: str
    """Its label; the unit is added in brackets."""
    unit: str
    """Its unit, such as "mm"."""
    least: float
    """Smallest value."""
    most: float
    """Largest value."""
    step: float
    """Smallest change."""
    hint: str
    """One line that explains it."""

    @property
    def text(self) -> str:
        """Label with unit."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label

    def accepts(self, value: float) -> bool:
        """Whether a value lies on the scale."""
        return math.isfinite(value) and self.least <= value <= self.most


@final
class Slider:
    """A slider with a number box; a value off its scale is told and taken back."""

    def __init__(self, page: Page, scale: Scale, value: float, on_change: Callable[[float], None]) -> None:
        """Add the control where the page's container is open.

        Args:
            page: the page.
            scale: the scale.
            value: its first value, moved onto the scale.
            on_change: called in the page's thread with each new value; of values that follow fast, with the last.
        """
        self._page = page
        self._scale = scale
        self._on_change = on_change
        self._value = min(max(float(value), scale.least), scale.most)
        self.handle: Any = page.gui.add_slider(
            scale.text, float(scale.least), float(scale.most), float(scale.step), self._value, hint=scale.hint
        )
        key = f"slider {self.handle._impl.uuid}"
        self.handle.on_update(lambda _: page.later(key, self._take))

    @property
    def value(self) -> float:
        """The last value that was accepted."""
        return self._value

    def set(self, value: float) -> None:
        """Show a value without calling ``on_change``; it is moved onto the scale."""
        self._value = min(max(float(value), self._scale.least), self._scale.most)
        self.handle.value = self._value

    def _take(self) -> None:
        given = float(self.handle.value)
        if given == self._value:
            return
        if not self._scale.accepts(given):
            scale = self._scale
            self.handle.value = self._value
            self._page.notice(
                f"{scale.label} was {given:g}; allowed: {scale.least:g} to {scale.most:g} {scale.unit}".rstrip()
            )
            return
        self._value = given
        self._on_change(given)


@final
class Choice:
    """A drop-down list; a value that is not in it is told and taken back."""

    def __init__(
        self, page: Page, label: str, options: Sequence[str], value: str, on_change: Callable[[str], None], *, hint: str
    ) -> None:
        """Add the control where the page's container is open; ``on_change`` is called in the page's thread."""
        self._page = page
        self._on_change = on_change
        self._label = label
        self._value = value if value in options else options[0]
        self.handle: Any = page.gui.add_dropdown(label, tuple(options), initial_value=self._value, hint=hint)
        key = f"choice {self.handle._impl.uuid}"
        self.handle.on_update(lambda _: page.later(key, self._take))

    @property
    def value(self) -> str:
        """The chosen option."""
        return self._value

    @property
    def options(self) -> tuple[str, ...]:
        """What can be chosen."""
        return tuple(self.handle.options)

    def set(self, value: str) -> None:
        """Show an option without calling ``on_change``; one that is not in the list is left out."""
        if value in self.options:
            self._value = value
            self.handle.value = value

    def set_options(self, options: Sequence[str]) -> None:
        """Change the list; the chosen option stays where it is in it."""
        self.handle.options = tuple(options)
        if self._value not in options:
            self._value = options[0]
        self.handle.value = self._value

    def _take(self) -> None:
        given = str(self.handle.value)
        if given == self._value:
            return
        if given not in self.options:
            self.handle.value = self._value
            self._page.notice(f"{self._label} was {given[:80]!r}; allowed: {', '.join(self.options)}")
            return
        self._value = given
        self._on_change(given)


def add_button(page: Page, label: str, act: Callable[[], None], *, hint: str, **options: Any) -> Any:
    """Add a button whose act runs in the page's thread; further clicks while it waits count once."""
    handle = page.gui.add_button(label, hint=hint, **options)
    handle.on_click(lambda _: page.later(f"button {handle._impl.uuid}", act))
    return handle
