"""A trunk in the scene: its sections in two batches of halves, and its cables as lines."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, final

import numpy as np
from viser import transforms

from spiraltrunk.design import TrunkDesign
from spiraltrunk.model.kinematics.frames import base_orientation, section_frames
from spiraltrunk.report.style import COLORS
from spiraltrunk.studio.drawing.half_sections import build_halves
from spiraltrunk.studio.page.page import Page

BODY = (170, 182, 196)
"""Colour of a section."""

GHOST = (230, 159, 0)
"""Colour of a second trunk behind the first: orange of Okabe and Ito."""

_SOLID, _DATA = 0.7, 1.0
"""Part of a colour that is kept: viser's lamps and its surroundings brighten a shiny surface [-]."""

HANGING = math.pi / 2
"""Angle of the axis of a base below the horizontal from which the trunk hangs [rad]."""

UPRIGHT = (float(np.sqrt(0.5)), float(np.sqrt(0.5)), 0.0, 0.0)
"""Turn from the frame of `Shape`, whose y is up, to the scene's, whose z is up."""


@final
@dataclass(frozen=True, kw_only=True)
class Poses:
    """Poses of the sections in the frame of `Shape`."""

    position: np.ndarray
    """Proximal joint centres, shape (n_section, 3) [m]."""
    rotation: np.ndarray
    """Axes, shape (n_section, 3, 3) [-]."""


def place_sections(design: TrunkDesign, joint_rotation: np.ndarray, theta_0: float, roll: float = 0.0) -> Poses:
    """Poses of all sections by the rotations of the joints and the base's pose [rad]."""
    return place_frames(section_frames(design, joint_rotation), theta_0, roll)


def place_frames(frames: np.ndarray, theta_0: float, roll: float = 0.0) -> Poses:
    """Poses of all sections by their frames in that of the base, shape (n_section, 4, 4), and its pose [rad]."""
    base = base_orientation(float(theta_0), float(roll))
    return Poses(position=frames[:, :3, 3] @ base.T, rotation=base @ frames[:, :3, :3])


def place_straight(design: TrunkDesign) -> Poses:
    """Poses of all sections of the straight trunk that hangs from its base."""
    return place_sections(design, np.tile(np.eye(3), (design.n_joint, 1, 1)), HANGING)


@final
class TrunkView:
    """Nodes of one trunk below a root node in the frame of `Shape`."""

    def __init__(
        self,
        page: Page,
        root: str,
        design: TrunkDesign,
        *,
        opacity: float | None = None,
        is_data: bool = False,
        size: float = 1.0,
    ) -> None:
        """Add the nodes, invisible until they are drawn.

        Args:
            page: the page.
            root: name of the root node, which is added.
            design: the trunk.
            opacity: opacity of the sections; None is solid.
            is_data: whether colours are data, drawn without highlights and without cables.
            size: size of the sections; a little below 1, they hide within those of a trunk of the same shape [-].
        """
        self._page = page
        self._design = design
        count = design.n_section
        self.root = page.scene.add_frame(root, show_axes=False, wxyz=UPRIGHT, visible=False)
        wxyz, position = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)), np.zeros((count, 3))
        self._halves: list[Any] = [
            page.scene.add_batched_meshes_simple(
                f"{root}/{name}", points, faces, wxyz, position, batched_scales=size * design.scale,
                batched_colors=np.tile(np.array(BODY, np.uint8), (count, 1)), lod="off", opacity=opacity, side="front",
                cast_shadow=opacity is None, receive_shadow=False, material="toon5" if is_data else "standard",
            )
            for name, (points, faces) in zip(("proximal", "distal"), build_halves(design.solid), strict=True)
        ]  # fmt: skip
        self._cables: Any = None
        self._light = _DATA if is_data else _SOLID
        if not is_data:
            segments = np.zeros((design.n_cable * (2 * count - 1), 2, 3))
            each = [linear_color(parse_color(COLORS[cable % len(COLORS)])) for cable in range(design.n_cable)]
            colors = np.repeat(each, 2 * count - 1, axis=0)
            self._cables = page.scene.add_line_segments(
                f"{root}/cables",
                segments,
                np.repeat(colors[:, None], 2, axis=1).astype(np.uint8),
                thickness=2.5,
                thickness_units="screen",
            )

    def draw(self, poses: Poses, proximal: np.ndarray, distal: np.ndarray) -> None:
        """Move the sections, and colour their halves, shapes (n_section, 3), 0 to 255."""
        wxyz = transforms.SO3.from_matrix(poses.rotation).wxyz
        for node, colors in zip(self._halves, (proximal, distal), strict=True):
            node.batched_positions, node.batched_wxyzs = poses.position, wxyz
            node.batched_colors = to_linear(colors, self._light)
        if self._cables is not None:
            self._cables.points = self._compute_cables(poses)
        self.root.visible = True

    def draw_straight(self) -> None:
        """Show the trunk straight below its base, in one colour."""
        colors = np.tile(BODY, (self._design.n_section, 1))
        self.draw(place_straight(self._design), colors, colors)

    def hide(self) -> None:
        """Make it invisible until it is drawn again."""
        self.root.visible = False

    def remove(self) -> None:
        """Take its nodes out of the scene."""
        self.root.remove()

    def _compute_cables(self, poses: Poses) -> np.ndarray:
        """Segments of the cables from hole to hole, shape (n_cable (2 n_section - 1), 2, 3) [m]."""
        design = self._design
        axial, ring = design.hole_position[..., 0], design.hole_position[..., 1]
        local = axial[..., None, None] * np.array([1.0, 0.0, 0.0]) + ring[..., None, None] * design.cable_direction
        holes = np.einsum("nij,nhcj->nhci", poses.rotation, local) + poses.position[:, None, None]
        lines = np.moveaxis(holes, 2, 0).reshape(design.n_cable, -1, 3)
        return np.stack([lines[:, :-1], lines[:, 1:]], axis=2).reshape(-1, 2, 3)


def parse_color(text: str) -> tuple[int, int, int]:
    """Red, green and blue, 0 to 255, of a colour such as #0072B2."""
    return int(text[1:3], 16), int(text[3:5], 16), int(text[5:7], 16)


def linear_color(color: tuple[int, int, int]) -> tuple[int, int, int]:
    """Colour of a batch of meshes, or of each line of several, as which the page shows ``color``.

    One colour for all lines is shown as it is given.
    """
    red, green, blue = to_linear(np.array(color)).tolist()
    return red, green, blue


def to_linear(colors: np.ndarray, light: float = 1.0) -> np.ndarray:
    """Linear light of sRGB colours, 0 to 255: the page takes colours of several lines and of batches as such.

    Args:
        colors: sRGB, 0 to 255.
        light: part of it that is kept where the page's lamps brighten it [-].
    """
    return np.round(255 * light * (np.asarray(colors) / 255) ** 2.2).astype(np.uint8)


def color_by_joint(colors: np.ndarray, body: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Colours of the proximal and the distal halves by those of the joints, shape (n_joint, 3)."""
    plain = np.array([body])
    return np.concatenate([plain, colors]), np.concatenate([colors, plain])
