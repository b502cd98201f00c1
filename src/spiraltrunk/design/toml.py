"""Design files: one TOML file describes a robot, in keys that end in their units.

Any file gives a design or a `DesignError`; a design written and read back is equal to itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

from spiraltrunk.checks import check_type
from spiraltrunk.design import presets, schema
from spiraltrunk.design.gripper import GripperDesign
from spiraltrunk.design.rules import compactness
from spiraltrunk.design.spiral import Spiral
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError
from spiraltrunk.files.atomic import write_file
from spiraltrunk.files.text_lines import check_regular

_PARTS = tuple(table for table in schema.TABLES if table)

_SCALE = "scale"
"""Key of [gripper] by which all its other sizes are scaled; a written file states the sizes that follow."""

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
    with _as_design_error("design", path, f"a preset ({', '.join(presets.NAMES)}) or a .toml file"):
        check_regular(path)
        with path.open("rb") as file:
            data = file.read(schema.MOST_BYTES + 1)
    design = parse_design(data, path)
    if not design.arm.is_file or Path(design.arm.model).is_absolute():
        return design
    model = path.absolute().parent / design.arm.model
    return replace(design, arm=replace(design.arm, model=str(model)))


def parse_design(data: bytes, file: str | Path) -> TrunkDesign:
    """The design that the content of a TOML file describes; a relative path of an arm model stays relative.

    Args:
        data: the content.
        file: what errors call the file.

    Raises:
        DesignError: for what is not TOML, or says what no trunk can be; it names the key.
    """
    path = Path(file)
    with _as_design_error("design", path, "a file of valid TOML"):
        document = schema.parse_toml(data)
    try:
        return _assemble(document)
    except DesignError as error:
        typed = schema.as_typed(error)
        raise DesignError(typed.name, got=typed.got, allowed=typed.allowed, file=str(path)) from None


def write_design(design: TrunkDesign, path: str | Path, notes: Sequence[str] = ()) -> Path:
    """Write the design as TOML, whole or not at all, and return where.

    Args:
        design: what is written.
        path: the file.
        notes: lines of comment at its head, such as where the numbers come from; a character that is not printable,
            which TOML does not allow in a comment, is written as its code.

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
    comments = "".join(f"# {_as_comment(note)}\n" for note in notes)
    text = f"{_HEAD}{comments}schema = {schema.SCHEMA}\n"
    for table, keys in schema.TABLES.items():
        part = getattr(design, table) if table else design
        if part is None:
            continue
        text += f"\n[{table}]\n" if table else ""
        for key in keys:
            value = getattr(design if key.owner is TrunkDesign else part, key.field)
            text += f"{key.name} = {schema.format_value(value, key)}\n" if key.is_written(value) else ""
    return text


def _as_comment(note: str) -> str:
    """The note on one line, with the codes of characters that are not printable, such as those of a file's name."""
    return "".join(mark if mark.isprintable() else ascii(mark)[1:-1] for mark in " ".join(note.split()))


def _assemble(document: dict[str, Any]) -> TrunkDesign:
    top = {name: value for name, value in document.items() if name not in _PARTS}
    trunk = schema.read_table("", top, schema.TABLES[""], ["schema", *(f"[{part}]" for part in _PARTS)])
    trunk |= {"gripper": None} | schema.read_table("spiral", document.pop("spiral", {}), schema.TABLES["spiral"])
    trunk["spiral"] = Spiral(a=trunk.pop("a"), b=trunk.pop("b"))
    trunk.setdefault("k", compactness(trunk["spiral"].b))
    for table in _PARTS:
        if table in document:
            keys = schema.TABLES[table]
            content, scale = _split_scale(document[table]) if table == "gripper" else (document[table], None)
            more = [_SCALE] if table == "gripper" else []
            part = keys[0].owner(**schema.read_table(table, content, keys, more))
            trunk[table] = part if scale is None else part.enlarged(scale)
    return TrunkDesign(**trunk)


def _split_scale(content: object) -> tuple[object, float | None]:
    """A [gripper] table without its finger scale, and the scale [-], None where it has none."""
    if not isinstance(content, dict) or _SCALE not in content:
        return content, None
    rest = {name: value for name, value in content.items() if name != _SCALE}
    scale = schema.read_value(f"gripper.{_SCALE}", content[_SCALE], schema.Key(_SCALE, GripperDesign, _SCALE))
    return rest, cast(float, scale)


@contextmanager
def _as_design_error(name: str, path: Path, allowed: str) -> Iterator[None]:
    """Turn an error of the system or the parser about a file into one line."""
    try:
        yield
    except (OSError, ValueError) as error:
        reason = " ".join(str(getattr(error, "strerror", None) or error).split())[:200]
        raise DesignError(name, got=str(path), allowed=f"{allowed}; {reason}") from error
