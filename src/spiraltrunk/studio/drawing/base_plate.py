"""The base of a trunk: a plate across the base axis, and the axis behind it."""

from __future__ import annotations

from typing import Any

import numpy as np
from viser import transforms

from spiraltrunk.design import TrunkDesign
from spiraltrunk.model.kinematics.frames import base_orientation
from spiraltrunk.studio.page.page import Page

INK = (120, 120, 120)
"""Colour of what belongs to the world, seen on light and dark ground."""


def add_base(page: Page, name: str, design: TrunkDesign) -> Any:
    """Add the base below a node in the frame of `Shape`, and return its node."""
    wide, size = 1.15 * design.solid.radius, design.length
    frame = page.scene.add_frame(name, show_axes=False)
    page.scene.add_cylinder(
        f"{name}/plate", radius=wide, height=0.02 * size, color=INK,
        wxyz=(float(np.sqrt(0.5)), 0.0, float(np.sqrt(0.5)), 0.0), position=(-0.01 * size, 0.0, 0.0),
    )  # fmt: skip
    page.scene.add_line_segments(
        f"{name}/axis", np.array([[[-0.12 * size, 0.0, 0.0], [0.0, 0.0, 0.0]]]), INK, thickness=2.0,
        thickness_units="screen",
    )  # fmt: skip
    return frame


def turn_base(node: Any, theta_0: float, roll: float = 0.0) -> None:
    """Turn the base to a pose [rad]."""
    node.wxyz = transforms.SO3.from_matrix(base_orientation(float(theta_0), float(roll))).wxyz
