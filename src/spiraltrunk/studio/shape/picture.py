"""Picture of the tab: the equilibrium as a solid, the paper's model as a ghost, and the tip's handle."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, final

import numpy as np

from spiraltrunk.design import TrunkDesign
from spiraltrunk.studio.drawing.base_plate import INK, add_base, turn_base
from spiraltrunk.studio.drawing.trunk_view import (
    BODY,
    GHOST,
    UPRIGHT,
    TrunkView,
    color_by_joint,
    place_sections,
)
from spiraltrunk.studio.page.page import Page

SHUT = (160, 50, 115)
"""Colour of the halves beside a shut joint: a dark purple, as the palette's resembles `BODY` in deuteranopia."""

MISSED = (213, 94, 0)
"""Colour of the line from the tip to a place that it does not reach: vermilion of Okabe and Ito."""


@final
class ShapePicture:
    """Nodes of the tab below ``/shape``."""

    def __init__(self, page: Page, design: TrunkDesign, on_drag: Callable[[np.ndarray, bool], None]) -> None:
        """Add the nodes of a design.

        Args:
            page: the page.
            design: the trunk.
            on_drag: called in the page's thread with the place to which the tip is dragged (3,) [m], in the frame of
                `Shape`, and whether it was let go there.
        """
        self._page, self._design, self._on_drag = page, design, on_drag
        self._root = page.scene.add_frame("/shape/all", show_axes=False)
        self._solid = TrunkView(page, "/shape/all/equilibrium", design)
        self._ghost = TrunkView(page, "/shape/all/paper", design, opacity=0.45, is_data=True, size=0.97)
        self._frame = page.scene.add_frame("/shape/all/world", show_axes=False, wxyz=UPRIGHT)
        self._base = add_base(page, "/shape/all/world/base", design)
        self._add_gravity()
        size = design.length
        self._missed = page.scene.add_line_segments(
            "/shape/all/world/missed", np.zeros((1, 2, 3)), MISSED, thickness=3.0, thickness_units="screen",
            visible=False,
        )  # fmt: skip
        self._handle: Any = page.scene.add_transform_controls(
            "/shape/all/world/tip", scale=0.11 * size, disable_rotations=True, depth_test=False, line_width=3.0
        )
        self._tip = np.zeros(3)
        self._handle.on_update(lambda event: self._take(event.phase))

    def draw(self, joint_rotation: np.ndarray, is_shut: np.ndarray, theta_0: float, roll: float) -> None:
        """Draw the equilibrium by its joints' rotations (n_joint, 3, 3) and which of them are shut (n_joint,)."""
        colors = np.where(is_shut[:, None], SHUT, BODY)
        poses = place_sections(self._design, joint_rotation, theta_0, roll)
        self._solid.draw(poses, *color_by_joint(colors, BODY))
        turn_base(self._base, theta_0, roll)

    def draw_ghost(self, joint_rotation: np.ndarray | None, theta_0: float) -> None:
        """Draw the paper's model by its joints' rotations, or hide it."""
        if joint_rotation is None:
            self._ghost.hide()
            return
        colors = np.tile(GHOST, (self._design.n_section, 1))
        self._ghost.draw(place_sections(self._design, joint_rotation, theta_0), colors, colors)

    def place_handle(self, tip: np.ndarray) -> None:
        """Put the tip's handle on the tip (3,) [m]."""
        self._tip = np.asarray(tip, float)
        self._handle.position = self._tip
        self._missed.visible = False

    def mark_missed(self, tip: np.ndarray, target: np.ndarray, *, is_missed: bool) -> None:
        """Draw a line from the tip to the place that it does not reach (3,) [m], or none."""
        self._missed.points = np.array([[tip, target]])
        self._missed.visible = is_missed

    def remove(self) -> None:
        """Take all nodes out of the scene."""
        self._root.remove()

    def _take(self, phase: str) -> None:
        """Hand on the place of the handle; what is no place puts it back."""
        is_end = phase == "end"

        def act() -> None:
            given, most = np.array(self._handle.position, float), 1.5 * self._design.length
            if not np.isfinite(given).all():
                self.place_handle(self._tip)
                self._page.notice("the tip was dragged to what is no place; nothing was changed", "refusal")
                return
            away = float(np.linalg.norm(given))
            self._on_drag(given if away <= most else given * (most / away), is_end)

        self._page.later("shape tip", act)

    def _add_gravity(self) -> None:
        """An arrow of gravity beside the base."""
        size = self._design.length
        top = np.array([-0.4 * size, 0.05 * size, 0.0])
        self._page.scene.add_arrows(
            "/shape/all/world/gravity", np.array([[top, top - [0.0, 0.22 * size, 0.0]]]), INK,
            shaft_radius=0.006 * size, head_radius=0.018 * size, head_length=0.05 * size,
        )  # fmt: skip
        self._page.scene.add_label("/shape/all/world/gravity/name", "gravity", position=top)
