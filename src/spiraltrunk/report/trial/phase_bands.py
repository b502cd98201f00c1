"""Phases of a run: shaded bands behind the data and a labelled strip above the axes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from spiraltrunk.report.style import INK, OTHER_PHASE_COLOR, PHASE_COLORS, SMALL

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Spans = Sequence[tuple[str, float, float]]

_FOOT, _STRIP = 0.02, 0.06
"""Distance of the strip from the axes and its height [in]."""

_LEADER = 0.12
"""Height of the leader lines to labels beside their phases [in]."""

_LETTER = 0.62 * SMALL / 72
"""Upper estimate of a letter's width [in]."""

_AXES_SHARE = 0.58
"""Lower estimate of the width of the axes over that of the figure [-]."""


def add_bands(axes: Axes, spans: Spans, *, is_opaque: bool = False) -> None:
    """Shade each phase; over an opaque image draw the borders between phases instead."""
    for phase, begin, end in spans:
        if not is_opaque:
            axes.axvspan(begin, end, color=_color(phase), alpha=0.10, linewidth=0.0, zorder=0)
        elif begin > min(other for _, other, _ in spans):
            axes.axvline(begin, color="white", linewidth=0.8, linestyle=(0, (4, 3)), alpha=0.9)


def add_strip(axes: Axes, spans: Spans) -> None:
    """Draw coloured phases with their names above the axes, whose time limits must be set."""
    from matplotlib.patches import Rectangle
    from matplotlib.transforms import ScaledTranslation, blended_transform_factory

    left, right = axes.get_xlim()
    seen = [(phase, max(begin, left), min(end, right)) for phase, begin, end in sorted(spans, key=lambda span: span[1])]
    seen = [(phase, begin, end) for phase, begin, end in seen if begin <= end]
    figure = axes.figure.get_figure(root=True)
    # Time, and inches above the axes. Any transform works here, though matplotlib's types ask for an affine one.
    upwards = figure.dpi_scale_trans + ScaledTranslation(0.0, 1.0, axes.transAxes)  # type: ignore[arg-type]
    place = blended_transform_factory(axes.transData, upwards)
    for phase, begin, end in seen:
        axes.add_patch(
            Rectangle((begin, _FOOT), end - begin, _STRIP, transform=place, clip_on=False, color=_color(phase), lw=0.0)
        )
    width = _AXES_SHARE * figure.get_figwidth()
    labels = place_labels(seen, letter=_LETTER * (right - left) / width, left=left, right=right)
    low, high = _FOOT + _STRIP, _FOOT + _STRIP + 0.02
    if any(at != center for _, center, at in labels):
        high += _LEADER
    for phase, center, at in labels:
        if high > low + _LEADER:
            axes.plot(
                [center, at], [low, high], transform=place, clip_on=False, color=INK, lw=0.6, scalex=False, scaley=False
            )
        axes.text(at, high, phase, transform=place, ha="center", va="bottom", size=SMALL, color=INK, parse_math=False)


def place_labels(spans: Spans, *, letter: float, left: float, right: float) -> list[tuple[str, float, float]]:
    """Places of the names such that none overlaps another: name, centre of the phase, centre of the name [-, s, s].

    A name is centred over its phase where there is room, else moved aside. Where there is no room for all names, those
    of the shortest phases are left out.

    Args:
        spans: phases in order of time.
        letter: width of a letter [s].
        left: begin of the row [s].
        right: end of the row [s].
    """
    named = list(spans)
    while named and sum(len(phase) + 1 for phase, _, _ in named) * letter > right - left:
        named.remove(min(named, key=lambda span: span[2] - span[1]))
    if not named:
        return []
    centers = np.array([(begin + end) / 2 for _, begin, end in named])
    widths = letter * np.array([len(phase) + 1 for phase, _, _ in named])
    offsets = np.cumsum(widths) - widths / 2  # Of names side by side from the left on.
    shifts = np.maximum.accumulate(np.maximum(centers - offsets, left - letter))
    places = offsets + np.minimum(shifts, right + letter - widths.sum())
    phases = [phase for phase, _, _ in named]
    return list(zip(phases, centers.tolist(), places.tolist(), strict=True))


def _color(phase: str) -> str:
    return PHASE_COLORS.get(phase, OTHER_PHASE_COLOR)
