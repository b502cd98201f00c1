"""Plot of the study of stiffness."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from spiraltrunk.report.style import COLORS, DPI, INK, NORMAL, SMALL, build_figure, style_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TITLES = {
    "straight": "hanging straight",
    "curled": "hanging, half curled",
    "lying": "base horizontal, half curled",
}
LOOK = {("0", "tension"): 0, ("0", "length"): 5, ("0.2", "tension"): 4, ("0.2", "length"): 1}
"""Colour of each friction and mode."""

LINES = {"tension": ("--", "o"), "length": ("-", "s")}


def draw_stiffness(figures: dict[str, Any], path: Path) -> None:
    """Least stiffness in the sagittal plane over mean tension: the model as lines, the simulation as points."""
    figure = build_figure(9.6, 4.2, "Stiffness of the tip in the sagittal plane, dorsal against ventral cables")
    panels = figure.subplots(1, 3, sharey=True)
    for axes, (name, title) in zip(panels, TITLES.items(), strict=True):
        for (mu, mode), color in LOOK.items():
            _plot(axes, list(figures[name][mu].values()), mode, f"mu = {mu}, by {mode}", COLORS[color])
        axes.set_yscale("log")
        style_axes(axes, xlabel="Mean tension of the three cables [N]", title=title)
    panels[0].set_ylabel("Force over way at 5 mm [N/m]", fontsize=NORMAL, color=INK)
    figure.legend(
        *panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False, fontsize=SMALL,
        labelcolor=INK,
    )  # fmt: skip
    figure.savefig(path, dpi=DPI)


def _plot(axes: Axes, rows: list[dict[str, Any]], mode: str, label: str, color: str) -> None:
    style, marker = LINES[mode]
    axes.plot(
        [row["mean_n"] for row in rows], [row[mode]["in_plane"] for row in rows], color=color, linestyle=style,
        linewidth=1.4, label=label,
    )  # fmt: skip
    seen = [row["simulated"] for row in rows if "simulated" in row]
    axes.plot(
        [one["mean_n"] for one in seen], [one[mode] for one in seen], color=color, linestyle="none", marker=marker,
        markersize=5, markeredgecolor=INK, markeredgewidth=0.6, label=f"{label}, simulated",
    )  # fmt: skip
