"""Shape of the twin's trunk, for pictures."""

from __future__ import annotations

import math
from typing import final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.hardware.twin.trunk.trunk_curl import tabulate_bends
from spiraltrunk.model.kinematics.frames import bend_rotation, section_frames


@final
class CurlShape:
    """Frames of the sections of a planar curl, see `trunk_curl`."""

    def __init__(self, design: TrunkDesign) -> None:
        self._design = design
        self._size, self._bend = tabulate_bends(design)

    def compute_frames(self, curl: tuple[float, float]) -> np.ndarray:
        """Frames of all sections in the base frame.

        A bend towards y is a rotation about z, one towards z a rotation about -y.

        Args:
            curl: the curl b towards y and z, of `SpringTrunk.curl` [m].

        Returns:
            Frames in the proximal joint centres, shape (n_section, 4, 4) [-, m].
        """
        b, e = curl
        size = math.hypot(b, e)
        u, v = (b / size, e / size) if size > 0.0 else (0.0, 0.0)
        bend = np.array([np.interp(size, self._size, joint) for joint in self._bend.T])
        return section_frames(self._design, bend_rotation(np.stack([-v * bend, u * bend], axis=-1)))
