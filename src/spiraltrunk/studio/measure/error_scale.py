"""Colours of distances between a measured and a modelled section."""

from __future__ import annotations

import numpy as np

_ANCHORS = np.array([(68, 1, 84), (59, 82, 139), (33, 145, 140), (94, 201, 98), (253, 231, 37)], float)
"""Viridis of matplotlib at 0, 1/4, 1/2, 3/4 and 1: even in lightness, for any colour vision."""

GAP = (165, 165, 165)
"""Colour of a section without markers."""


def color_distances(distance: np.ndarray, most: float) -> np.ndarray:
    """Colours of distances (n,) [m] on a scale from 0 to ``most`` [m]; `GAP` where they are not a number, (n, 3)."""
    place = np.clip(np.nan_to_num(distance / most), 0.0, 1.0)
    colors = np.stack([np.interp(place, np.linspace(0, 1, len(_ANCHORS)), part) for part in _ANCHORS.T], axis=-1)
    return np.where(np.isfinite(distance)[:, None], colors, GAP)


def format_gradient() -> str:
    """The scale as a CSS gradient from left to right."""
    stops = ", ".join("rgb({:.0f}, {:.0f}, {:.0f})".format(*color) for color in _ANCHORS)
    return f"linear-gradient(90deg, {stops})"
