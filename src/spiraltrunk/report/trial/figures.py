"""Figures of one run over time, and their files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, final

import numpy as np

from spiraltrunk.model.kinematics.curl_front import compute_front
from spiraltrunk.report.style import (
    COLORS,
    INK,
    LIMIT,
    LINE_STYLES,
    NORMAL,
    SMALL,
    add_legend,
    build_figure,
    style_axes,
    write_figure,
)
from spiraltrunk.report.trial.phase_bands import add_bands, add_strip

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Series:
    """Quantities of one run, sampled at the same n instants."""

    time: np.ndarray
    """Instants, increasing, shape (n,) with n >= 2 [s]."""
    phase_spans: tuple[tuple[str, float, float], ...]
    """Name, start and end of each phase [-, s, s]."""
    cable_pull: np.ndarray
    """Cable pulled in since the straight trunk, shape (n, n_cable) [m]."""
    cable_tension: np.ndarray
    """Tension of each cable, shape (n, n_cable) [N]."""
    joint_bend: np.ndarray
    """Bend of each joint, base to tip, shape (n, n_joint) [rad]."""
    joint_limit: float
    """Bend at which neighbouring sections touch [rad]."""
    section_length: np.ndarray
    """Length of each section, base to tip, shape (n_joint + 1,) [m]."""
    object_height: np.ndarray
    """Height of the object's centre, shape (n,) [m]."""
    lift: tuple[float, float] | None
    """Heights from and to which the object is to be lifted; None where it is not lifted [m]."""
    grip_force: np.ndarray
    """Sum of the normal forces between trunk and object, shape (n,) [N]."""
    string_tension: np.ndarray
    """Sum of the tensions of the strings that carry the object before the grasp, shape (n,) [N]."""
    title: str
    """Title of the figures."""

    @property
    def front(self) -> np.ndarray:
        """Curled length from the tip over the trunk's length, shape (n,) [-]."""
        front = compute_front(self.joint_bend, self.section_length, self.joint_limit)
        return np.asarray(front / self.section_length.sum())


def add_cable_pull(axes: Axes, series: Series) -> None:
    """Cable pulled in since the straight trunk [mm]."""
    _add_lines(axes, series, 1e3 * series.cable_pull, _cable_labels(series))
    axes.axhline(0.0, color=INK, linewidth=0.6, zorder=1)
    _finish(axes, series, "Length change [mm]\n(shortening > 0)")


def add_cable_tension(axes: Axes, series: Series) -> None:
    """Tension of each cable [N]."""
    _add_lines(axes, series, series.cable_tension, _cable_labels(series))
    axes.set_ylim(bottom=min(0.0, 1.05 * float(series.cable_tension.min())))
    _finish(axes, series, "Cable tension [N]")


def add_joint_bend(axes: Axes, series: Series) -> None:
    """Heat map of the bend of each joint over time, base at the bottom, with the limit on the colour bar [deg]."""
    limit = np.degrees(series.joint_limit)
    bend = np.degrees(series.joint_bend)
    n_joint = bend.shape[1]
    time = series.time
    edges = np.concatenate([time[:1], (time[1:] + time[:-1]) / 2, time[-1:]])  # Half-way between instants.
    mesh = axes.pcolormesh(
        edges, np.arange(n_joint + 1) + 0.5, bend.T, cmap="viridis", rasterized=True,
        vmin=min(0.0, float(bend.min())), vmax=max(1.08 * limit, float(bend.max())),
    )  # fmt: skip
    _finish(axes, series, "Joint", is_opaque=True)
    axes.grid(visible=False)
    axes.set_ylim(0.5, n_joint + 0.5)
    ticks = sorted({1, *range(5, n_joint - 1, 5), n_joint})
    ends = {n_joint: f"tip  {n_joint}", 1: "base  1"}
    axes.set_yticks(ticks, [ends.get(tick, str(tick)) for tick in ticks])
    _add_color_bar(axes, mesh, limit)


def add_front(axes: Axes, series: Series) -> None:
    """Length of the curled part from the tip [% of the trunk's length]."""
    front = 100 * series.front
    _add_lines(axes, series, front[:, None], ["end of the curl"])
    axes.fill_between(series.time, front, color=COLORS[0], alpha=0.15, linewidth=0.0)
    axes.set_ylim(0.0, 100.0)
    axes.set_yticks([0, 25, 50, 75, 100], ["0  tip", "25", "50", "75", "100  base"])
    _finish(axes, series, "Curled part\n[% of length]")


