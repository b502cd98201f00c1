"""Live picture of the twin's trunk, hanging from its base."""

from __future__ import annotations

from typing import Any, final

import numpy as np
from viser import transforms

from spiraltrunk.design import TrunkDesign
from spiraltrunk.report.solids.trunk_mesh import Surface, build_trunk_surfaces, curl_frames
from spiraltrunk.studio.page.page import Page

_HANGING = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
"""Turn from the frame of the base, x along the trunk, to the scene's, z up: the trunk hangs."""

_BODY, _OTHER = (138, 150, 164), (112, 124, 140)
"""Colours of the sections, in turn."""

_MOUNT = (70, 76, 84)


@final
class TrunkPicture:
    """Nodes of the trunk below a root, moved as a whole with each state."""

    def __init__(self, page: Page, root: str, design: TrunkDesign) -> None:
        """Add the nodes, straight."""
        self.design = design
        """The trunk."""
        self._count = design.n_section
        self.root: Any = page.scene.add_frame(
            root, show_axes=False, position=(0.0, 0.0, design.length + 0.1), wxyz=_quaternions(_HANGING[None])[0]
        )
        frames = curl_frames(design, 0.0)
        surfaces = build_trunk_surfaces(design, frames)
        page.scene.add_mesh_simple(
            f"{root}/mount", surfaces.mount.vertices, surfaces.mount.faces, color=_MOUNT, flat_shading=True
        )
        section = _take_first(surfaces.sections[0], (self._count + 1) // 2)
        colors = np.array([_BODY if n % 2 == 0 else _OTHER for n in range(self._count)], np.uint8)
        self._sections: Any = page.scene.add_batched_meshes_simple(
            f"{root}/sections", section.vertices / design.scale[0], section.faces, _quaternions(frames[:, :3, :3]),
            frames[:, :3, 3], batched_scales=design.scale, batched_colors=colors, flat_shading=True, lod="off",
        )  # fmt: skip

    def draw(self, frames: np.ndarray) -> None:
        """Move the sections to their frames, shape (n_section, 4, 4) [-, m]."""
        if len(frames) == self._count:
            self._sections.batched_positions = frames[:, :3, 3]
            self._sections.batched_wxyzs = _quaternions(frames[:, :3, :3])

    def remove(self) -> None:
        """Take it out of the scene."""
        self.root.remove()


def _take_first(copies: Surface, count: int) -> Surface:
    """The first of several copies of a part; its frame is the base's."""
    n_vertex, n_face = len(copies.vertices) // count, len(copies.faces) // count
    return Surface(copies.vertices[:n_vertex], copies.faces[:n_face])


def _quaternions(rotations: np.ndarray) -> np.ndarray:
    return np.asarray(transforms.SO3.from_matrix(rotations).wxyz)
