"""Figure of static loads and ring-downs of joints on the bench, with the fitted laws."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, final

import numpy as np

from spiraltrunk.report.style import COLORS, INK, LIMIT, add_legend_below, build_grid, style_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@final
@dataclass(frozen=True, kw_only=True)
class LoadedJoint:
    """Static loads of one joint and the fitted law."""

    name: str
    """Title of the panel."""
    bend: np.ndarray
    """Deflections, shape (n,) [rad]."""
    moment: np.ndarray
    """Moments, shape (n,) [N m]."""
    beam: float
    """Stiffness of the beam law [N m/rad]."""
    law: Callable[[np.ndarray], np.ndarray]
    """Fitted law: moments at bends [N m]."""
    faces_from: float
    """Bend from which on the faces touch, NaN for none [rad]."""


@final
@dataclass(frozen=True, kw_only=True)
class RingDown:
    """Ring-down of one joint and the fitted law."""

    name: str
    """Title of the panel."""
    time: np.ndarray
    """Since the first sample, shape (n,) [s]."""
    signal: np.ndarray
    """Recorded signal, shape (n,)."""
    law: Callable[[np.ndarray], np.ndarray]
    """Fitted law: signal at times [s]."""


def build_loads_figure(joints: Sequence[LoadedJoint | RingDown]) -> Figure:
    """Moment over bend, or signal over time: one panel for each joint, four in a row."""
    figure, panels = build_grid(len(joints), 4, (3.3, 3.0), "Joints on the bench")
    named: dict[str, Any] = {}
    for axes, joint in zip(panels, joints, strict=True):
        if isinstance(joint, RingDown):
            _draw_ring(axes, joint)
        else:
            _draw(axes, joint)
        handles, labels = axes.get_legend_handles_labels()
        named |= dict(zip(labels, handles, strict=True))
    add_legend_below(figure, list(named.values()))
    return figure


def _draw(axes: Axes, joint: LoadedJoint) -> None:
    bend = np.linspace(0.0, float(joint.bend.max()) * 1.03, 200)
    angle = np.degrees(bend)
    axes.plot(angle, joint.beam * bend, color=COLORS[1], linestyle="--", linewidth=1.2, label="beam law alone")
    axes.plot(angle, joint.law(bend), color=COLORS[0], linewidth=1.4, label="fitted law")
    axes.plot(np.degrees(joint.bend), joint.moment, "o", color=INK, markersize=4.0, label="readings")
    if np.isfinite(joint.faces_from):
        axes.axvline(np.degrees(joint.faces_from), color=LIMIT, linestyle=":", linewidth=1.0, label="faces meet")
    axes.set_ylim(bottom=0.0)
    style_axes(axes, "Moment [N m]", xlabel="Bend [deg]", title=joint.name)


def _draw_ring(axes: Axes, joint: RingDown) -> None:
    time = np.linspace(0.0, float(joint.time[-1]), 2_000)
    axes.plot(1e3 * time, joint.law(time), color=COLORS[0], linewidth=1.4, label="fitted law")
    axes.plot(1e3 * joint.time, joint.signal, "o", color=INK, markersize=2.0, label="readings")
    style_axes(axes, "Signal", xlabel="Time [ms]", title=joint.name)
