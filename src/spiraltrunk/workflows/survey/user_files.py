"""Digests of the files that trials read besides policies: objects from files, and a robot arm of the user's."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from pathlib import Path

from spiraltrunk.design.mount import ArmDesign
from spiraltrunk.sim.user_files.mjcf_document import load_mjcf_document
from spiraltrunk.sim.user_files.regular_file import read_file

_MJCF = "mjcf"

_KINDS = ("stl", "obj", _MJCF)
"""Kinds of objects that are read from a file."""


def describe_files(objects: Iterable[str], arm: ArmDesign) -> dict[str, str]:
    """SHA-256 of the content of every file that the trials read, by its path as given.

    That of an MJCF covers the files that it names.

    Args:
        objects: names of the objects, or their measures as a text.
        arm: robot arm of the design.

    Raises:
        DesignError: where a file cannot be read.
    """
    found: dict[str, str] = {}
    for text in objects:
        kind, path = _find_path(text)
        if path is not None and path not in found:
            found[path] = _compute_digest(path, kind)
    if arm.is_file:
        found[arm.model] = _compute_digest(arm.model, _MJCF)
    return found


def _find_path(text: str) -> tuple[str, str | None]:
    """Kind and path of an object; None where it is not read from a file."""
    kind, _, rest = text.partition(":")
    if kind not in _KINDS:
        return kind, None
    measures = [part.partition("=") for part in rest.split(",")]
    return kind, next((value.strip() for name, _, value in measures if name.strip() == "path"), None)


def _compute_digest(path: str, kind: str) -> str:
    content = read_file(path, f"{kind}:path")
    if kind == _MJCF:
        return load_mjcf_document(content, Path(path), f"the file {Path(path).name!r}").digest
    return hashlib.sha256(content).hexdigest()
