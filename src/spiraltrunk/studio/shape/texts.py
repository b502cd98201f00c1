"""What the tab says of a shape, as HTML: colours with their meaning, and the state in words and numbers."""

from __future__ import annotations

from html import escape
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from spiraltrunk.design import TrunkDesign
from spiraltrunk.report.style import COLORS
from spiraltrunk.studio.drawing.trunk_view import BODY, GHOST
from spiraltrunk.studio.page.html import BLOCK, format_color, format_mark
from spiraltrunk.studio.shape.picture import SHUT

if TYPE_CHECKING:
    from spiraltrunk.studio.shape.state import TrunkState

_LIMIT = '<span style="white-space: nowrap">- - joint limit</span>'

_DRAG = "<br>Drag the arrows at the tip: the cables follow."

OUT_OF_REACH = 5e-4
"""Distance left from which on a place counts as out of reach [m]: half a millimetre."""


def format_legend(design: TrunkDesign) -> str:
    """Colours of the scene and the plots."""
    cables = [(COLORS[i % len(COLORS)], f"cable {i + 1}{_name_side(design, i)}") for i in range(design.n_cable)]
    marks = [
        (format_color(SHUT), "shut joint"),
        (format_color(BODY), "section"),
        (format_color(GHOST), "paper's model"),
        *cables,
    ]
    return BLOCK.format(" ".join([*(format_mark(color, text) for color, text in marks), _LIMIT]) + _DRAG)


def format_compiling(what: str) -> str:
    """What is compiled now."""
    return BLOCK.format(
        f"<b>Compiling the models: {escape(what)}.</b><br>Once after they were installed or changed, about 15 s a "
        "model. The page can be used meanwhile; the shape follows then."
    )


def format_failed(reason: str) -> str:
    """Why there are no models."""
    return BLOCK.format(f"<b>The models could not be compiled:</b> {escape(reason)}")


def format_state(state: TrunkState, target: tuple[float, bool] | None) -> str:
    """Status, tip, joints, tensions and the paper's model.

    Args:
        state: the trunk, solved.
        target: after the tip was dragged, the distance left [m], and whether it was let go.
    """
    from spiraltrunk.model.statics.pull_sequences import find_shut

    shape = state.shape
    assert shape is not None
    shut = find_shut(state.design, shape)
    x, y, z = (_round(1e3 * float(value)) for value in shape.points[-1])
    bend = float(np.degrees(shape.joint_angle).sum())
    lines = [
        f"<b>{escape(_capital(shape.advice))}</b>" if target is None else _format_target(*target),
        f"Tip x {x:.0f}, y {y:.0f}, z {z:.0f} mm; bend {bend:.0f} deg in all",
        f"Shut joints: {format_runs(shut)}",
        _format_tensions(state), _format_paper(state),
    ]  # fmt: skip
    return BLOCK.format("<br>".join(line for line in lines if line))


def format_runs(is_true: np.ndarray) -> str:
    """Numbers of the joints for which it is true, from 1 at the base, runs of them as 11 to 17."""
    runs = [
        [i for i, _ in run] for holds, run in groupby(enumerate(is_true.tolist(), 1), lambda pair: pair[1]) if holds
    ]
    listed = ", ".join(f"{run[0]} to {run[-1]}" if len(run) > 1 else f"{run[0]}" for run in runs)
    return f"{listed} of {len(is_true)}" if runs else f"none of {len(is_true)}"


def _format_target(distance: float, is_let_go: bool) -> str:
    left = f"{1e3 * distance:.1f} mm"
    if distance <= OUT_OF_REACH:
        return f"<b>The tip is where you hold it</b> (residual {1e3 * distance:.2f} mm)"
    ending = "" if is_let_go else "; let go to search longer"
    return f'<b style="color: {format_color((213, 94, 0))}">Out of reach: the tip stays {left} away</b>{ending}'


def _format_tensions(state: TrunkState) -> str:
    assert state.shape is not None
    if state.shape.forces is None:
        return ""
    words = [
        f"{i}: slack" if tension <= 0.0 else f"{i}: {tension:.1f} N"
        for i, tension in enumerate(state.shape.forces.cable_tension.tolist(), 1)
    ]
    return f"Tension of cable {', '.join(words)}"


def _format_paper(state: TrunkState) -> str:
    if state.paper is None or state.shape is None:
        return ""
    if state.paper.shape is None:
        return f"No ghost: {escape(state.paper.pull)}"
    away = float(np.linalg.norm(state.paper.shape.points[-1] - state.shape.points[-1]))
    return f"Paper's model, {escape(state.paper.pull)}: its tip is {1e3 * away:.1f} mm away"


def _name_side(design: TrunkDesign, cable: int) -> str:
    side = float(design.cable_direction[cable, 1])
    return " (dorsal)" if side > 0.9 else " (ventral)" if side < -0.9 else ""


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _round(value: float) -> float:
    """Rounded, without a minus before zero."""
    return round(value) + 0.0
