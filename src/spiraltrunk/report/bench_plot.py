"""Static loads of joints and the laws fitted to them, in one picture."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, final

import numpy as np

from spiraltrunk.report.draft import write_draft
from spiraltrunk.report.look import COLORS, DPI, INK, LIMIT, NORMAL, SMALL, add_look, build_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@final
@dataclass(frozen=True, kw_only=True)
class Loaded:
    """One joint's readings and its laws."""

    name: str
    """What to call it."""
    bend: np.ndarray
    """Deflections, shape (n,) [rad]."""
    moment: np.ndarray
    """Moments, shape (n,) [N m]."""
    beam: float
    """Stiffness by the beam law alone [N m/rad]."""
    law: Callable[[np.ndarray], np.ndarray]
    """Moment of the fitted law at bends [N m]."""
    faces_from: float
    """Bend from which faces meet, not a number for none [rad]."""


def write_loads(loaded: Sequence[Loaded], path: str | Path) -> Path:
    """Draw the joints to a PNG.

    Raises:
        OSError: where the file cannot be written.
    """
    figure = build_loads_figure(loaded)
    with write_draft(path) as draft:
        figure.savefig(draft, dpi=DPI, format="png")
    return Path(path)


def build_loads_figure(loaded: Sequence[Loaded]) -> Figure:
    """Moment over bend, a panel a joint, four in a row."""
    across = min(4, max(1, len(loaded)))
    down = -(-len(loaded) // across)
    figure = build_figure(3.3 * across, 3.0 * down + 0.5, "Static loads of joints")
    panels = figure.subplots(down, across, squeeze=False).ravel()
    for axes, joint in zip(panels, loaded, strict=False):
        _draw(axes, joint)
    for axes in panels[len(loaded) :]:
        axes.set_visible(False)
    named = {
        label: handle
        for axes in panels[: len(loaded)]
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    figure.legend(
        named.values(), named.keys(), loc="outside lower center", ncols=4, frameon=False, fontsize=SMALL, labelcolor=INK
    )
    return figure


def _draw(axes: Axes, joint: Loaded) -> None:
    bend = np.linspace(0.0, float(joint.bend.max()) * 1.03, 200)
    axes.plot(
        np.degrees(bend), joint.beam * bend, color=COLORS[1], linestyle="--", linewidth=1.2, label="beam law alone"
    )
    axes.plot(np.degrees(bend), joint.law(bend), color=COLORS[0], linewidth=1.4, label="fitted law")
    axes.plot(
        np.degrees(joint.bend), joint.moment, color=INK, linestyle="", marker="o", markersize=4.0, label="readings"
    )
    if np.isfinite(joint.faces_from):
        axes.axvline(np.degrees(joint.faces_from), color=LIMIT, linestyle=":", linewidth=1.0, label="faces meet")
    axes.set_title(joint.name, fontsize=NORMAL, color=INK)
    axes.set_xlabel("Bend [deg]", fontsize=NORMAL, color=INK)
    axes.set_ylim(bottom=0.0)
    add_look(axes, "Moment [N m]")
