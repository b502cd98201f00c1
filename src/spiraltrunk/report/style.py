"""Style of the figures. It is set on each figure; matplotlib's global settings stay unchanged."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any

from spiraltrunk.files.atomic import atomic_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""Colours of lines, distinguishable with any colour vision (Okabe and Ito, Color Universal Design)."""

LINE_STYLES = ("-", "--", "-.", ":")
"""Styles of lines, distinguishable in print without colours."""

INK = "#222222"
"""Text and frames."""

PHASE_COLORS = {"reach": "#56B4E9", "prehension": "#E69F00", "transport": "#009E73", "release": "#CC79A7"}
"""Colour of each phase; the bands behind the data are lighter."""

OTHER_PHASE_COLOR = "#999999"
"""Colour of a phase with another name."""

LIMIT = "#B34500"
"""Colour of limits."""

SMALL, NORMAL, LARGE = 8.0, 9.0, 10.5
"""Text sizes: ticks and legends, axes, title [pt]."""

DPI = 150
"""Pixels per inch."""


def build_figure(width: float, height: float, title: str) -> Figure:
    """An empty figure with constrained layout; width and height in inches."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=DPI, layout="constrained", facecolor="white")
    if title:
        figure.suptitle(
            "\n".join(wrap(title, round(10 * width))), fontsize=LARGE, fontweight="bold", color=INK, parse_math=False
        )
    return figure


def build_grid(count: int, columns: int, size: tuple[float, float], title: str) -> tuple[Figure, list[Axes]]:
    """A figure of ``count`` axes of one size [in] in rows of at most ``columns``; of none, it is blank."""
    across = max(1, min(columns, count))
    down = max(1, -(-count // across))
    figure = build_figure(size[0] * across, size[1] * down + 0.5, title)
    grid = list(figure.subplots(down, across, squeeze=False).flat)
    for axes in grid[count:]:
        axes.set_visible(False)
    return figure, grid[:count]


def write_figure(figure: Figure, path: str | Path, **settings: Any) -> Path:
    """Save a figure with settings of ``Figure.savefig``; the path's ending names the format.

    Raises:
        OSError: where the file cannot be written.
    """
    with atomic_file(path) as draft:
        figure.savefig(draft, **{"dpi": DPI, **settings})
    return Path(path)


def format_figure(figure: Figure, form: str, **settings: Any) -> bytes:
    """A figure as the content of a file.

    Args:
        figure: what to save.
        form: format, such as "png".
        settings: passed on to ``Figure.savefig``.
    """
    file = BytesIO()
    figure.savefig(file, **{"dpi": DPI, "format": form, **settings})
    return file.getvalue()


def style_axes(axes: Axes, ylabel: str = "", *, xlabel: str = "", title: str = "") -> None:
    """Set labels and title, and the style of ticks, frame and grid; an empty text leaves what is there."""
    for text, write in ((ylabel, axes.set_ylabel), (xlabel, axes.set_xlabel), (title, axes.set_title)):
        if text:
            write(text, fontsize=NORMAL, color=INK)
    axes.tick_params(which="both", labelsize=SMALL, colors=INK)
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(visible=True, color="#00000018", linewidth=0.6)
    axes.set_axisbelow(True)


def add_legend(axes: Axes, **settings: Any) -> None:
    """Add a legend of the labelled artists, to the right of the axes unless ``settings`` place it elsewhere."""
    place = settings or {"loc": "upper left", "bbox_to_anchor": (1.01, 1.0), "borderaxespad": 0.0}
    axes.legend(**place, frameon=False, fontsize=SMALL, labelcolor=INK)


def add_legend_below(figure: Figure, handles: Sequence[Any], columns: int = 4) -> None:
    """Add a legend of these artists below all axes of a figure."""
    figure.legend(
        handles=list(handles), loc="outside lower center", ncols=columns, frameon=False, fontsize=SMALL, labelcolor=INK
    )
