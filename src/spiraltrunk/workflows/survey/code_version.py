"""Digest of the code that a survey's trials were run with."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

import spiraltrunk

_PARTS = (
    "checks.py", "control", "design", "model", "sim", "strategies", "workflows/grasp/choice",
    "workflows/grasp/trial.py", "workflows/grasp/verdict", "workflows/grasp/world.py",
)  # fmt: skip
"""Paths below the package's folder that a trial's outcome depends on."""


@cache
def compute_source() -> str:
    """A short digest of all code that a trial's outcome depends on, computed at the first call."""
    root = Path(spiraltrunk.__file__).parent
    files = sorted(path for part in _PARTS for path in _list_files(root / part))
    digest = hashlib.sha256()
    for path in files:
        digest.update(str(path.relative_to(root)).encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def _list_files(path: Path) -> list[Path]:
    """Source files below a path.

    Raises:
        FileNotFoundError: where there are none, which would silently leave code out of the digest.
    """
    files = [path] if path.is_file() else list(path.rglob("*.py"))
    if not files:
        raise FileNotFoundError(f"{path} holds no source file, but a trial's outcome depends on it")
    return files
