"""What the tab says, as HTML."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

from spiraltrunk.studio.measure.error_scale import GAP, format_gradient
from spiraltrunk.studio.measure.picture import MEASURED
from spiraltrunk.studio.measure.take_folder import StoredTake
from spiraltrunk.studio.page.html import BLOCK, format_color, format_mark
from spiraltrunk.workflows.validate.overlay import RunOverlay

RMSE = (0, 114, 178)
"""Colour of the line of root mean squares: blue of Okabe and Ito."""

_MOST_NOTES = 3
"""Notes that are shown; the report has all of them [-]."""

EMPTY = BLOCK.format(
    "<b>No recording yet.</b> Drop or upload a take that Motive exported as CSV (or C3D), or record a virtual session: "
    "a printed trunk that deviates from its design, recorded by simulated cameras."
)
"""What to do at first."""

STOPPED = BLOCK.format("<b>Stopped.</b> Change something to start again.")
"""After the stop button."""

CALIBRATE = BLOCK.format(
    "Fits the trunk's parameters to the takes. Of each run with several takes the last is held out and tells the error."
)
"""Before a calibration."""


def format_takes(takes: Sequence[StoredTake]) -> str:
    """The recordings that are there."""
    if not takes:
        return BLOCK.format("No takes.")
    return BLOCK.format("<br>".join(f"{escape(take.name)} <i>as {escape(take.run)}</i>" for take in takes))


def format_working(step: str) -> str:
    """What is done now."""
    return BLOCK.format(f"<b>{escape(step[:1].upper() + step[1:])} ...</b>")


def format_failed(reason: str) -> str:
    """Why there is no result."""
    return BLOCK.format(
        f'<span style="color: {format_color((213, 94, 0))}">▲</span> <b>No comparison:</b> {escape(reason)}'
    )


def format_moment(run: RunOverlay, take: int, moment: int, result: dict[str, Any]) -> str:
    """Figures of the run, the moment, and its gaps."""
    one, deviation = run.takes[take], run.deviation
    shape, gaps = int(one.shape[moment]), one.list_gaps(moment)
    state = "held" if one.is_held[moment] else "moving, nearest shape shown"
    lines = [
        f"<b>{escape(run.name)}, {escape(result['model'])}: mean RMSE {1e3 * deviation.mean_rmse:.1f} mm</b>, largest "
        f"distance {1e3 * deviation.max_deviation:.1f} mm, of the shapes averaged over their takes",
        f"Shape {shape + 1} of {len(run.labels)}: {escape(run.labels[shape])} ({state})",
        f"Gaps at this moment: {_list_sections(gaps)}",
    ]  # fmt: skip
    if result["is_made_up"]:
        lines.append("<i>Synthetic takes, not a measurement.</i>")
    return BLOCK.format("<br>".join(lines))


def format_scale(most: float) -> str:
    """The scale of colours, which ends at ``most`` [m], and what else is drawn."""
    bar = f"height: 0.7em; border-radius: 2px; background: {format_gradient()}"
    row = "display: flex; justify-content: space-between"
    ends = f'<div style="{row}"><span>0</span><span>{{}}</span><span>{{}}</span></div>'
    numbers = ends.format(f"distance from the model [mm], {500 * most:g} in the middle", f"{1e3 * most:g}")
    marks = f"{_mark(MEASURED, 'measured point')} {_mark(GAP, 'no marker seen')}"
    return BLOCK.format(f'<div style="{bar}"></div>{numbers}{marks}')


def format_lines() -> str:
    """Lines of the plot."""
    return BLOCK.format(f"{_mark(RMSE, 'RMSE of the run')} {_mark(MEASURED, 'distance at this moment')}")


def format_notes(notes: Sequence[str]) -> str:
    """Irregularities of the recordings."""
    if not notes:
        return ""
    more = f"<br>{len(notes) - _MOST_NOTES} more in the report" if len(notes) > _MOST_NOTES else ""
    listed = "<br>".join(escape(note) for note in notes[:_MOST_NOTES])
    return BLOCK.format(f'<span style="font-size: 0.72rem; opacity: 0.85">{listed}{more}</span>')


def format_calibration(result: dict[str, Any]) -> str:
    """Errors before and after a calibration, and its parameters."""
    held = result["held_out"].get("all")
    errors = held or result["fitted"]["all"]
    which = "takes that were held out" if held else "the fitted takes: none was held out"
    told = [name for name, each in result["parameters"].items() if each["is_told"]]
    lines = [
        f"<b>Mean RMSE {_mm(errors['calibrated_mean_rmse_m'])} mm calibrated</b>, on {which}",
        f"as designed {_mm(errors['uncalibrated_mean_rmse_m'])} mm, paper's model "
        f"{_mm(errors['reference_mean_rmse_m'])} mm",
        f"{len(told)} of {len(result['parameters'])} parameters are determined by these takes",
    ]  # fmt: skip
    return BLOCK.format("<br>".join(lines))


def _list_sections(gaps: list[int]) -> str:
    if not gaps:
        return "none"
    return f"section{'s' if len(gaps) > 1 else ''} {', '.join(map(str, gaps))}"


def _mark(color: tuple[int, int, int], text: str) -> str:
    return format_mark(format_color(color), text, radius="50%")


def _mm(value: float | None) -> str:
    return "-" if value is None else f"{1e3 * value:.2f}"
