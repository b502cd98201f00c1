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

VISIBLE_GROUPS = (0, 1, 2)
"""Groups of geoms that are drawn; the others are shapes for contact."""

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
    fovy: float = 40.0
    """Vertical field of view [deg]."""
    width: int = 640
    """Width [pixels]."""
    height: int = 480
    """Height [pixels]."""
    has_shadows: bool = True
    """Whether shadows are rendered, which doubles the time of software rendering."""


_failures: list[str] = []
"""The message of a failure for want of a context, after which MuJoCo would abort the process at the next try."""

Shot = tuple[np.ndarray, View]
"""Generalised positions and the view of one picture."""


def render_frames(
    model: mujoco.MjModel,
    positions: Sequence[np.ndarray],
    view: View | Sequence[View] | None = None,
    *,
    workers: int = 1,
) -> Iterator[np.ndarray]:
    """One picture for each vector of generalised positions, shape (height, width, 3), 0 to 255.

    Args:
        model: the model to draw.
        positions: generalised positions, one vector of shape (n_q,) for each picture.
        view: camera and size of the picture, or one for each picture, of one size.
        workers: number of processes; where they fail, this process renders the remaining pictures.

    Raises:
        MissingPackage: where no OpenGL is found; the message names what to install.
    """
    views = view if isinstance(view, Sequence) else [View() if view is None else view] * len(positions)
    shots, done = list(zip(positions, views, strict=True)), 0
    if workers > 1 and len(shots) > _CHUNK:
        try:
            for frame in _render_in_pool(model, shots, workers):
                yield frame
                done += 1
        except (RunError, OSError):
            pass  # No memory for processes, or one was killed.
    yield from _render_serially(model, shots[done:])


def _render_serially(model: mujoco.MjModel, shots: Sequence[Shot]) -> Iterator[np.ndarray]:
    if not shots:
        return
    renderer = open_renderer(model, shots[0][1])
    camera = mujoco.MjvCamera()
    option = mujoco.MjvOption()
    option.geomgroup[:] = [group in VISIBLE_GROUPS for group in range(len(option.geomgroup))]
    option.tendongroup[4] = 0
    data, fovy = mujoco.MjData(model), model.vis.global_.fovy
    try:
        for qpos, view in shots:
            renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = view.has_shadows
            model.vis.global_.fovy = view.fovy
            camera.lookat[:] = view.lookat
            camera.distance, camera.azimuth, camera.elevation = view.distance, view.azimuth, view.elevation
            data.qpos[:] = qpos
            mujoco.mj_forward(model, data)
            renderer.update_scene(data, camera, option)
            yield _downsample(renderer.render())
    finally:
        model.vis.global_.fovy = fovy
        renderer.close()


def _render_in_pool(model: mujoco.MjModel, shots: Sequence[Shot], workers: int) -> Iterator[np.ndarray]:
    """Pictures in order, rendered by processes with an OpenGL context each."""
    chunks = [shots[first : first + _CHUNK] for first in range(0, len(shots), _CHUNK)]
    rendered: dict[int, list[np.ndarray]] = {}
    with closing(run_jobs(partial(_render_chunk, model), enumerate(chunks), workers)) as outcomes:
        for i in range(len(chunks)):
            while i not in rendered:
                outcome = next(outcomes)
                rendered[outcome.job[0]] = outcome.unwrap()
            yield from rendered.pop(i)


def _render_chunk(model: mujoco.MjModel, job: tuple[int, Sequence[Shot]]) -> list[np.ndarray]:
    return list(_render_serially(model, job[1]))


def _downsample(picture: np.ndarray) -> np.ndarray:
    """Mean over squares of SUPERSAMPLING x SUPERSAMPLING pixels."""
    n, (height, width, _) = SUPERSAMPLING, picture.shape
    total = np.zeros((height // n, width // n, 3), dtype=np.uint16)
    for i in range(n * n):
        total += picture[i // n :: n, i % n :: n]
    return (total // (n * n)).astype(np.uint8)


def open_renderer(model: mujoco.MjModel, view: View, supersampling: int = SUPERSAMPLING) -> mujoco.Renderer:
    """MuJoCo's renderer for pictures of a view's size, rendered with more pixels along each side.

    Raises:
        MissingPackage: where no OpenGL is found; the message names what to install.
    """
    if _failures:
        raise MissingPackage(_failures[0])
    width, height, buffer = supersampling * view.width, supersampling * view.height, model.vis.global_
    buffer.offwidth, buffer.offheight = max(buffer.offwidth, width), max(buffer.offheight, height)
    try:
        return mujoco.Renderer(model, height=height, width=width)
    except Exception as error:
        backend = os.environ.get("MUJOCO_GL", "none set")
        reason = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
        told = (
            f"no OpenGL for pictures (MUJOCO_GL={backend}: {reason[:120]}): "
            "install libegl1 and libgl1 (Debian) and set MUJOCO_GL=egl"
        )
        if isinstance(error, mujoco.FatalError):
            _failures.append(told)
        raise MissingPackage(told) from None
