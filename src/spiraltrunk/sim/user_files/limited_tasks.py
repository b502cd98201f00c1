"""Compile an MJCF or split a mesh into convex parts: tasks of `files.limited_process`.

It imports nothing of the package, so that its process starts as fast as what it needs.
"""

from __future__ import annotations

import io
import json
import resource


def run_compile(sent: bytes) -> bytes:
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


def run_decompose(sent: bytes) -> bytes:
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
