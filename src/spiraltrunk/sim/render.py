"""Rendering of recorded states with MuJoCo's OpenGL renderer."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from typing import final

import mujoco
import numpy as np

from spiraltrunk.errors import MissingPackage, RunError
from spiraltrunk.processes.pool import run_jobs

SUPERSAMPLING = 2
"""Pixels rendered along each side of an output pixel; in software rendering faster than multisampling."""

_CHUNK = 6
"""Frames that a process renders per task."""


@final
@dataclass(frozen=True, kw_only=True)
class View:
    """Pose of the camera and size of its picture."""

    lookat: tuple[float, float, float] = (0.32, 0.20, 1.11)
    """Point in the middle of the picture, shape (3,) [m]."""
    distance: float = 1.52
    """Distance of the camera from that point [m]."""
    azimuth: float = 156.0
    """Direction of view about the vertical [deg]."""
    elevation: float = -9.0
    """Elevation of the direction of view [deg]."""
    width: int = 640
    """Width [pixels]."""
    height: int = 480
    """Height [pixels]."""
    has_shadows: bool = True
    """Whether shadows are rendered, which doubles the time of software rendering."""


def render_frames(
    model: mujoco.MjModel, positions: Sequence[np.ndarray], view: View | None = None, *, workers: int = 1
) -> Iterator[np.ndarray]:
    """One picture for each vector of generalised positions, shape (height, width, 3), 0 to 255.

    Args:
        model: the model to draw.
        positions: generalised positions, one vector of shape (n_q,) for each picture.
        view: camera and size of the picture.
        workers: number of processes; where they fail, this process renders the remaining pictures.

    Raises:
        MissingPackage: where no OpenGL is found; the message names what to install.
    """
    view = View() if view is None else view
    done = 0
    if workers > 1 and len(positions) > _CHUNK:
        try:
            for frame in _render_in_pool(model, positions, view, workers):
                yield frame
                done += 1
        except (RunError, OSError):
            pass  # No memory for processes, or one was killed.
    yield from _render_serially(model, positions[done:], view)


def _render_serially(model: mujoco.MjModel, positions: Sequence[np.ndarray], view: View) -> Iterator[np.ndarray]:
    if not len(positions):
        return
    renderer = _open_renderer(model, view)
    renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = view.has_shadows
    camera = mujoco.MjvCamera()
    camera.lookat[:] = view.lookat
    camera.distance, camera.azimuth, camera.elevation = view.distance, view.azimuth, view.elevation
    option = mujoco.MjvOption()
    option.geomgroup[:] = [1, 1, 1, 0, 0, 0]
    option.tendongroup[4] = 0
    data = mujoco.MjData(model)
    try:
        for qpos in positions:
            data.qpos[:] = qpos
            mujoco.mj_forward(model, data)
            renderer.update_scene(data, camera, option)
            yield _downsample(renderer.render())
    finally:
        renderer.close()


def _render_in_pool(
    model: mujoco.MjModel, positions: Sequence[np.ndarray], view: View, workers: int
) -> Iterator[np.ndarray]:
    """Pictures in order, rendered by processes with an OpenGL context each."""
    chunks = [positions[first : first + _CHUNK] for first in range(0, len(positions), _CHUNK)]
    rendered: dict[int, list[np.ndarray]] = {}
    with closing(run_jobs(partial(_render_chunk, model, view), enumerate(chunks), workers)) as outcomes:
        for i in range(len(chunks)):
            while i not in rendered:
                outcome = next(outcomes)
                rendered[outcome.job[0]] = outcome.unwrap()
            yield from rendered.pop(i)


def _render_chunk(model: mujoco.MjModel, view: View, job: tuple[int, Sequence[np.ndarray]]) -> list[np.ndarray]:
    return list(_render_serially(model, job[1], view))


def _downsample(picture: np.ndarray) -> np.ndarray:
    """Mean over squares of SUPERSAMPLING x SUPERSAMPLING pixels."""
    n, (height, width, _) = SUPERSAMPLING, picture.shape
    total = np.zeros((height // n, width // n, 3), dtype=np.uint16)
    for i in range(n * n):
        total += picture[i // n :: n, i % n :: n]
    return (total // (n * n)).astype(np.uint8)


def _open_renderer(model: mujoco.MjModel, view: View) -> mujoco.Renderer:
    try:
        return mujoco.Renderer(model, height=SUPERSAMPLING * view.height, width=SUPERSAMPLING * view.width)
    except Exception as error:
        backend = os.environ.get("MUJOCO_GL", "none set")
        reason = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
        raise MissingPackage(
            f"no OpenGL for pictures (MUJOCO_GL={backend}: {reason[:120]}): "
            "install libegl1 and libgl1 (Debian) and set MUJOCO_GL=egl"
        ) from None
