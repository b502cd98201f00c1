"""Fields of a design as controls show them: label, unit, range and hint, all read from the design's own tables."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, fields
from decimal import Decimal, InvalidOperation
from typing import Any, final

import numpy as np

from spiraltrunk.design import TrunkDesign
from spiraltrunk.design.edit import MEASURED, read_field
from spiraltrunk.design.schema import TABLES, Key, Kind, as_typed, format_value, read_value
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
    "delta_theta": "Angle Δθ alone", "n_section": "Sections", "theta_tip": "Tip angle θ",
    "joint.radius": "Joint radius", "joint.length": "Joint length",
    "joint.youngs_modulus": "Young's modulus", "joint.stiffness": "Measured stiffness",
    "cable.angles": "Directions", "cable.hole_fraction": "Hole position", "cable.tension_max": "Largest tension",
    "mass.sections": "Section masses", "mass.center_fraction": "Centre of mass",
    "gripper.n_finger": "Fingers", "gripper.b": "Finger growth b",
    "gripper.delta_theta": "Finger angle Δθ", "gripper.n_phalanx": "Phalanges", "gripper.mass": "Gripper mass",
    "gripper.stiffness": "Finger stiffness", "gripper.tension_max": "Largest finger tension",
    "gripper.n_leg": "Cable legs", "housing.radius": "Housing radius", "housing.length": "Housing length",
    "housing.mass": "Housing mass", "arm.model": "Model of the arm", "arm.home": "Initial joints",
}  # fmt: skip
"""Labels of fields whose name does not say enough; others are labelled by their name."""

_OTHERWISE = {
    "joint.stiffness": "it follows from the joint's radius, its length and Young's modulus",
    "mass.sections": "they follow from the density", "mass.center_fraction": "it is the centroid's",
    "housing.mass": "it follows from the material", "housing.neck_mass": "it follows from the material",
    "arm.home": "those of the arm's description",
}  # fmt: skip
"""What holds of an optional field without a value."""

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
    otherwise: str
    """What holds where it is None, in words; empty for a field that always has a value."""

    @property
    def is_optional(self) -> bool:
        """Whether it may be None, which makes a rule give its value."""
        return bool(self.otherwise)

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
    hint = _simplify(read_field_docs(key.owner).get(key.field, key.field))
    default = {field.name: field.default for field in fields(key.owner)}[key.field]
    return ShownField(
        name=name, key=key, label=_LABELS.get(name, key.field.replace("_", " ").capitalize()),
        unit=_UNITS[key.name[len(key.field) + 1 :]], hint=hint, otherwise=_OTHERWISE[name] if default is None else "",
    )  # fmt: skip


def _simplify(text: str) -> str:
    """A docstring of a field for a person at its control, whose unit is another: no unit in SI, and no word of code."""
    text = re.sub(r"\s*\[[^\]]*\]", "", text)
    text = re.sub(r"[;:,]? None\b[^.]*", "", text)
    return re.sub(r" \(ours\)|(?<=\()ours[:;] ", "", text)


def as_labelled(error: DesignError) -> DesignError:
    """The error with label and unit of its control, where a control shows what it is about."""
    field, _, index = error.name.partition("[")
    shown = next((each for table in TABLES for each in list_shown(table) if each.name == field), None)
    typed, place = as_typed(error), index.rstrip("]")
    if shown is None:
        return typed
    label = f"{shown.text}, number {int(place) + 1}" if place.isdigit() else shown.text
    return DesignError(label, got=typed.got, allowed=typed.allowed)


def describe_lost(before: TrunkDesign, after: TrunkDesign) -> str:
    """Which measured values another shape of the trunk has left out, in words; empty for none.

    A value that is left out while the sections stay as they are was taken back by the person.
    """
    lost = [name for name in MEASURED if read_field(before, name) is not None and read_field(after, name) is None]
    if not lost or np.array_equal(before.section_length, after.section_length):
        return ""
    labels = {shown.name: shown for table in TABLES for shown in list_shown(table)}
    told = "; ".join(f"{labels[name].label}: {labels[name].otherwise}" for name in lost)
    return f"the shape has changed, so that measured values are left out. {told}."


def divide(width: float) -> tuple[float, int]:
    """Step of a slider over a range, 1, 2 or 5 times a power of ten, and the digits of its box."""
    finest = width / _STEPS
    power = 10.0 ** math.floor(math.log10(finest))
    step = max(each * power for each in (1.0, 2.0, 5.0) if each * power <= finest * (1 + 1e-9))
    return round(step, 12), max(0, 1 - math.floor(math.log10(finest)))
