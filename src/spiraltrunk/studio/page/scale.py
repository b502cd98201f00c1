"""Scales of sliders: range, unit and digits, and what is refused in words."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import final

_NO_BREAK = "\N{NO-BREAK SPACE}"


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
    digits: int | None = None
    """Digits behind the point that are shown; None takes those of the step."""
    typed_digits: int | None = None
    """Digits behind the point that are taken of a typed number; None takes those that are shown."""

    @property
    def precision(self) -> int:
        """Digits behind the point."""
        return max(0, -math.floor(math.log10(self.step) + 1e-9)) if self.digits is None else self.digits

    @property
    def text(self) -> str:
        """Label with unit, in which no line breaks."""
        return label_with_unit(self.label, self.unit)

    @property
    def allowed(self) -> str:
        """The range with its unit, in words."""
        return f"{self.least:g} to {self.most:g} {self.unit}".rstrip()

    def include(self, value: float) -> Scale:
        """The scale, with an end moved to a value that lies off it, rounded outwards to 3 significant digits."""
        if not math.isfinite(value) or self.accepts(value):
            return self
        return replace(
            self, least=min(self.least, _round_outwards(value, math.floor)),
            most=max(self.most, _round_outwards(value, math.ceil)),
        )  # fmt: skip

    def accepts(self, value: float) -> bool:
        """Whether a value lies on the scale."""
        return math.isfinite(value) and self.least <= value <= self.most

    def tell_change(self, given: str, taken: float) -> str:
        """That a value holds which is another than the given one."""
        return f"{self.label}: {given} \N{RIGHTWARDS ARROW} {taken:.{self.precision}f} {self.unit}".rstrip()

    def refuse(self, text: str) -> str:
        """Why a text is no value of the scale, and what is."""
        given = " ".join(text.split())[:40]
        if is_number(given):
            return f"{self.label} was {given}; allowed: {self.allowed}"
        return f"{self.label} was {given!r}; allowed: a number, {self.allowed}, with a point for decimals"


def is_number(text: str) -> bool:
    """Whether a text is a decimal number, of the digits 0 to 9 alone."""
    return re.fullmatch(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)(e[-+]?[0-9]+)?", text, re.IGNORECASE) is not None


def _round_outwards(value: float, whole: Callable[[float], int]) -> float:
    """A value with 3 significant digits, rounded by ``whole``."""
    if value == 0.0:
        return 0.0
    digit = 10.0 ** (math.floor(math.log10(abs(value))) - 2)
    return float(f"{whole(value / digit) * digit:.3g}")


def label_with_unit(label: str, unit: str) -> str:
    """Label with its unit in brackets, which stay in one line."""
    return f"{label} [{unit.replace(' ', _NO_BREAK)}]" if unit else label
