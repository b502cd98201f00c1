"""TOML whose keys name their units, and the keys of a design file in one table that reader and writer share.

A file holds decimals in mm, g, deg and MPa, a dataclass floats in SI. Both directions use exact decimal arithmetic, so
that a written value reads back as the same float, and 30 deg in a file is the float ``math.pi / 6``.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Sequence
from dataclasses import MISSING, Field, fields
from decimal import Context, Decimal
from enum import Enum
from typing import Any, NamedTuple, final

from spiraltrunk.checks import Range
from spiraltrunk.design.gripper import GripperDesign
from spiraltrunk.design.mount import ArmDesign, HousingDesign
from spiraltrunk.design.parts import CableDesign, JointDesign, MassDesign
from spiraltrunk.design.spiral import Spiral
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, Unquoted, describe

SCHEMA = 1
"""Version of the formats of designs and protocols."""

MOST_BYTES = 200_000
"""Largest TOML file [bytes]: ten times a protocol of 200 runs (ours)."""

_MOST_DOTS = 250
"""Most dots in a line: an array of 200 decimals has 200. The parser's time grows with the square of a key's dots."""

_MOST_BITS = 14_000
"""Most bits of a whole number, 4214 decimal digits: Python prints 4300, and reads more in other bases than the ten."""

_EXACT = Context(prec=60, traps=[])

ONE = Decimal(1)
MILLI = Decimal("1e-3")
MEGA = Decimal("1e6")
DEGREE = _EXACT.divide(Decimal(math.pi), Decimal(180))
"""pi / 180 with the float pi, so that degrees mean what ``math.pi / 6`` means in code."""


class Kind(Enum):
    """Kind of a key's value, as errors describe it."""

    TEXT = "a text"
    COUNT = "a whole number"
    NUMBER = "a finite number"
    NUMBERS = "an array of finite numbers"
    COUNTS = "an array of whole numbers"


@final
class Key(NamedTuple):
    """One key of a file and the field that it fills."""

    name: str
    owner: type
    field: str
    unit: Decimal = ONE
    kind: Kind = Kind.NUMBER
    follows_rule: bool = False
    """Whether a rule gives the value where the file does not."""
    hides_default: bool = False
    """Whether a written file leaves the key out where the value is the default."""
    usual: tuple[float, float] | None = None
    """Least and largest usual value of a number, in the key's unit (ours): the range of a slider. More is allowed."""

    @property
    def is_required(self) -> bool:
        """Whether the field has no default and no rule."""
        own = self._find_field()
        return own.default is MISSING and own.default_factory is MISSING and not self.follows_rule

    def is_written(self, value: object) -> bool:
        """Whether a file that describes ``value`` has the key."""
        return value is not None and not (self.hides_default and value == self._find_field().default)

    def _find_field(self) -> Field[Any]:
        return next(field for field in fields(self.owner) if field.name == self.field)


