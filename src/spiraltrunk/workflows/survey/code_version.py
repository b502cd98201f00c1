"""Digest of the code and versions of the packages with which a survey's trials are run; other ones are refused."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, final

import spiraltrunk
from spiraltrunk.errors import SurveyError
from spiraltrunk.files.results import read_versions

_PARTS = (
    "checks.py", "control", "design", "model", "sim", "strategies", "workflows/grasp/choice",
    "workflows/grasp/trial.py", "workflows/grasp/verdict", "workflows/grasp/world.py",
)  # fmt: skip
"""Paths below the package's folder that a trial's outcome depends on."""


@final
@dataclass(frozen=True, kw_only=True)
class SameCode:
    """Work for other machines, which must have the same code and packages."""

    work: Callable[[Any], Any]
    """The work."""
    code: dict[str, Any]
    """What `compute_code` says where the survey was begun."""

    def __call__(self, job: Any) -> Any:
        """Do the work.

        Raises:
            SurveyError: where this machine has other code or packages.
        """
        here = compute_code()
        if here != self.code:
            differing = ", ".join(key for key in here if here[key] != self.code.get(key))
            raise SurveyError(
                f"the machine {platform.node()!r} has another spiraltrunk or other packages ({differing} differ); "
                "allowed: the same on every machine"
            )
        return self.work(job)


@cache
def compute_code() -> dict[str, Any]:
    """Versions of the packages that a trial's outcome depends on, and the digest of the code."""
    versions = read_versions("mujoco", "mink", "daqp", "numpy", "numba", "scipy", "trimesh")
    del versions["python"]  # Surveys of different Python versions are equal.
    return {"versions": versions, "source": compute_source()}


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
