"""Compile an MJCF within limits of time and memory, and say what came of it.

A script for a process of its own: ``python -P compile_child.py PARENT SECONDS BYTES``. It imports nothing of the
package, so that it starts as fast as MuJoCo. Standard input holds one line of JSON, the lengths of the document and of
each named file, and then their bytes. Standard output gets one line of JSON.
"""

from __future__ import annotations

import ctypes
import json
import os
import resource
import signal
import sys

_PR_SET_PDEATHSIG = 1


def main() -> None:
    """Limit this process, compile, and print the verdict."""
    parent, seconds, memory = map(int, sys.argv[1:])
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # The parent ends this process.
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        return
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    print(json.dumps(_compile()))


def _compile() -> dict[str, object]:
    import mujoco

    lengths = json.loads(sys.stdin.buffer.readline())
    text = sys.stdin.buffer.read(lengths["text"]).decode()
    assets = {name: sys.stdin.buffer.read(length) for name, length in lengths["assets"]}
    mujoco.set_mju_user_warning(lambda _: None)
    resource.setrlimit(resource.RLIMIT_NOFILE, (0, 0))  # MuJoCo has all in memory: it opens nothing from here on.
    try:
        model = mujoco.MjSpec.from_string(text, assets=assets).compile()
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
    except MemoryError:
        return {"error": "could not allocate memory"}
    except (ValueError, mujoco.FatalError) as error:
        return {"error": str(error)}
    return {"triangles": int(model.nmeshface), "is_finite": _is_finite(model, data)}


def _is_finite(model: object, data: object) -> bool:
    """Whether vertices, poses and inertias are."""
    import numpy as np

    names = ("mesh_vert", "body_mass", "body_inertia", "body_ipos", "body_pos", "geom_size")
    arrays = [getattr(model, name) for name in names] + [data.xpos, data.xipos, data.geom_xpos]  # type: ignore[attr-defined]
    return all(bool(np.isfinite(array).all()) for array in arrays)


if __name__ == "__main__":
    main()
