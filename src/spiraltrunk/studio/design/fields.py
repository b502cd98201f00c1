"""Fields of a design as controls show them: label, unit, range and hint, all read from the design's own tables."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from decimal import Decimal, InvalidOperation
from typing import Any, final

from spiraltrunk.design import TrunkDesign
from spiraltrunk.design.schema import TABLES, Key, Kind, format_value, read_value
from spiraltrunk.errors import DesignError
from spiraltrunk.field_docs import read_field_docs
from spiraltrunk.studio.page.scale import Scale, is_number, label_with_unit

_UNITS = {
    "mm": "mm", "deg": "deg", "mpa": "MPa", "nm_per_rad": "N m/rad", "n": "N", "g": "g", "kg": "kg", "s": "s",
    "kg_per_m3": "kg/m³", "": "",
}  # fmt: skip
"""Unit by the suffix of a key of the design file."""

_LABELS = {
    "spiral.a": "Radius a", "spiral.b": "Growth b", "k": "Ratio k",
    "delta_theta": "Angle Δθ", "n_section": "Sections", "theta_tip": "Tip angle θ",
    "joint.youngs_modulus": "Young's modulus", "joint.stiffness": "Measured stiffness",
    "cable.angles": "Directions", "cable.hole_fraction": "Hole position", "cable.tension_max": "Largest tension",
    "mass.sections": "Section masses", "mass.center_fraction": "Centre of mass",
    "gripper.n_finger": "Fingers", "gripper.b": "Growth b",
    "gripper.delta_theta": "Angle Δθ", "gripper.n_phalanx": "Phalanges",
    "gripper.tension_max": "Largest tension", "gripper.n_leg": "Cable legs", "arm.model": "Arm",
    "arm.home": "Initial joints",
}  # fmt: skip
"""Labels of fields whose name does not say enough; others are labelled by their name."""

_STEPS = 200
"""Least number of steps of a slider [-]."""

TYPED_DIGITS = 6
"""Digits behind the point that are taken of a typed number, though fewer are shown [-]."""


@final
@dataclass(frozen=True, kw_only=True)
class ShownField:
    """One field of a design."""

    name: str
    """Its dotted name, as in `design.edit.change_field`."""
    key: Key
    """Its key in the design file."""
    label: str
    """Label of its control."""
    unit: str
    """Unit of its control."""
    hint: str
    """What it is."""
    is_optional: bool
    """Whether it may be None, which makes a rule give its value."""

    @property
    def text(self) -> str:
        """Label with unit."""
        return label_with_unit(self.label, self.unit)

    @property
    def scale(self) -> Scale:
        """Scale of its slider, over the usual range."""
        assert self.key.usual is not None
        least, most = self.key.usual
        step, digits = (1.0, 0) if self.key.kind is Kind.COUNT else divide(most - least)
        typed = max(digits, TYPED_DIGITS) if digits else 0
        return Scale(
            label=self.label, unit=self.unit, least=least, most=most, step=step, digits=digits, typed_digits=typed,
            hint=self.hint,
        )  # fmt: skip

    def to_shown(self, value: float) -> float:
        """A value in the control's unit."""
        return float(format_value(value, self.key))

    def from_shown(self, value: float) -> float:
        """The value in SI that a control stands for."""
        if self.key.kind is Kind.COUNT:
            return round(value)
        return float(read_value(self.name, Decimal(repr(float(value))), self.key))  # type: ignore[arg-type]

    def format(self, value: Any) -> str:
        """Text of a value, of numbers separated by commas; empty for None."""
        if value is None or isinstance(value, str):
            return value or ""
        return format_value(value, self.key).strip("[]")

    def parse(self, text: str) -> Any:
        """The value in SI that a text stands for.

        Raises:
            DesignError: for what are no numbers.
        """
        if self.is_optional and not text.strip():
            return None
        if self.key.kind is Kind.TEXT:
            return text.strip()
        try:
            numbers = [_read_number(each.strip()) for each in text.rstrip(", ").split(",")]
        except InvalidOperation:
            raise DesignError(self.text, got=text[:80], allowed="numbers, separated by commas") from None
        return read_value(self.text, numbers, self.key)


def _read_number(text: str) -> Decimal:
    """A decimal number exactly; an InvalidOperation for any other text."""
    if not is_number(text):
        raise InvalidOperation
    return Decimal(text)


def list_shown(table: str) -> tuple[ShownField, ...]:
    """Fields of one table of the design file."""
    return tuple(_describe(table, key) for key in TABLES[table])


def _describe(table: str, key: Key) -> ShownField:
    name = key.field if key.owner is TrunkDesign else f"{table}.{key.field}"
    hint = read_field_docs(key.owner).get(key.field, key.field)
    default = {field.name: field.default for field in fields(key.owner)}[key.field]
    return ShownField(
        name=name, key=key, label=_LABELS.get(name, key.field.replace("_", " ").capitalize()),
        unit=_UNITS[key.name[len(key.field) + 1 :]], hint=hint, is_optional=default is None,
    )  # fmt: skip


def divide(width: float) -> tuple[float, int]:
    """Step of a slider over a range, 1, 2 or 5 times a power of ten, and the digits of its box."""
    finest = width / _STEPS
    power = 10.0 ** math.floor(math.log10(finest))
    step = max(each * power for each in (1.0, 2.0, 5.0) if each * power <= finest * (1 + 1e-9))
    return round(step, 12), max(0, 1 - math.floor(math.log10(finest)))
