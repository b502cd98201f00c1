"""Pictures of environments and demonstrations: named cameras round the object, colour and depth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import final

import mujoco
import numpy as np

from spiraltrunk.checks import check_count
from spiraltrunk.errors import UnknownName
from spiraltrunk.sim.machine import SimMachine
from spiraltrunk.sim.render import VISIBLE_GROUPS, View, open_renderer

CAMERAS: Mapping[str, View] = {
    "front": View(distance=1.5, azimuth=156.0, elevation=-9.0),
    "side": View(distance=1.5, azimuth=90.0, elevation=-9.0),
    "top": View(distance=1.2, azimuth=90.0, elevation=-80.0),
    "close": View(distance=0.7, azimuth=156.0, elevation=-20.0),
}
"""Cameras by name; each looks at a point above the announced object."""

ABOVE = (-0.05, 0.08, 0.12)
"""That point from the announced centre of the object [m] (ours)."""

LEAST_SIDE, MOST_SIDE = 16, 1024
"""Least and largest width and height of a picture [pixels] (ours)."""


def check_cameras(cameras: tuple[str, ...], size: tuple[int, int]) -> None:
    """Refuse cameras and sizes that do not exist.

    Raises:
        UnknownName: for a camera; it lists the names.
        DesignError: for a size.
    """
    for name in cameras:
        if name not in CAMERAS:
            raise UnknownName("camera", str(name), CAMERAS)
    for name, side in zip(("height", "width"), size, strict=True):
        check_count(f"picture_size {name}", side, least=LEAST_SIDE, most=MOST_SIDE)


@final
class Photographer:
    """Takes pictures of one machine: of its present state, or of others after `pose`.

    Args:
        machine: the machine.
        size: height and width of the pictures [pixels].
        has_shadows: whether shadows are drawn, which takes four times as long in software.

    Raises:
        MissingPackage: where no OpenGL is found.
    """

    def __init__(self, machine: SimMachine, size: tuple[int, int], *, has_shadows: bool = False) -> None:
        self._data, self._model, self._is_posed = machine.data, machine.model, False
        x, y, z = (float(value) for value in machine.task.target.position + np.array(ABOVE))
        self._lookat = (x, y, z)
        self._view = View(height=size[0], width=size[1], has_shadows=has_shadows)
        self._renderer = open_renderer(machine.model, self._view, supersampling=1)
        self._renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = has_shadows
        self._camera, self._option = mujoco.MjvCamera(), mujoco.MjvOption()
        groups = range(len(self._option.geomgroup))
        self._option.geomgroup[:] = [group in VISIBLE_GROUPS for group in groups]
        self._option.tendongroup[4] = 0

    def pose(self, positions: np.ndarray) -> None:
        """Show other generalised positions than the machine's from now on, shape (n_q,) [m, rad]."""
        if not self._is_posed:
            self._data, self._is_posed = mujoco.MjData(self._model), True
        self._data.qpos[:] = positions
        mujoco.mj_fwdPosition(self._model, self._data)

    def take(self, name: str) -> np.ndarray:
        """Picture of a camera, shape (height, width, 3), uint8."""
        self._aim(name)
        return self._renderer.render().copy()

    def take_depth(self, name: str) -> np.ndarray:
        """Distance of what each pixel shows from the camera's plane, shape (height, width), float32 [m]."""
        self._renderer.enable_depth_rendering()
        try:
            self._aim(name)
            return np.asarray(self._renderer.render(), dtype=np.float32).copy()
        finally:
            self._renderer.disable_depth_rendering()

    def close(self) -> None:
        """Free the OpenGL context; a second call does nothing."""
        self._renderer.close()

    def _aim(self, name: str) -> None:
        view = replace(CAMERAS[name], lookat=self._lookat)
        camera = self._camera
        camera.lookat[:] = view.lookat
        camera.distance, camera.azimuth, camera.elevation = view.distance, view.azimuth, view.elevation
        self._renderer.update_scene(self._data, camera, self._option)
