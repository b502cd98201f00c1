"""Static loads and ring-downs of joints and the laws fitted to them, in one picture."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, final

import numpy as np

from spiraltrunk.files.atomic import write_draft
from spiraltrunk.report.style import COLORS, DPI, INK, LIMIT, NORMAL, SMALL, add_look, build_figure

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


@final
@dataclass(frozen=True, kw_only=True)
class Rung:
    """One joint's ring-down and its law."""

    name: str
    """What to call it."""
    time: np.ndarray
    """Since the first sample, shape (n,) [s]."""
    signal: np.ndarray
    """What was recorded, shape (n,)."""
    law: Callable[[np.ndarray], np.ndarray]
    """Signal of the fitted law at times [s]."""


def write_loads(loaded: Sequence[Loaded | Rung], path: str | Path) -> Path:
    """Draw the joints to a PNG.

    Raises:
        OSError: where the file cannot be written.
    """
    figure = build_loads_figure(loaded)
    with write_draft(path) as draft:
        figure.savefig(draft, dpi=DPI, format="png")
    return Path(path)


def build_loads_figure(loaded: Sequence[Loaded | Rung]) -> Figure:
    """Moment over bend, or signal over time, a panel a record, four in a row."""
    across = min(4, max(1, len(loaded)))
    down = -(-len(loaded) // across)
    figure = build_figure(3.3 * across, 3.0 * down + 0.5, "Joints on the bench")
    panels = figure.subplots(down, across, squeeze=False).ravel()
    for axes, joint in zip(panels, loaded, strict=False):
        if isinstance(joint, Rung):
            _draw_ring(axes, joint)
        else:
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


def _draw_ring(axes: Axes, joint: Rung) -> None:
    time = np.linspace(0.0, float(joint.time[-1]), 2_000)
    axes.plot(1e3 * time, joint.law(time), color=COLORS[0], linewidth=1.4, label="fitted law")
    axes.plot(1e3 * joint.time, joint.signal, color=INK, linestyle="", marker="o", markersize=2.0, label="readings")
    axes.set_title(joint.name, fontsize=NORMAL, color=INK)
    axes.set_xlabel("Time [ms]", fontsize=NORMAL, color=INK)
    add_look(axes, "Signal")
