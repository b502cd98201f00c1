"""Pictures of a recorded run: frames, by any OpenGL that MuJoCo finds."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import final

import mujoco
import numpy as np

from spiraltrunk.errors import MissingPackage


@final
@dataclass(frozen=True, kw_only=True)
class View:
    """Where the camera stands and how large its picture is."""

    lookat: tuple[float, float, float] = (0.42, 0.08, 0.98)
    """Point in the middle of the picture [m]."""
    distance: float = 1.75
    """Distance to it [m]."""
    azimuth: float = 128.0
    """Direction of view about the vertical [deg]."""
    elevation: float = -10.0
    """Direction of view over the horizontal [deg]."""
    width: int = 640
    """Width [pixels]."""
    height: int = 480
    """Height [pixels]."""


def render_frames(
    model: mujoco.MjModel, positions: Sequence[np.ndarray], view: View | None = None
) -> Iterator[np.ndarray]:
    """One picture for each vector of generalised positions, shape (height, width, 3), 0 to 255.

    Raises:
        MissingPackage: where no OpenGL is found; the message names what to install.
    """
    view = View() if view is None else view
    renderer = _open_renderer(model, view)
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
            yield renderer.render()
    finally:
        renderer.close()


def _open_renderer(model: mujoco.MjModel, view: View) -> mujoco.Renderer:
    try:
        return mujoco.Renderer(model, height=view.height, width=view.width)
    except Exception as error:
        backend = os.environ.get("MUJOCO_GL", "none set")
        reason = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
        raise MissingPackage(
            f"no OpenGL for pictures (MUJOCO_GL={backend}: {reason}): install libegl1 and libgl1 (Debian) and set MUJOCO_GL=egl"
        ) from None