TABLES: dict[str, tuple[Key, ...]] = {
    "": (Key("name", TrunkDesign, "name", kind=Kind.TEXT),),
    "spiral": (
        Key("a_mm", Spiral, "a", MILLI, usual=(2, 100)),
        Key("b", Spiral, "b", usual=(0.03, 0.6)),
        Key("k", TrunkDesign, "k", follows_rule=True, usual=(0.5, 0.95)),
        Key("delta_theta_deg", TrunkDesign, "delta_theta", DEGREE, usual=(5, 60)),
        Key("n_section", TrunkDesign, "n_section", kind=Kind.COUNT, usual=(2, 60)),
        Key("theta_tip_deg", TrunkDesign, "theta_tip", DEGREE, usual=(0, 360)),
    ),
    "joint": (
        Key("radius_mm", JointDesign, "radius", MILLI, usual=(0.5, 15)),
        Key("length_mm", JointDesign, "length", MILLI, usual=(0.5, 10)),
        Key("youngs_modulus_mpa", JointDesign, "youngs_modulus", MEGA, usual=(1, 100)),
        Key("damping_time_s", JointDesign, "damping_time", usual=(0, 0.2)),
        Key("stiffness_nm_per_rad", JointDesign, "stiffness", kind=Kind.NUMBERS),
    ),
    "cable": (
        Key("angles_deg", CableDesign, "angles", DEGREE, Kind.NUMBERS),
        Key("hole_fraction", CableDesign, "hole_fraction", usual=(0.1, 0.95)),
        Key("tension_max_n", CableDesign, "tension_max", usual=(5, 200)),
        Key("friction", CableDesign, "friction", usual=(0, 0.5)),
    ),
    "mass": (
        Key("density_kg_per_m3", MassDesign, "density", usual=(50, 1300)),
        Key("sections_g", MassDesign, "sections", MILLI, Kind.NUMBERS),
        Key("center_fraction", MassDesign, "center_fraction", usual=(0.3, 0.7)),
    ),
    "gripper": (
        Key("n_finger", GripperDesign, "n_finger", kind=Kind.COUNT, usual=(2, 8)),
        Key("b", GripperDesign, "b", usual=(0.1, 1.5)),
        Key("delta_theta_deg", GripperDesign, "delta_theta", DEGREE, usual=(20, 85)),
        Key("n_phalanx", GripperDesign, "n_phalanx", kind=Kind.COUNT, usual=(1, 4)),
        Key("finger_length_mm", GripperDesign, "finger_length", MILLI, usual=(5, 150)),
        Key("finger_width_mm", GripperDesign, "finger_width", MILLI, usual=(2, 40)),
        Key("mount_radius_mm", GripperDesign, "mount_radius", MILLI, usual=(0, 40)),
        Key("mass_g", GripperDesign, "mass", MILLI, usual=(0.5, 50)),
        Key("stiffness_nm_per_rad", GripperDesign, "stiffness", usual=(0.001, 0.5)),
        Key("tension_max_n", GripperDesign, "tension_max", usual=(1, 50)),
        Key("n_leg", GripperDesign, "n_leg", kind=Kind.COUNT, hides_default=True, usual=(1, 2)),
    ),
    "housing": (
        Key("radius_mm", HousingDesign, "radius", MILLI, usual=(40, 150)),
        Key("length_mm", HousingDesign, "length", MILLI, usual=(40, 250)),
        Key("material", HousingDesign, "material", kind=Kind.TEXT),
        Key("mass_kg", HousingDesign, "mass", usual=(0.3, 5)),
        Key("neck_length_mm", HousingDesign, "neck_length", MILLI, usual=(10, 200)),
        Key("neck_mass_kg", HousingDesign, "neck_mass", usual=(0.01, 0.5)),
    ),
    "arm": (
        Key("model", ArmDesign, "model", kind=Kind.TEXT),
        Key("mount_site", ArmDesign, "mount_site", kind=Kind.TEXT),
        Key("base_height_mm", ArmDesign, "base_height", MILLI, usual=(0, 1500)),
        Key("roll_deg", ArmDesign, "roll", DEGREE, usual=(-180, 180)),
        Key("home_deg", ArmDesign, "home", DEGREE, Kind.NUMBERS),
    ),
}
"""Every key of a design file by table; a table is named after the field of `TrunkDesign` that it describes."""


def parse_toml(data: bytes) -> dict[str, Any]:
    """The document without its schema, its numbers exact; a ValueError that says why it is none."""
    if len(data) > MOST_BYTES:
        raise ValueError(f"it has more than {MOST_BYTES} bytes")
    if any(line.count(b".") > _MOST_DOTS for line in data.splitlines()):
        raise ValueError(f"a line has more than {_MOST_DOTS} dots")
    try:
        document = tomllib.loads(data.decode("utf-8-sig"), parse_float=Decimal)
    except UnicodeDecodeError:
        raise ValueError("it is no text in UTF-8") from None
    except RecursionError:
        raise ValueError("its arrays or tables are nested too deeply") from None
    except (ValueError, ArithmeticError) as error:
        reason = " ".join(str(error).split())[:200]
        raise ValueError("a number has too many digits" if "set_int_max_str_digits" in reason else reason) from None
    if any(value.bit_length() > _MOST_BITS for value in _list_values(document) if isinstance(value, int)):
        raise ValueError("a number has too many digits")
    schema = document.pop("schema", SCHEMA)
    if schema != SCHEMA:
        raise ValueError(f"schema is {describe(describe_toml(schema))}, not {SCHEMA}")
    return document


def _list_values(document: dict[str, Any]) -> list[object]:
    """All values of the document, those of its tables and arrays too."""
    values: list[object] = [document]
    for value in values:  # It grows meanwhile.
        values += value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return values


def read_table(table: str, content: object, keys: Sequence[Key], more: Sequence[str] = ()) -> dict[str, Any]:
    """Values of one table in SI, by field; errors list its keys, and ``more`` that are read elsewhere.

    Raises:
        DesignError: for what is no table, an unknown or a missing key, or a value that `read_value` refuses.
    """
    names = [key.name for key in keys]
    known = ", ".join([*names, *more])
    if not isinstance(content, dict):
        raise DesignError(table, got=describe_toml(content), allowed=f"a table with the keys {known}")
    for name, value in content.items():
        if name not in names:
            raise DesignError(_join_names(table, name), got=describe_toml(value), allowed=f"only the keys {known}")
    values: dict[str, Any] = {}
    for key in keys:
        name = _join_names(table, key.name)
        if key.name in content:
            values[key.field] = read_value(name, content[key.name], key)
        elif key.is_required:
            place = f" of {table}" if table else ""
            raise DesignError(name, got=Unquoted("missing"), allowed=f"the key {key.name}{place}, {key.kind.value}")
    return values


