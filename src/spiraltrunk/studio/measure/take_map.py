"""Map of a take: error by section and time, gaps left grey, and the moment that is shown."""

from __future__ import annotations

import numpy as np

from spiraltrunk.studio.measure.error_scale import color_distances

_WIDTH, _ROW = 360, 5
"""Width of the map, and height of a section's row [px]."""


def draw_map(distance: np.ndarray, recorded: np.ndarray, most: float) -> np.ndarray:
    """Picture of distances (m, n_section) [m] by time, left to right, and recorded section, tip above.

    A column shows the largest distance in its span of time; it is a gap where no moment of it was seen.

    Returns:
        Red, green and blue, shape (rows, columns, 3) [uint8].
    """
    columns = np.array_split(distance[:, recorded], min(_WIDTH, len(distance)))
    largest = np.array([np.where(np.isfinite(one), one, -1.0).max(axis=0) for one in columns]).T[::-1]
    values = np.where(largest < 0.0, np.nan, largest)
    colors = color_distances(values.ravel(), most).reshape(*values.shape, 3).astype(np.uint8)
    wide = colors[:, np.arange(_WIDTH) * colors.shape[1] // _WIDTH]
    return np.repeat(wide, _ROW, axis=0)


def mark_moment(picture: np.ndarray, share: float) -> np.ndarray:
    """The map with a line at a moment, as a share of the take [-]."""
    marked = picture.copy()
    column = round(share * (picture.shape[1] - 1))
    marked[:, max(0, column - 1) : column + 2] = (213, 94, 0)
    return marked
