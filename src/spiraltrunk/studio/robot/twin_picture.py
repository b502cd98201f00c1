"""Live picture of the twin's trunk, hanging from its base."""

from __future__ import annotations

import math
from typing import final

import numpy as np

from spiraltrunk.design import TrunkDesign
from spiraltrunk.studio.drawing.base_plate import add_base, turn_base
from spiraltrunk.studio.drawing.trunk_view import BODY, UPRIGHT, TrunkView, place_frames
from spiraltrunk.studio.page.page import Page

_HANGING = math.pi / 2
"""Angle of the base axis below the horizontal [rad]."""


@final
class TwinPicture:
    """Nodes of the trunk below a root, moved with each state."""

    def __init__(self, page: Page, root: str, design: TrunkDesign) -> None:
        """Add the nodes; the trunk is invisible until it is drawn."""
        self.design = design
        """The trunk."""
        self._root = page.scene.add_frame(root, show_axes=False)
        self._trunk = TrunkView(page, f"{root}/sections", design)
        page.scene.add_frame(f"{root}/world", show_axes=False, wxyz=UPRIGHT)
        turn_base(add_base(page, f"{root}/world/base", design), _HANGING)

    def draw(self, frames: np.ndarray) -> None:
        """Move the sections to their frames, shape (n_section, 4, 4) [-, m]."""
        if len(frames) == self.design.n_section:
            colors = np.tile(BODY, (len(frames), 1))
            self._trunk.draw(place_frames(frames, _HANGING), colors, colors)

    def remove(self) -> None:
        """Take it out of the scene."""
        self._root.remove()
