"""The robot and its object in the scene of a page or of a replay."""

from __future__ import annotations

import math
from typing import Any, final

import numpy as np
from viser import SceneApi

from spiraltrunk.sim.body_meshes import ModelMeshes
from spiraltrunk.workflows.grasp.recording import Frames

Color = tuple[int, int, int]

STRING_COLOR = (90, 90, 90)

CAMERA = (2.42, -1.05, 1.50)
"""Place of the camera at first [m]: as far and from where the pictures of trials are taken."""

LOOK_AT = (0.26, 0.18, 1.02)
"""Point that it looks at [m]."""

FIELD = math.radians(36.0)
"""Its vertical field of view [rad]."""

FLOOR_LEAST = 180
"""Least channel of the colour of a floor, which is lighter than all else that is fixed in the world."""

FLOOR_SHARE = 0.3
"""Share of its brightness that a floor has on dark ground [-] (ours)."""

MOVED = 1e-5
"""Least change of a pose that is sent: of a position [m], and of a quaternion [-]."""


@final
class StageView:
    """Nodes of the bodies below one root, one for each body and colour, and the strings of a hung object."""

    def __init__(self, scene: SceneApi, root: str, *, is_dark: bool = False) -> None:
        """No bodies yet.

        Args:
            scene: where they are drawn.
            root: name of the node below which they are.
            is_dark: whether the ground of the page is dark.
        """
        self._scene = scene
        self._root = root
        self._is_dark = is_dark
        self._bodies: dict[int, Any] = {}
        self._floors: list[tuple[Any, Color]] = []
        self._strings: Any = None
        self._parent: Any = None
        self._shown = np.zeros((0, 7))
        self._ends = np.zeros(0)

    def draw(self, meshes: ModelMeshes, frames: Frames) -> None:
        """Put the bodies of a model into the scene, in place of the former ones, at the first of ``frames``."""
        self.clear()
        self._parent = self._scene.add_frame(self._root, show_axes=False)
        for i, mesh in enumerate(meshes.meshes):
            first = self._bodies.get(mesh.body)
            name = f"{self._root}/body_{mesh.body}" if first is None else f"{first.name}/part_{i}"
            node = self._scene.add_mesh_simple(
                name, mesh.vertices, mesh.faces.astype("uint32"), color=mesh.color, cast_shadow=mesh.body > 0
            )
            self._bodies.setdefault(mesh.body, node)
            if mesh.body == 0 and min(mesh.color) >= FLOOR_LEAST:
                self._floors.append((node, mesh.color))
        self._color_floors()
        if meshes.string_radius > 0 and frames.string.shape[1]:
            self._strings = self._scene.add_line_segments(
                f"{self._root}/strings", frames.string[0], STRING_COLOR, thickness=2 * meshes.string_radius
            )
        self._shown, self._ends = np.full((meshes.n_body, 7), np.nan), np.zeros(0)
        self.show(frames, 0)

    def show(self, frames: Frames, index: int) -> None:
        """Move everything to a frame; call it within ``atomic()``."""
        pose = frames.pose[index]
        with np.errstate(invalid="ignore"):
            stays = np.abs(pose - self._shown) <= MOVED
        for body, node in self._bodies.items():
            if not stays[body, :3].all():
                node.position = self._shown[body, :3] = pose[body, :3]
            if not stays[body, 3:].all():
                node.wxyz = self._shown[body, 3:] = pose[body, 3:]
        if self._strings is not None and not np.array_equal(frames.string[index], self._ends):
            self._strings.points = self._ends = frames.string[index]

    def set_dark(self, is_dark: bool) -> None:
        """Suit the floor to a page with dark or light ground."""
        if is_dark != self._is_dark:
            self._is_dark = is_dark
            self._color_floors()

    def _color_floors(self) -> None:
        share = FLOOR_SHARE if self._is_dark else 1.0
        for node, (red, green, blue) in self._floors:
            node.color = round(share * red), round(share * green), round(share * blue)

    def clear(self) -> None:
        """Take everything out of the scene."""
        if self._parent is not None:
            self._parent.remove()
        self._bodies, self._floors, self._strings, self._parent = {}, [], None, None
