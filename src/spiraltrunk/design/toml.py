"""Design files: one TOML file says what a robot is, in keys that wear their units.

Any bytes give a design or a `DesignError`; a design written and read back is equal to itself.
"""

from __future__ import annotations

import stat
import sys
import tomllib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from spiraltrunk.checks import check_type
from spiraltrunk.design import presets
from spiraltrunk.design.rules import compactness
from spiraltrunk.design.schema import TABLES, describe, find_key, format_value, parse_decimal, read_value, spell
from spiraltrunk.design.spiral import Spiral
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, Words
from spiraltrunk.files.atomic import write_file

SCHEMA = 1
"""Version of the format."""

_MAX_BYTES = 1_000_000
_MAX_DOTS = 5_000
"""More than any design has; the parser's work grows with the square of a dotted name."""

_PARTS = tuple(table for table in TABLES if table)

_HEAD = """\
# A spiraltrunk design: what the robot is. `spiraltrunk design` writes such a file.
# Each key wears its unit. What has a default may be left out; without [gripper] there is no gripper.
"""


def load_design(path_or_preset: str | Path) -> TrunkDesign:
    """The preset of that name, else the design in that TOML file.

    An arm model that is a relative path starts at the file's folder and comes out absolute.

    Raises:
        DesignError: for a file that cannot be read, is not TOML, or says what no trunk can be; it names the key.
    """
    check_type("design", path_or_preset, (str, Path))
    if path_or_preset in presets.NAMES:
        return presets.get(str(path_or_preset))
    path = Path(path_or_preset)
    design = _build_design(_parse(path, _read(path)))
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
        if target.exists() and not target.is_file():
            raise ValueError("this is a folder" if target.is_dir() else "this is no regular file")
        write_file(target, text.encode())
    return target


def format_design(design: TrunkDesign, notes: Sequence[str] = ()) -> str:
    """The design as the text of a TOML file, with lines of comment at its head."""
    check_type("design", design, TrunkDesign)
    said = "".join(f"# {_on_one_line(note)}\n" for note in notes)
    text = f"{_HEAD}{said}schema = {SCHEMA}\n"
    for table, keys in TABLES.items():
        part = getattr(design, table) if table else design
        if part is None:
            continue
        text += f"\n[{table}]\n" if table else ""
        for key in keys:
            value = getattr(design if key.owner is TrunkDesign else part, key.field)
            text += "" if value is None else f"{key.name} = {format_value(value, key)}\n"
    return text


def _on_one_line(note: str) -> str:
    """A note that cannot end its comment."""
    return "".join(letter if letter.isprintable() else " " for letter in note)


def _read(path: Path) -> str:
    """Text of a regular file of sensible size: a pipe or a device would block or never end."""
    with _as_design_error("design", path, f"a preset ({', '.join(presets.NAMES)}) or a .toml file"):
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            raise ValueError("this is a folder" if stat.S_ISDIR(status.st_mode) else "this is no regular file")
        with path.open("rb") as file:
            data = file.read(_MAX_BYTES + 1) if status.st_size <= _MAX_BYTES else None
        if data is None or len(data) > _MAX_BYTES:
            raise ValueError(f"this one has more than {_MAX_BYTES} bytes")
        return data.decode("utf-8-sig")


def _parse(path: Path, text: str) -> dict[str, Any]:
    with _as_design_error("design", path, "a file of valid TOML"):
        if text.count(".") > _MAX_DOTS:
            raise ValueError(f"this one has more than {_MAX_DOTS} dots")
        try:
            return tomllib.loads(text, parse_float=parse_decimal)
        except RecursionError:
            raise ValueError("this one has arrays or tables nested too deep") from None
        except tomllib.TOMLDecodeError:
            raise
        except ValueError:  # Python turns no whole number of thousands of digits into an int.
            raise ValueError(
                f"this one has a whole number of more than {sys.get_int_max_str_digits()} digits"
            ) from None


def _build_design(document: dict[str, Any]) -> TrunkDesign:
    try:
        return _assemble(document)
    except DesignError as error:
        raise _as_typed(error, document) from None


def _as_typed(error: DesignError, document: dict[str, Any]) -> DesignError:
    """What a design says about a field in SI, in the words, the unit and the value of the file."""
    field, bracket, rest = error.name.partition("[")
    found = find_key(field)
    if found is None:
        return error
    table, key = found
    typed = (document.get(table, {}) if table else document).get(key.name)
    index = rest.rstrip("]")
    if isinstance(typed, list) and index.isdecimal():
        typed = typed[int(index)]
    return spell(error, f"{_dotted(table, key.name)}{bracket}{rest}", key.unit, describe(typed))


def _assemble(document: dict[str, Any]) -> TrunkDesign:
    schema = document.pop("schema", SCHEMA)
    if type(schema) is not int or schema != SCHEMA:
        raise DesignError("schema", got=describe(schema), allowed=str(SCHEMA))
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
        raise DesignError(table, got=describe(content), allowed=f"a table with the keys {known}")
    for name in content:
        if name not in keys:
            raise DesignError(_dotted(table, name), got=describe(content[name]), allowed=f"only the keys {known}")
    values: dict[type, dict[str, Any]] = {}
    for name, key in keys.items():
        if name in content:
            values.setdefault(key.owner, {})[key.field] = read_value(_dotted(table, name), content[name], key)
        elif key.is_required:
            raise DesignError(_dotted(table, name), got=Words("missing"), allowed=key.kind.value)
    return values


def _dotted(table: str, name: str) -> str:
    """Name of a key as the file would say it, on one line whatever was written."""
    shown = name if name.isprintable() and 0 < len(name) <= 60 else ascii(name)[:60]
    return f"{table}.{shown}" if table else shown


@contextmanager
def _as_design_error(name: str, path: Path, allowed: str) -> Iterator[None]:
    """Turn what the system, the decoder or the parser says about a file into one line."""
    try:
        yield
    except (OSError, ValueError, RecursionError) as error:
        reason = " ".join(str(getattr(error, "strerror", None) or error).split())[:200]
        raise DesignError(name, got=str(path), allowed=f"{allowed}; {reason}") from error
