"""Compile an MJCF or split a mesh into convex parts, within limits of time and memory.

A script for a process of its own: ``python -P limited_child.py TASK PARENT SECONDS BYTES``. It imports nothing of the
package, so that it starts as fast as what it needs. `limited_process` speaks with it over standard input and output.
"""

from __future__ import annotations

import ctypes
import io
import json
import os
import resource
import signal
import sys

_PR_SET_PDEATHSIG = 1


def main() -> None:
    """Limit this process, do the task, and write its result."""
    task = {"compile": _compile, "decompose": _decompose}[sys.argv[1]]
    parent, seconds, memory = map(int, sys.argv[2:])
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # The parent ends this process.
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        return
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with os.fdopen(os.dup(1), "wb") as output:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # What libraries print is no result.
        output.write(task(sys.stdin.buffer.read()))


def _compile(sent: bytes) -> bytes:
    """Verdict on a document as a line of JSON.

    Args:
        sent: a line of JSON with the lengths of the document and of each named file, and then their bytes.
    """
    import mujoco

    stream = io.BytesIO(sent)
    lengths = json.loads(stream.readline())
    text = stream.read(lengths["text"]).decode()
    assets = {name: stream.read(length) for name, length in lengths["assets"]}
    mujoco.set_mju_user_warning(lambda _: None)
    resource.setrlimit(resource.RLIMIT_NOFILE, (0, 0))  # MuJoCo has all in memory: it opens nothing from here on.
    verdict: dict[str, object]
    try:
        model = mujoco.MjSpec.from_string(text, assets=assets).compile()
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        verdict = {"triangles": int(model.nmeshface), "is_finite": _is_finite(model, data)}
    except MemoryError:
        verdict = {"error": "could not allocate memory"}
    except (ValueError, mujoco.FatalError) as error:
        verdict = {"error": str(error)}
    return json.dumps(verdict).encode()


def _is_finite(model: object, data: object) -> bool:
    """Whether vertices, poses and inertias are."""
    import numpy as np

    names = ("mesh_vert", "body_mass", "body_inertia", "body_ipos", "body_pos", "geom_size")
    arrays = [getattr(model, name) for name in names] + [data.xpos, data.xipos, data.geom_xpos]  # type: ignore[attr-defined]
    return all(bool(np.isfinite(array).all()) for array in arrays)


def _decompose(sent: bytes) -> bytes:
    """Vertices and triangles of each convex part, one array after the other.

    Args:
        sent: the vertices, the triangles, and a third array: concavity and largest number of parts.
    """
    import coacd
    import numpy as np

    stream = io.BytesIO(sent)
    vertices, faces, (concavity, most) = (np.load(stream) for _ in range(3))
    coacd.set_log_level("error")
    parts = coacd.run_coacd(coacd.Mesh(vertices, faces), threshold=float(concavity), max_convex_hull=int(most), seed=0)
    output = io.BytesIO()
    for part in parts:
        for array in part:
            np.save(output, np.asarray(array))
    return output.getvalue()


if __name__ == "__main__":
    main()
