"""Camera of one tab: all tabs share the page's camera, so each keeps its own view of what it draws."""

from __future__ import annotations

import math
import time
from typing import final

import numpy as np

from spiraltrunk.design import TrunkDesign
from spiraltrunk.studio.page.page import Page

FIELD = math.radians(75.0)
"""Vertical field of view of a page, as viser has it [rad]."""

SETTLED = 1.0
"""Time after which the view that a page reports is this tab's [s] (ours): before, it may be that of the tab before."""


@final
class TabCamera:
    """View of one tab, restored when the tab is shown again."""

    def __init__(self, page: Page, position: np.ndarray, look_at: np.ndarray, *, field: float = FIELD) -> None:
        """Set the first view, positions in the scene's frame, z up, shape (3,) [m], and its vertical field [rad]."""
        self._page = page
        self._field = field
        self._position, self._look_at = np.asarray(position, float), np.asarray(look_at, float)
        self._since = -math.inf

    def show(self) -> None:
        """Move the page's camera to this tab's view."""
        self._since = time.monotonic()
        camera = self._page.client.camera
        with self._page.client.atomic():
            camera.up_direction = np.array([0.0, 0.0, 1.0])
            camera.position = self._position
            camera.look_at = self._look_at
            camera.fov = self._field

    def keep(self) -> None:
        """Store the present view as this tab's; not of a tab that was shown for a moment alone."""
        if time.monotonic() - self._since < SETTLED:
            return
        camera = self._page.client.camera
        self._position, self._look_at = np.array(camera.position), np.array(camera.look_at)


def aim_at_trunk(page: Page, design: TrunkDesign) -> TabCamera:
    """View of a trunk whose base is the scene's origin, from the side that it curls in."""
    size = design.length
    return TabCamera(page, np.array([0.34 * size, -1.14 * size, -0.2 * size]), np.array([0.0, 0.0, -0.42 * size]))
