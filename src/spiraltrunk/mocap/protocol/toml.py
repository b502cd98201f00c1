"""Protocols as TOML: keys name their units; unknown keys are refused with a list of the known ones."""

from __future__ import annotations

import math
import re
from importlib.resources import files
from pathlib import Path
from typing import Any

from spiraltrunk.design.schema import DEGREE, MILLI, MOST_BYTES, Key, Kind, parse_toml, read_table
from spiraltrunk.errors import DesignError, TakeError
from spiraltrunk.files.text_lines import open_take
from spiraltrunk.mocap.protocol.protocol import Protocol, Run
from spiraltrunk.mocap.signal.registration import read_alignment
from spiraltrunk.mocap.signal.segmentation import StillSettings

PACKAGED = "paper"
"""Name of the protocol that comes with the package."""

_TEXTS = ("design", "axes", "alignment", "orientation", "rotations", "base")
_TOP = (
    Key("name", Protocol, "name", kind=Kind.TEXT, follows_rule=True),
    *(Key(name, Protocol, name, kind=Kind.TEXT) for name in _TEXTS),
    Key("slack_mm", Protocol, "slack", MILLI, Kind.NUMBERS),
)
_STILL = (
    Key("speed_mm_s", StillSettings, "speed", MILLI),
    Key("window_s", StillSettings, "window"),
    Key("hold_s", StillSettings, "hold"),
    Key("same_mm", StillSettings, "same", MILLI),
)
_RUN = (
    Key("name", Run, "name", kind=Kind.TEXT),
    Key("kind", Run, "kind", kind=Kind.TEXT),
    Key("steps", Run, "steps", kind=Kind.COUNT),
    Key("step_mm", Run, "step", MILLI),
    Key("first_mm", Run, "first", MILLI),
    Key("takes", Run, "takes", kind=Kind.COUNT),
    Key("begin_s", Run, "begin"),
    Key("end_s", Run, "end"),
    Key("period_s", Run, "period"),
)


def load_protocol(path_or_name: str | Path) -> Protocol:
    """The packaged protocol by its name, or that of a file; a design file is looked for in the same folder.

    Raises:
        TakeError: for a file that cannot be read or is no valid protocol; it names file and key.
    """
    if str(path_or_name) == PACKAGED:
        return parse_protocol(read_packaged().encode(), source="the packaged protocol")
    path = Path(path_or_name)
    with open_take(path, f"{PACKAGED}, or a protocol in TOML") as file:
        data = file.read(MOST_BYTES + 1)
    return parse_protocol(data, source=str(path), folder=path.parent)


def read_packaged() -> str:
    """Text of the packaged protocol."""
    return (files("spiraltrunk.mocap.protocol") / "protocol.toml").read_text(encoding="utf-8")


def parse_protocol(data: bytes, *, source: str, folder: Path | None = None) -> Protocol:
    """`load_protocol` from bytes, which errors call ``source``."""
    try:
        document = parse_toml(data)
    except ValueError as error:
        raise TakeError(f"{error}; allowed: a protocol in TOML", file=source) from None
    try:
        return _build(document, Path(source).stem, folder)
    except (TakeError, DesignError) as error:
        raise TakeError(str(error), file=source) from None


def _build(document: dict[str, Any], name: str, folder: Path | None) -> Protocol:
    tables = {
        "runs": _build_runs(document.pop("run", None)),
        "sections": _read_sections(document.pop("sections", {})),
        "still": StillSettings(**read_table("still", document.pop("still", {}), _STILL)),
    }
    taken = read_table("", document, _TOP, ["schema", "[sections]", "[still]", "[[run]]"])
    if "design" in taken and folder is not None and (folder / taken["design"]).is_file():
        taken["design"] = str(folder / taken["design"])
    if "alignment" in taken:
        taken["alignment"] = read_alignment(taken["alignment"])
    return Protocol(**{"name": name, **taken, **tables})


def _build_runs(tables: object) -> tuple[Run, ...]:
    if not (isinstance(tables, list) and tables and all(isinstance(table, dict) for table in tables)):
        raise TakeError("there is no [[run]]; allowed: at least one")
    return tuple(map(_build_run, tables))


def _build_run(table: dict[str, Any]) -> Run:
    what = f"run {str(table.get('name', ''))[:60]!r}"
    if ("tilt_deg" in table) == ("theta0_deg" in table):
        allowed = "tilt_deg, from hanging, or theta0_deg, below the horizontal, one of the two"
        raise TakeError(f"{what}: the base's angle is missing or there twice; allowed: {allowed}")
    angle = "tilt_deg" if "tilt_deg" in table else "theta0_deg"
    values = read_table(what, table, (*_RUN, Key(angle, Run, "theta_0", DEGREE)))
    if angle == "tilt_deg":
        values["theta_0"] = math.pi / 2 - values["theta_0"]
    return Run(**values)


def _read_sections(table: object) -> tuple[tuple[int, str], ...]:
    if not isinstance(table, dict):
        raise TakeError(f"sections is {str(table)[:40]!r}; allowed: a table")
    for key, name in table.items():
        if not (re.fullmatch("[1-9][0-9]{0,2}", key) and isinstance(name, str) and name):
            allowed = "numbers of sections, 1 at the base, without leading zeros, with the names of their rigid bodies"
            raise TakeError(f"sections.{key[:40]} is {str(name)[:40]!r}; allowed: {allowed}")
    return tuple((int(key), name) for key, name in table.items())