def add_object_height(axes: Axes, series: Series) -> None:
    """Height of the object, and start and target of its lift [m]."""
    _add_lines(axes, series, series.object_height[:, None], ["object"])
    if series.lift is not None:
        for height, style, label in zip(series.lift, (":", "--"), ("lift start", "lift target"), strict=True):
            axes.axhline(height, color=INK, linewidth=1.2, linestyle=style, label=label)
    _finish(axes, series, "Object height [m]")


def add_forces(axes: Axes, series: Series) -> None:
    """Contact force between trunk and object, and tension of the strings that carry it before the grasp [N]."""
    forces = np.column_stack([series.grip_force, series.string_tension])
    _add_lines(axes, series, forces, ["contact force", "string tension"])
    axes.set_ylim(bottom=min(0.0, 1.05 * float(forces.min())))
    _finish(axes, series, "Force on object [N]")


def _add_color_bar(axes: Axes, mesh: ScalarMappable, limit: float) -> None:
    """Colour bar of the bend with the joint limit as a labelled tick [deg]."""
    bar = axes.figure.colorbar(mesh, cax=axes.inset_axes((1.02, 0.0, 0.028, 1.0)))
    bottom, top = bar.ax.get_ylim()
    steps = [tick for tick in bar.get_ticks() if bottom <= tick <= top and abs(tick - limit) > 0.08 * (top - bottom)]
    bar.set_ticks([*steps, limit], labels=[*(f"{step:g}" for step in steps), f"{limit:.3g} limit"])
    bar.set_label("Bend [°]", fontsize=NORMAL, color=INK)
    bar.ax.tick_params(labelsize=SMALL, colors=INK)
    bar.ax.get_yticklabels()[-1].set_color(LIMIT)
    bar.ax.axhline(limit, color=LIMIT, linewidth=2.0)
    bar.outline.set_visible(False)


def _add_lines(axes: Axes, series: Series, values: np.ndarray, labels: list[str]) -> None:
    for i, label in enumerate(labels):
        color, style = COLORS[i % len(COLORS)], LINE_STYLES[i % len(LINE_STYLES)]
        axes.plot(series.time, values[:, i], label=label, linewidth=1.6, color=color, linestyle=style)


def _finish(axes: Axes, series: Series, ylabel: str, *, is_opaque: bool = False) -> None:
    add_bands(axes, series.phase_spans, is_opaque=is_opaque)
    style_axes(axes, ylabel)
    axes.set_xlim(float(series.time[0]), float(series.time[-1]))
    if not is_opaque:
        add_legend(axes)


def _cable_labels(series: Series) -> list[str]:
    return [f"cable {i + 1}" + (" (dorsal)" if i == 0 else "") for i in range(series.cable_pull.shape[1])]


_WIDTH = 7.6
"""Width of every figure [in]."""

FIGURES: dict[str, tuple[float, dict[Callable[[Axes, Series], None], float]]] = {
    "cables.png": (4.6, {add_cable_pull: 1.0, add_cable_tension: 1.0}),
    "joints.png": (3.4, {add_joint_bend: 1.0}),
    "curvature.png": (3.0, {add_front: 1.0}),
    "object.png": (3.0, {add_object_height: 1.0}),
    "force.png": (3.0, {add_forces: 1.0}),
    "overview.png": (
        10.6,
        {
            add_cable_pull: 1.0, add_cable_tension: 1.0, add_joint_bend: 1.3, add_front: 0.9, add_object_height: 0.9,
            add_forces: 0.9,
        },
    ),
}  # fmt: skip
"""File name of each figure, its height [in], and its panels from top to bottom with their relative heights."""


def build_run_figure(series: Series, name: str) -> Figure:
    """Build the figure of `FIGURES` with this file name: panels over one time axis."""
    height, panels = FIGURES[name]
    figure = build_figure(_WIDTH, height, series.title)
    ratios = {"height_ratios": list(panels.values())}
    column = figure.subplots(len(panels), 1, sharex=True, squeeze=False, gridspec_kw=ratios)[:, 0]
    for axes, add_panel in zip(column, panels, strict=True):
        add_panel(axes, series)
    add_strip(column[0], series.phase_spans)
    column[-1].set_xlabel("Time [s]", fontsize=NORMAL, color=INK)
    figure.align_ylabels(list(column))
    return figure


def write_plots(series: Series, folder: str | Path) -> tuple[Path, ...]:
    """Write every figure to a folder, made where it is missing, and return the files.

    Raises:
        OSError: where the folder cannot be written.
    """
    return tuple(write_figure(build_run_figure(series, name), Path(folder) / name) for name in FIGURES)
