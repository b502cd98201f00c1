"""Lines and axes of the plots in the panel."""

from __future__ import annotations

from typing import Any

DASHES: Any = ([], [16, 8], [6, 12], [2, 6])
"""Dashes of the cables' lines, so that equal values are seen as such, also without colours."""

_FONT, _SMALL = "12px sans-serif", "11px sans-serif"


def label_axes(x: str, y: str) -> Any:
    """Axes of a plot with their labels; where ``y`` is empty, that of the values has none."""
    across = {"label": x, "labelSize": 16, "size": 26, "labelFont": _FONT, "font": _SMALL}
    if not y:
        return across, {"size": 44, "font": _SMALL}
    return across, {"label": y, "labelSize": 16, "size": 38, "labelFont": _FONT, "font": _SMALL}