def read_value(name: str, value: object, key: Key) -> object:
    """A parsed TOML value in SI, as the field of ``key`` takes it; the error for any other value says ``name``."""
    if key.kind is Kind.NUMBER:
        return _to_si(name, value, key.unit)
    if key.kind is Kind.NUMBERS and isinstance(value, list):
        return tuple(_to_si(f"{name}[{i}]", item, key.unit) for i, item in enumerate(value))
    if key.kind is Kind.COUNTS and isinstance(value, list):
        return tuple(_read_count(f"{name}[{i}]", item) for i, item in enumerate(value))
    if type(value) is {Kind.TEXT: str, Kind.COUNT: int}.get(key.kind):
        return value
    raise DesignError(name, got=describe_toml(value), allowed=key.kind.value)


def format_value(value: object, key: Key) -> str:
    """The value of a field as TOML text that `read_value` turns back into the same value."""
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, tuple):
        return "[" + ", ".join(_from_si(item, key.unit) for item in value) + "]"
    if key.kind is Kind.COUNT:
        return str(value)
    return _from_si(float(value), key.unit)  # type: ignore[arg-type]


def describe_toml(value: object) -> object:
    """A parsed TOML value for an error message: as TOML spells it, of tables and arrays the kind alone."""
    if isinstance(value, dict):
        return Unquoted("a table")
    if isinstance(value, list):
        return Unquoted(f"an array of {len(value)}")
    return value if isinstance(value, str) else Unquoted(str(value).lower())


def convert_error(error: DesignError, name: str, unit: Decimal, typed: object) -> DesignError:
    """The error about a field in SI, in the name, the unit and the value that were typed."""
    allowed = error.allowed.in_unit(float(unit)) if isinstance(error.allowed, Range) else error.allowed
    return DesignError(name, got=error.got if isinstance(error.got, Unquoted) else typed, allowed=allowed)


def as_typed(error: DesignError) -> DesignError:
    """The error in the file's key and unit, where it is about a field in SI."""
    field, bracket, index = error.name.partition("[")
    found = find_key(field)
    if found is None:
        return error
    name, key = found
    got = Unquoted(format_value(error.got, key)) if isinstance(error.got, (float, int, tuple)) else error.got
    return convert_error(error, f"{name}{bracket}{index}", key.unit, got)


def find_key(field: str) -> tuple[str, Key] | None:
    """Dotted name and key that fill a field, which errors call ``joint.radius``; None where there is none."""
    for table, keys in TABLES.items():
        for key in keys:
            if field == (key.field if key.owner is TrunkDesign else f"{table}.{key.field}"):
                return _join_names(table, key.name), key
    return None


def _join_names(table: str, name: str) -> str:
    """Dotted name of a key as the file spells it, on one line."""
    shown = ascii(name)[1:-1][:60]
    return f"{table}.{shown}" if table else shown


def _to_si(name: str, value: object, unit: Decimal) -> float:
    """The float nearest to ``value`` times ``unit``."""
    is_number = isinstance(value, (Decimal, int)) and not isinstance(value, bool)
    number = float(_EXACT.multiply(Decimal(value), unit)) if is_number else math.nan  # type: ignore[arg-type]
    if not math.isfinite(number):
        raise DesignError(name, got=describe_toml(value), allowed=Kind.NUMBER.value)
    return number


def _read_count(name: str, value: object) -> int:
    if type(value) is not int:
        raise DesignError(name, got=describe_toml(value), allowed=Kind.COUNT.value)
    return value


def _from_si(value: float, unit: Decimal) -> str:
    """The shortest decimal that reads back as ``value``; 17 digits distinguish all floats."""
    exact = _EXACT.divide(Decimal(value), unit)
    number = exact
    for digits in (15, 16, 17):
        number = Context(prec=digits, traps=[]).plus(exact)
        if float(_EXACT.multiply(number, unit)) == value:
            break
    number = number.normalize(_EXACT)
    if number and not -5 <= number.adjusted() < 16:
        return f"{number:e}"
    text = f"{number:f}"
    return text if "." in text else text + ".0"
