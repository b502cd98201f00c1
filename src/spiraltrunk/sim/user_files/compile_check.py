"""Whether MuJoCo compiles a user's MJCF within limits, found out in a process of its own."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import mujoco

from spiraltrunk.sim.mujoco_log import first_line, quiet_mujoco
from spiraltrunk.sim.user_files.limited_process import run_limited
from spiraltrunk.sim.user_files.mjcf_document import MjcfDocument, load_mjcf_document
from spiraltrunk.sim.user_files.regular_file import refusal

SECONDS_MOST = 10
"""Longest time that a file may take to compile, start of the process included [s]."""

TRIANGLES_MOST = 2_000_000
"""Largest number of triangles of all meshes together (ours)."""

_compiled: set[str] = set()
"""Digests of the documents that compiled."""


def load_mjcf_spec(content: bytes, path: Path, what: str) -> mujoco.MjSpec:
    """The MJCF of that content at that path, which MuJoCo compiles in `SECONDS_MOST` and `limited_process.MEMORY_MOST`.

    A process of its own tries it; that is ended with the call, also by Ctrl-C, and dies with its parent. The same
    content is tried once.

    Args:
        content: what the file holds.
        path: where it lies, for the files that it names.
        what: name of the file in errors.

    Raises:
        DesignError: where `load_mjcf_document` refuses it, or with MuJoCo's reason or the limit that was exceeded.
    """
    document = load_mjcf_document(content, path, what)
    if document.digest not in _compiled:
        _check_verdict(_try(document), what)
        _compiled.add(document.digest)
    with quiet_mujoco():
        return mujoco.MjSpec.from_string(document.text, assets=document.assets)


def _check_verdict(verdict: dict[str, Any], what: str) -> None:
    if "error" in verdict:
        allowed = f"what it loads; it says: {first_line(ValueError(verdict['error']))}"
        raise refusal(what, "no MJCF that MuJoCo loads", allowed)
    if verdict["triangles"] > TRIANGLES_MOST:
        raise refusal(what, f"of {verdict['triangles']} triangles", f"at most {TRIANGLES_MOST}")
    if not verdict["is_finite"]:
        raise refusal(what, "one with coordinates or inertias that are not finite", "finite numbers")


def _try(document: MjcfDocument) -> dict[str, Any]:
    """Verdict of the process."""
    text, assets = document.text.encode(), document.assets
    lengths = {"text": len(text), "assets": [(name, len(content)) for name, content in assets.items()]}
    sent = b"".join([json.dumps(lengths).encode(), b"\n", text, *assets.values()])
    verdict: dict[str, Any] = json.loads(run_limited("compile", sent, seconds=SECONDS_MOST, what=document.what))
    return verdict
