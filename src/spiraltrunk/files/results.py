"""What results are written in: strict JSON, the versions that made them, and how progress is reported."""

from __future__ import annotations

import json
import math
import platform
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

import spiraltrunk

Tell = Callable[[str, int, int], None]
"""Called with what is being made, how much of it is done, and how much there is."""


def format_json(value: object) -> str:
    """Strict JSON, without NaN."""
    return json.dumps(_to_json(value), indent=2, allow_nan=False)


def _versions() -> dict[str, str | None]:
    packages = {name: _version_of(name) for name in ("mujoco", "mink", "numpy")}
    return {"spiraltrunk": spiraltrunk.__version__, "python": platform.python_version(), **packages}


def _version_of(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _to_json(value: Any) -> Any:
    """The value in JSON's types; null for what is not finite."""
    if isinstance(value, dict):
        return {str(key): _to_json(part) for key, part in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_to_json(part) for part in value]
    if isinstance(value, np.generic):
        return _to_json(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def _tell_nobody(what: str, done: int, total: int) -> None:
    """Say nothing."""
