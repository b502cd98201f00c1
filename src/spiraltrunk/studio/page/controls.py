"""Controls whose values are checked on the server: what a page sends may be anything."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from typing import Any, final

from spiraltrunk.errors import SpiralTrunkError, StudioError
from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.page.scale import Scale, is_number

REST = 0.8
"""Time without a new value after which the person rests [s]."""


@final
class Slider:
    """A slider with a number box; a value off its scale, or one that is refused, is reported and taken back.

    The box sends its value when it is complete, by Enter or when it is left. Nothing is reported, and nothing is
    written into the box, while the person drags.
    """

    def __init__(self, page: Page, scale: Scale, value: float, on_change: Callable[[float], None]) -> None:
        """Add the control where the page's container is open.

        Args:
            page: the page.
            scale: the scale.
            value: its first value, moved onto the scale.
            on_change: called in the page's thread with each new value; of values that follow fast, with the last. An
                error of ours that it raises takes the value back.
        """
        self._page = page
        self._scale = self._usual = scale
        self._on_change = on_change
        self._value = min(max(float(value), scale.least), scale.most)
        self._touched = -math.inf
        self.handle: Any = page.gui.add_slider(
            scale.text, float(scale.least), float(scale.most), float(scale.step), self._shown, hint=scale.hint
        )
        self.handle.precision = scale.precision if scale.typed_digits is None else scale.typed_digits
        self._key = f"slider {self.handle._impl.uuid}"
        self.handle.on_update(self._note)
        page.on_text(self.handle._impl.uuid, self)

    @property
    def value(self) -> float:
        """The last value that was accepted."""
        return self._value

    @property
    def scale(self) -> Scale:
        """Its scale."""
        return self._scale

    def set(self, value: float) -> None:
        """Show a value without calling ``on_change``; it is moved onto the scale."""
        self._value = min(max(float(value), self._scale.least), self._scale.most)
        self._show()

    def fit(self, value: float) -> None:
        """Show a value without calling ``on_change``; the scale is the usual one, or that one up to the value."""
        scale = self._usual.include(value)
        if scale != self._scale:
            self._scale = scale
            self.handle.min, self.handle.max = float(scale.least), float(scale.most)
        self.set(value)

    def set_scale(self, scale: Scale) -> None:
        """Change the range; the value is moved onto it without calling ``on_change``."""
        self._scale = self._usual = scale
        self.handle.min, self.handle.max = float(scale.least), float(scale.most)
        self.set(self._value)

    def read_text(self, text: str) -> None:
        """Refuse what was typed and is no value of the scale; of a value, tell to what it was rounded."""
        if is_number(text.strip()) and self._scale.accepts(float(text)):
            self.tell_later(lambda: self._scale.tell_change(text.strip(), self._value))
        else:
            self._page.notice(self._scale.refuse(text), "refusal")

    def tell_later(self, find: Callable[[], str]) -> None:
        """Tell, once the person rests, how what was given last has been changed: ``find`` says it, or nothing."""

        def tell() -> None:
            if told := find():
                self._page.notice(told, "refusal", "Adjusted")

        self._page.later(f"{self._key} tells", tell, REST)

    @property
    def _shown(self) -> float:
        """The value with the digits of the box."""
        return min(max(round(self._value, self._scale.precision), self._scale.least), self._scale.most)

    @property
    def _is_removed(self) -> bool:
        return bool(self.handle._impl.removed)

    def _show(self) -> None:
        """Write the value into the control, once the person rests; one that is gone by then is left."""
        if self._is_removed:
            return
        rest = self._touched + REST - time.monotonic()
        if rest > 0.0:
            self._page.later(f"{self._key} shows", self._show, rest)
        elif float(self.handle.value) != self._shown and not math.isclose(float(self.handle.value), self._value):
            self.handle.value = self._shown

    def _note(self, event: Any) -> None:
        """A value has come; nothing is written over one of a person that is not taken yet."""
        if event.client is not None:
            self._touched = time.monotonic()
        self._page.take(self._key, self._take)

    def _take(self) -> None:
        given = float(self.handle.value)
        if given in (self._value, self._shown):
            return
        self._touched = time.monotonic()
        before, self._value = self._value, given
        try:
            self._check(given)
            self._on_change(given)
            self._page.clear_refusal()
        except SpiralTrunkError as error:
            self._value = before
            reason = str(error)
            self._page.later(f"{self._key} refuses", lambda: self._refuse(given, reason), REST)

    def _check(self, given: float) -> None:
        scale = self._scale
        if not scale.accepts(given):
            raise StudioError(scale.refuse(f"{given:g}"))

    def _refuse(self, given: float, reason: str) -> None:
        """Tell a refusal where the refused value still stands."""
        if not self._is_removed and float(self.handle.value) == given:
            self.handle.value = self._shown
            self._page.notice(reason, "refusal")


@final
class Switch:
    """A checkbox."""

    def __init__(self, page: Page, label: str, value: bool, on_change: Callable[[bool], None], *, hint: str) -> None:
        """Add the control where the page's container is open; ``on_change`` is called in the page's thread.

        An error of ours that it raises takes the value back.
        """
        self._page = page
        self._on_change = on_change
        self._value = value
        self.handle: Any = page.gui.add_checkbox(label, value, hint=hint)
        self.handle.on_update(lambda _: page.take(f"switch {self.handle._impl.uuid}", self._take))

    @property
    def value(self) -> bool:
        """Whether it is on."""
        return self._value

    def set(self, value: bool) -> None:
        """Show a value without calling ``on_change``."""
        self._value = value
        if bool(self.handle.value) != value:
            self.handle.value = value

    def _take(self) -> None:
        given = bool(self.handle.value)
        if given == self._value:
            return
        self._value = given
        try:
            self._on_change(given)
            self._page.clear_refusal()
        except SpiralTrunkError:
            self.set(not given)
            raise


@final
class TextBox:
    """A text of limited length, taken when the person rests; one that is refused is reported and taken back."""

    def __init__(
        self, page: Page, label: str, value: str, on_change: Callable[[str], None], *, hint: str, most: int = 2000
    ) -> None:
        """Add the control where the page's container is open.

        Args:
            page: the page.
            label: its label, with the unit.
            value: its first text.
            on_change: called in the page's thread with each new text; an error of ours that it raises takes it back.
            hint: one line that explains it.
            most: most characters.
        """
        self._page = page
        self._label = label
        self._value = value
        self._most = most
        self._on_change = on_change
        self.handle: Any = page.gui.add_text(label, value, hint=hint)
        self.handle.on_update(lambda _: page.take(f"text {self.handle._impl.uuid}", self._take, REST))

    @property
    def value(self) -> str:
        """The last text that was accepted."""
        return self._value

    def set(self, value: str) -> None:
        """Show a text without calling ``on_change``."""
        self._value = value
        if self.handle.value != value:
            self.handle.value = value

    def _take(self) -> None:
        given = str(self.handle.value)
        if given == self._value:
            return
        before, self._value = self._value, given
        try:
            if len(given) > self._most:
                raise StudioError(f"{self._label} has {len(given)} characters; allowed: {self._most}")
            self._on_change(given)
            self._page.clear_refusal()
        except SpiralTrunkError:
            self.set(before)
            raise


@final
class Choice:
    """A drop-down list; a value that is not in it is reported and taken back."""

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
        self.handle.on_update(lambda _: page.take(key, self._take))

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
            self._page.notice(f"{self._label} was {given[:80]!r}; allowed: {', '.join(self.options)}", "refusal")
            return
        self._value = given
        self._on_change(given)
        self._page.clear_refusal()
