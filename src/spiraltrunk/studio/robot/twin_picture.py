"""Picture of the robot's trunk, hanging from its base: as the twin has it, or straight while none is connected."""

from __future__ import annotations

from typing import final

import numpy as np

from spiraltrunk.design import TrunkDesign
from spiraltrunk.studio.drawing.base_plate import add_base, turn_base
from spiraltrunk.studio.drawing.note import add_note
from spiraltrunk.studio.drawing.trunk_view import BODY, HANGING, UPRIGHT, TrunkView, place_frames
from spiraltrunk.studio.page.page import Page

_DESIGN = "the design; no robot is connected"

_UNKNOWN = "the shape of this robot is not measured"


@final
class TwinPicture:
    """Nodes of the trunk below a root, moved with each state."""

    def __init__(self, page: Page, root: str, design: TrunkDesign) -> None:
        """Add the nodes; the trunk is straight until it is drawn."""
        self.design = design
        """The trunk."""
        self._root = page.scene.add_frame(root, show_axes=False)
        self._trunk = TrunkView(page, f"{root}/sections", design)
        page.scene.add_frame(f"{root}/world", show_axes=False, wxyz=UPRIGHT)
        turn_base(add_base(page, f"{root}/world/base", design), HANGING)
        self._note = add_note(page, f"{root}/world/note", design, _DESIGN)
        self._trunk.draw_straight()
        self._is_straight = True

    def draw(self, frames: np.ndarray | None) -> None:
        """Move the sections to their frames, shape (n_section, 4, 4) [-, m]; without, no trunk is shown."""
        self._is_straight = False
        is_known = frames is not None and len(frames) == self.design.n_section
        self._tell("" if is_known else _UNKNOWN)
        if frames is None or not is_known:
            self._trunk.hide()
            return
        colors = np.tile(BODY, (len(frames), 1))
        self._trunk.draw(place_frames(frames, HANGING), colors, colors)

    def draw_straight(self) -> None:
        """Show the trunk straight."""
        if not self._is_straight:
            self._is_straight = True
            self._tell(_DESIGN)
            self._trunk.draw_straight()

    def _tell(self, text: str) -> None:
        """Write a note below the base, or none."""
        if self._note.visible != bool(text):
            self._note.visible = bool(text)
        if text and self._note.text != text:
            self._note.text = text

    def remove(self) -> None:
        """Take it out of the scene."""
        self._root.remove()
