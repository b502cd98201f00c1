"""Rendered frames of a recorded run, by any OpenGL that MuJoCo finds."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, final

import mujoco
import numpy as np

from spiraltrunk.errors import MissingPackage

SUPERSAMPLING = 2
"""Rendered pixels along each side of an output pixel: in software far cheaper than multisampling, and as smooth."""

_CHUNK = 6
"""Frames per task of a process."""

_AHEAD = 2
"""Largest number of pending tasks per process, which bounds the memory."""


@final
@dataclass(frozen=True, kw_only=True)
class View:
    """Camera and frame size."""

    lookat: tuple[float, float, float] = (0.32, 0.20, 1.11)
    """Point in the middle of the frame [m]."""
    distance: float = 1.52
    """Distance to it [m]."""
    azimuth: float = 156.0
    """Direction of view about the vertical [deg]."""
    elevation: float = -9.0
    """Direction of view over the horizontal [deg]."""
    width: int = 640
    """Width [pixels]."""
    height: int = 480
    """Height [pixels]."""
    has_shadows: bool = True
    """Whether there are shadows, which doubles the time in software."""


def render_frames(
    model: mujoco.MjModel, positions: Sequence[np.ndarray], view: View | None = None, *, workers: int = 1
) -> Iterator[np.ndarray]:
    """One frame for each vector of generalised positions, shape (height, width, 3), 0 to 255.

    Args:
        model: the model.
        positions: generalised positions, one vector for each frame.
        view: camera and size.
        workers: processes that render; if they fail, this process renders the rest.

    Raises:
        MissingPackage: where no OpenGL is found, with what to install.
    """
    view = View() if view is None else view
    done = 0
    if workers > 1 and len(positions) > _CHUNK:
        try:
            for frame in _render_parallel(model, positions, view, workers):
                yield frame
                done += 1
        except (BrokenProcessPool, OSError):
            pass  # Processes cannot start, or one was killed.
    yield from _render_serial(model, positions[done:], view)


def _render_serial(model: mujoco.MjModel, positions: Sequence[np.ndarray], view: View) -> Iterator[np.ndarray]:
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


def _render_parallel(
    model: mujoco.MjModel, positions: Sequence[np.ndarray], view: View, workers: int
) -> Iterator[np.ndarray]:
    """Frames in order, rendered by processes with an OpenGL context each."""
    chunks = deque(positions[first : first + _CHUNK] for first in range(0, len(positions), _CHUNK))
    pool = ProcessPoolExecutor(
        workers, mp_context=multiprocessing.get_context("spawn"), initializer=_share_model, initargs=(model, view)
    )
    pending: deque[Future[list[np.ndarray]]] = deque()
    try:
        with _ignore_interrupts():
            pending.append(pool.submit(_render_chunk, chunks.popleft()))
        while pending:
            while chunks and len(pending) < workers * _AHEAD:
                pending.append(pool.submit(_render_chunk, chunks.popleft()))
            yield from pending.popleft().result()
    finally:
        pool.shutdown(cancel_futures=True)


_shared: list[Any] = []
"""Model and view of a rendering process."""


def _share_model(model: mujoco.MjModel, view: View) -> None:
    _shared[:] = [model, view]


def _render_chunk(positions: Sequence[np.ndarray]) -> list[np.ndarray]:
    model, view = _shared
    return list(_render_serial(model, positions, view))


@contextmanager
def _ignore_interrupts() -> Iterator[None]:
    """Processes started within the block ignore Ctrl-C; the main process stops them."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _downsample(picture: np.ndarray) -> np.ndarray:
    """Mean over blocks of SUPERSAMPLING pixels squared."""
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
