"""A survey as its folder holds it, read to be merged or compared."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

from spiraltrunk.errors import SurveyError, describe_reason
from spiraltrunk.workflows.survey.resume_log import read_rows
from spiraltrunk.workflows.survey.row import Row

_EARLIER: Mapping[str, Any] = {"timestep_s": 1e-3, "shard": None, "versions": {}, "source": ""}
"""Settings that surveys of earlier versions lack, which were made with time steps of 1 ms."""

_NEEDED = {"trials": int, "seed": int, "objects": dict, "design": str}
"""Settings that every survey has, with their types."""


@final
@dataclass(frozen=True, kw_only=True)
class StoredSurvey:
    """Settings and trials of a survey's folder, complete or not."""

    folder: Path
    """Where it is."""
    settings: Mapping[str, Any]
    """What it was asked for, with versions and code."""
    rows: tuple[Row, ...]
    """Trials that have ended, in the order in which they ended."""


def load_survey(folder: str | Path, option: str) -> StoredSurvey:
    """Read a survey's folder, also of one that is running or was interrupted.

    Args:
        folder: where it is.
        option: the option of the command line that named it, for messages.

    Raises:
        SurveyError: where the folder holds no survey, or one that cannot be read.
    """
    path = Path(folder)
    allowed = "allowed: the folder of a survey, with survey.json and trials.jsonl"
    try:
        settings = {**_EARLIER, **json.loads((path / "survey.json").read_text())["settings"]}
        data = (path / "trials.jsonl").read_bytes()
        _check_settings(settings)
    except OSError as error:
        place = str(error.filename if path.is_dir() else folder)
        raise SurveyError(f"{option}: {place!r} cannot be read: {describe_reason(error)}; {allowed}") from None
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        raise SurveyError(f"{option}: {str(path / 'survey.json')!r} is no survey's; {allowed}") from None
    rows, _ = read_rows(path / "trials.jsonl", data, settings, option)
    return StoredSurvey(folder=path, settings=settings, rows=tuple(rows))


def _check_settings(settings: Mapping[str, Any]) -> None:
    """Refuse settings that no survey has.

    Raises:
        TypeError, KeyError: for a setting of another type, or that is missing.
    """
    for key, kind in _NEEDED.items():
        if type(settings[key]) is not kind:
            raise TypeError(key)
    for names in settings["objects"].values():
        if not (isinstance(names, list) and names and all(isinstance(name, str) for name in names)):
            raise TypeError("objects")
    if not isinstance(settings["shard"], (str, type(None))):
        raise TypeError("shard")
