"""Results as strict JSON, the versions that produced them, and the progress callback of long work."""

from __future__ import annotations

import json
import math
import platform
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

import numpy as np

import spiraltrunk

Progress = Callable[[str, int, int], None]
"""Called with the name of the current step, how much of it is done, and the total."""


def ignore_progress(step: str, done: int, total: int) -> None:
    """Report nothing."""


def read_versions(*packages: str) -> dict[str, str]:
    """Versions of spiraltrunk, Python and the installed ``packages``."""
    own = {"spiraltrunk": spiraltrunk.__version__, "python": platform.python_version()}
    return own | {name: version(name) for name in packages}


def format_json(value: object) -> str:
    """Strict JSON; numbers that are not finite are null."""
    return json.dumps(to_json(value), indent=2, allow_nan=False)


def to_json(value: Any) -> Any:
    """The value in JSON's types; null for numbers that are not finite."""
    if isinstance(value, dict):
        return {str(key): to_json(part) for key, part in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [to_json(part) for part in value]
    if isinstance(value, np.generic):
        return to_json(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
