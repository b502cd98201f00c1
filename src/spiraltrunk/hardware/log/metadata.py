"""Metadata of a log: what ran, on what, from which versions."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, final

from spiraltrunk.errors import DriveError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.files.results import to_json

SCHEMA = "1"
"""Version of the channels' definitions."""

RECORD = "spiraltrunk"
"""Name of the metadata record in the file."""

END_RECORD = "spiraltrunk.end"
"""Name of the metadata record that closes a file, see `format_end`."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class LogMetadata:
    """What a log's reader must know besides its messages."""

    design: str
    """The design as the text of a trunk.toml."""
    bus: str
    """Bus, such as "virtual" or "socketcan:can0"."""
    is_twin: bool
    """Whether the devices are twins."""
    seed: int | None = None
    """Seed of the run, where it has one."""
    versions: Mapping[str, str] = field(default_factory=dict)
    """Versions of the packages, see `read_versions`."""
    provenance: str = ""
    """Who or what made the log: command line, strategy, operator."""
    task: Mapping[str, Any] | None = None
    """Target and goal of the run, see `describe_task`; None where no strategy runs."""
    wall_start: int = field(default_factory=time.time_ns)
    """Wall-clock time of the log's start since 1970 [ns]."""
    clock_origin: float = 0.0
    """Time on the driver's clock at that moment [s]; set by `LogWriter`."""


def format_end(*, is_last: bool) -> dict[str, str]:
    """Texts of the record that closes a file: whether it ends the log, or a further part follows."""
    return {"is_last": json.dumps(is_last)}


def parse_end(texts: Mapping[str, str]) -> bool | None:
    """Whether a file ends its log; None where the record does not say."""
    return {"true": True, "false": False}.get(texts.get("is_last", ""))


def format_metadata(metadata: LogMetadata) -> dict[str, str]:
    """Texts of the metadata record; each is JSON but for the design, which stays readable."""
    names = ("bus", "is_twin", "seed", "versions", "provenance", "task", "wall_start", "clock_origin")
    texts = {name: json.dumps(to_json(getattr(metadata, name))) for name in names}
    design = metadata.design.encode(errors="backslashreplace").decode()
    return {"schema": SCHEMA, "design": design} | texts


def parse_metadata(texts: Mapping[str, str]) -> LogMetadata:
    """The metadata of a record.

    Raises:
        DriveError: where an entry is missing or of another type, or the log is of another version.
    """
    if texts.get("schema") != SCHEMA:
        raise DriveError(f"schema of the log is {texts.get('schema')!r:.40}; allowed: {SCHEMA!r}")
    try:
        read = {name: json.loads(text) for name, text in texts.items() if name not in ("schema", "design")}
        metadata = LogMetadata(design=texts["design"], **read)
    except (ValueError, TypeError, KeyError, RecursionError):
        raise DriveError("metadata of the log are damaged; allowed: those that spiraltrunk writes") from None
    kinds = {"bus": str, "is_twin": bool, "seed": int | None, "versions": dict, "provenance": str, "task": dict | None,
             "wall_start": int, "clock_origin": float | int}  # fmt: skip
    for name, kind in kinds.items():
        if not isinstance(getattr(metadata, name), kind):
            raise DriveError(f"{name} of the log is no {kind}; allowed: metadata as spiraltrunk writes them")
    return metadata
