"""Design files: one TOML file describes a robot, in keys that end in their units.

Any file gives a design or a `DesignError`; a design written and read back is equal to itself.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from decimal import Decimal
from pathlib import Path
from typing import Any

from spiraltrunk.checks import check_type
from spiraltrunk.design import presets
from spiraltrunk.design.rules import compactness
from spiraltrunk.design.schema import TABLES, convert_error, describe_toml, find_key, format_value, read_value
from spiraltrunk.design.spiral import Spiral
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, Unquoted
from spiraltrunk.files.atomic import write_file
from spiraltrunk.files.text_lines import check_regular

SCHEMA = 1
"""Version of the format."""

_PARTS = tuple(table for table in TABLES if table)

_HEAD = """\
# A spiraltrunk design, as `spiraltrunk design` writes it.
# Each key ends in its unit. Keys with a default may be left out; without [gripper] there is no gripper.
"""


def load_design(path_or_preset: str | Path) -> TrunkDesign:
    """The preset of that name, else the design in that TOML file.

    A relative path of an arm model is taken from the file's folder and made absolute.

    Raises:
        DesignError: for a file that cannot be read, is not TOML, or says what no trunk can be; it names the key.
    """
    check_type("design", path_or_preset, (str, Path))
    if path_or_preset in presets.NAMES:
        return presets.get(str(path_or_preset))
    path = Path(path_or_preset)
    document = _parse(path)
    try:
        design = _assemble(document)
    except DesignError as error:
        raise _as_typed(error) from None
    if not design.arm.is_file or Path(design.arm.model).is_absolute():
        return design
    model = path.absolute().parent / design.arm.model
    return replace(design, arm=replace(design.arm, model=str(model)))


def write_design(design: TrunkDesign, path: str | Path, notes: Sequence[str] = ()) -> Path:
    """Write the design as TOML, whole or not at all, and return where.

    Args:
        design: what is written.
        path: the file.
        notes: lines of comment at its head, such as where the numbers come from.

    Raises:
        DesignError: where the file cannot be written; what was there stays as it was.
    """
    check_type("path", path, (str, Path))
    text = format_design(design, notes)
    target = Path(path)
    with _as_design_error("path", target, "a file, new or replaced, in a folder that can be written"):
        check_regular(target)
        write_file(target, text.encode())
    return target


def format_design(design: TrunkDesign, notes: Sequence[str] = ()) -> str:
    """The design as the text of a TOML file, with lines of comment at its head."""
    check_type("design", design, TrunkDesign)
    comments = "".join(f"# {' '.join(note.split())}\n" for note in notes)
    text = f"{_HEAD}{comments}schema = {SCHEMA}\n"
    for table, keys in TABLES.items():
        part = getattr(design, table) if table else design
        if part is None:
            continue
        text += f"\n[{table}]\n" if table else ""
        for key in keys:
            value = getattr(design if key.owner is TrunkDesign else part, key.field)
            text += "" if value is None else f"{key.name} = {format_value(value, key)}\n"
    return text


def _parse(path: Path) -> dict[str, Any]:
    with _as_design_error("design", path, f"a preset ({', '.join(presets.NAMES)}) or a .toml file"):
        check_regular(path)
        text = path.read_bytes().decode("utf-8-sig")
    with _as_design_error("design", path, "a file of valid TOML"):
        return tomllib.loads(text, parse_float=Decimal)


def _as_typed(error: DesignError) -> DesignError:
    """The error about a field in SI, in the key and the unit of the file."""
    field, bracket, index = error.name.partition("[")
    found = find_key(field)
    if found is None:
        return error
    table, key = found
    got = Unquoted(format_value(error.got, key)) if isinstance(error.got, (float, int, tuple)) else error.got
    return convert_error(error, f"{_dotted(table, key.name)}{bracket}{index}", key.unit, got)


def _assemble(document: dict[str, Any]) -> TrunkDesign:
    schema = document.pop("schema", SCHEMA)
    if schema != SCHEMA:
        raise DesignError("schema", got=describe_toml(schema), allowed=str(SCHEMA))
    top = _read_table("", {name: value for name, value in document.items() if name not in _PARTS})
    spiral = _read_table("spiral", document.get("spiral", {}))
    trunk: dict[str, Any] = {"gripper": None, **top[TrunkDesign], **spiral.get(TrunkDesign, {})}
    trunk["spiral"] = Spiral(**spiral[Spiral])
    trunk.setdefault("k", compactness(trunk["spiral"].b))
    for table in _PARTS:
        owner = TABLES[table][0].owner
        if table in document and owner is not Spiral:
            trunk[table] = owner(**_read_table(table, document[table]).get(owner, {}))
    return TrunkDesign(**trunk)


def _read_table(table: str, content: object) -> dict[type, dict[str, Any]]:
    """Values of one table in SI, by the dataclass and the field that they fill; the top of the file is table ""."""
    keys = {key.name: key for key in TABLES[table]}
    known = ", ".join([*keys] if table else ["schema", *keys, *(f"[{part}]" for part in _PARTS)])
    if not isinstance(content, dict):
        raise DesignError(table, got=describe_toml(content), allowed=f"a table with the keys {known}")
    for name in content:
        if name not in keys:
            raise DesignError(_dotted(table, name), got=describe_toml(content[name]), allowed=f"only the keys {known}")
    values: dict[type, dict[str, Any]] = {}
    for name, key in keys.items():
        if name in content:
            values.setdefault(key.owner, {})[key.field] = read_value(_dotted(table, name), content[name], key)
        elif key.is_required:
            raise DesignError(_dotted(table, name), got=Unquoted("missing"), allowed=key.kind.value)
    return values


def _dotted(table: str, name: str) -> str:
    """Name of a key as the file spells it, on one line."""
    shown = ascii(name)[1:-1][:60]
    return f"{table}.{shown}" if table else shown


@contextmanager
def _as_design_error(name: str, path: Path, allowed: str) -> Iterator[None]:
    """Turn an error of the system, the decoder or the parser about a file into one line."""
    try:
        yield
    except (OSError, ValueError, ArithmeticError, RecursionError) as error:
        reason = " ".join(str(getattr(error, "strerror", None) or error).split())[:200]
        raise DesignError(name, got=str(path), allowed=f"{allowed}; {reason}") from error
