"""Protocols as TOML: keys name their units; unknown keys are refused with a list of the known ones."""

from __future__ import annotations

import math
import tomllib
from importlib.resources import files
from pathlib import Path
from typing import Any

from spiraltrunk.errors import DesignError, TakeError
from spiraltrunk.files.text_lines import open_take
from spiraltrunk.mocap.protocol.protocol import Protocol, Run
from spiraltrunk.mocap.signal.registration import read_alignment
from spiraltrunk.mocap.signal.segmentation import StillSettings

PACKAGED = "paper"
"""Name of the protocol that comes with the package."""

_MOST_BYTES = 1_000_000
_STILL = {
    "speed_mm_s": ("speed", 1e-3),
    "window_s": ("window", 1.0),
    "hold_s": ("hold", 1.0),
    "same_mm": ("same", 1e-3),
}
_RUN = {
    "name": str, "kind": str, "tilt_deg": float, "theta0_deg": float, "steps": int, "step_mm": float,
    "first_mm": float, "takes": int, "begin_s": float, "end_s": float, "period_s": float,
}  # fmt: skip
_TOP = {
    "schema": int, "name": str, "design": str, "axes": str, "alignment": str, "orientation": str, "rotations": str,
    "base": str, "slack_mm": list, "sections": dict, "still": dict, "run": list,
}  # fmt: skip


def load_protocol(path_or_name: str | Path) -> Protocol:
    """The packaged protocol by its name, or that of a file; a design file is looked for in the same folder.

    Raises:
        TakeError: for a file that cannot be read or is no valid protocol; it names file and key.
    """
    if str(path_or_name) == PACKAGED:
        return _build(tomllib.loads(read_packaged()), "the packaged protocol", None)
    path = Path(path_or_name)
    with open_take(path) as file:
        data = file.read(_MOST_BYTES + 1)
    return parse_protocol(data, source=str(path), folder=path.parent)


def read_packaged() -> str:
    """Text of the packaged protocol."""
    return (files("spiraltrunk.mocap.protocol") / "protocol.toml").read_text(encoding="utf-8")


def parse_protocol(data: bytes, *, source: str, folder: Path | None = None) -> Protocol:
    """Parse a protocol.

    Raises:
        TakeError: names source and key.
    """
    try:
        if len(data) > _MOST_BYTES:
            raise ValueError(f"it has more than {_MOST_BYTES} bytes")
        document = tomllib.loads(data.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        reason = " ".join(str(error).split())[:200]
        raise TakeError(f"{reason}; allowed: a protocol in TOML", file=source) from None
    return _build(document, source, folder)


def _build(document: dict[str, Any], source: str, folder: Path | None) -> Protocol:
    _check_keys(document, _TOP, "", source)
    if document.get("schema", 1) != 1:
        raise TakeError(f"schema is {document['schema']!r}; allowed: 1", file=source)
    if not document.get("run"):
        raise TakeError("there is no [[run]]; allowed: at least one", file=source)
    taken = {key: document[key] for key in ("name", "axes", "orientation", "rotations", "base") if key in document}
    taken.setdefault("name", Path(source).stem)
    try:
        return Protocol(
            runs=tuple(_build_run(run, source) for run in document["run"]),
            design=_find_design(document.get("design", "paper"), folder),
            alignment=read_alignment(document.get("alignment", "run")),
            slack=tuple(_number(value, "slack_mm", source) / 1e3 for value in document.get("slack_mm", [0, 0, 0])),
            sections=_read_sections(document.get("sections", {}), source),
            still=_build_still(document.get("still", {}), source),
            **taken,
        )
    except (TakeError, DesignError) as error:
        if isinstance(error, TakeError) and error.file:
            raise
        raise TakeError(str(error), file=source) from None


def _build_run(table: object, source: str) -> Run:
    if not isinstance(table, dict):
        raise TakeError(f"run is {str(table)[:60]!r}; allowed: tables [[run]]", file=source)
    where = f"run {str(table.get('name', ''))[:60]!r}: "
    _check_keys(table, _RUN, where, source)
    for key in ("name", "kind"):
        if key not in table:
            raise TakeError(f"{where}{key} is missing; allowed: {', '.join(_RUN)}", file=source)
    if ("tilt_deg" in table) == ("theta0_deg" in table):
        allowed = "tilt_deg, from hanging, or theta0_deg, below the horizontal, one of the two"
        raise TakeError(f"{where}the base's angle is missing or there twice; allowed: {allowed}", file=source)
    theta_0 = table["theta0_deg"] if "theta0_deg" in table else 90.0 - table["tilt_deg"]
    return Run(
        name=table["name"], kind=table["kind"], theta_0=math.radians(theta_0), steps=table.get("steps", 0),
        step=table.get("step_mm", 0) / 1e3, first=table.get("first_mm", 0) / 1e3, takes=table.get("takes", 1),
        begin=table.get("begin_s"), end=table.get("end_s"), period=table.get("period_s"),
    )  # fmt: skip


def _build_still(table: dict[str, Any], source: str) -> StillSettings:
    _check_keys(table, dict.fromkeys(_STILL, float), "still.", source)
    return StillSettings(**{field: table[key] * unit for key, (field, unit) in _STILL.items() if key in table})


def _read_sections(table: dict[str, Any], source: str) -> tuple[tuple[int, str], ...]:
    for key, name in table.items():
        if not (key.isascii() and key.isdecimal() and 1 <= len(key) <= 3 and isinstance(name, str) and name):
            allowed = "numbers of sections, 1 at the base, with the names of their rigid bodies"
            raise TakeError(f"sections.{key[:40]} is {str(name)[:40]!r}; allowed: {allowed}", file=source)
    return tuple((int(key), name) for key, name in table.items())


def _check_keys(table: dict[str, Any], known: dict[str, type], where: str, source: str) -> None:
    for key, value in table.items():
        if key not in known:
            allowed = f"only {', '.join(known)}"
            raise TakeError(f"{where}{key[:60]} is no key of a protocol; allowed: {allowed}", file=source)
        kind = known[key]
        if kind is float:
            _number(value, where + key, source)
        elif not isinstance(value, kind) or isinstance(value, bool):
            word = {int: "a whole number", str: "a text", list: "a list", dict: "a table"}[kind]
            raise TakeError(f"{where}{key} is {str(value)[:60]!r}; allowed: {word}", file=source)


def _number(value: object, name: str, source: str) -> float:
    if isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e9:
        return float(value)
    raise TakeError(f"{name} is {str(value)[:60]!r}; allowed: a finite number", file=source)


def _find_design(name: str, folder: Path | None) -> str:
    """A file in the protocol's folder, or the name of a preset or file as it is."""
    beside = None if folder is None else folder / name
    return str(beside) if beside is not None and beside.is_file() else name
