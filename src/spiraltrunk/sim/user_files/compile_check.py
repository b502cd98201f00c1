"""Whether MuJoCo compiles a user's MJCF within limits, found out in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import mujoco

from spiraltrunk.sim.mujoco_log import first_line, quiet_mujoco
from spiraltrunk.sim.user_files.mjcf_document import MjcfDocument, load_mjcf_document
from spiraltrunk.sim.user_files.regular_file import refusal

SECONDS_MOST = 10
"""Longest time that a file may take to compile, start of the process included [s]."""

MEMORY_MOST = 4 << 30
"""Largest address space of the process [bytes]; MuJoCo's libraries alone take 0.3 GB."""

TRIANGLES_MOST = 2_000_000
"""Largest number of triangles of all meshes together (ours)."""

_CHILD = Path(__file__).with_name("compile_child.py")

_compiled: set[str] = set()
"""Digests of the documents that compiled."""


def load_mjcf_spec(content: bytes, path: Path, what: str) -> mujoco.MjSpec:
    """The MJCF of that content at that path, which MuJoCo compiles in `SECONDS_MOST` and `MEMORY_MOST`.

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
    # One arena: each thread's own would reserve address space.
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MALLOC_ARENA_MAX": "1"}
    environment.pop("MUJOCO_GL", None)
    command = [sys.executable, "-P", str(_CHILD), *map(str, (os.getpid(), SECONDS_MOST, MEMORY_MOST))]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment
    ) as child:
        try:
            printed, _ = child.communicate(sent, timeout=SECONDS_MOST)
        except subprocess.TimeoutExpired:
            raise refusal(document.what, "too slow to compile", f"at most {SECONDS_MOST} s") from None
        finally:
            child.kill()
    try:
        verdict: dict[str, Any] = json.loads(printed)
    except ValueError:
        limits = f"what MuJoCo compiles in {SECONDS_MOST} s and {MEMORY_MOST >> 30} GB"
        raise refusal(document.what, f"one at which MuJoCo ended with code {child.returncode}", limits) from None
    return verdict
