"""Figures of a design and its warnings, as a compact table and lines of text."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from spiraltrunk.design import TrunkDesign, graspable_range, payload
from spiraltrunk.studio.design.picture import BACKBONE, CABLE, INNER, OBJECT, OUTER, RAY, TANGENT

_LINES = (
    (OUTER, "outer contour r = a e^(bθ)"), (BACKBONE, "backbone k r"), (INNER, "inner contour one turn further in"),
    (RAY, "rays through the faces"), (TANGENT, "tangent at the base"), (OBJECT, "smallest object"),
)  # fmt: skip


def list_figures(design: TrunkDesign) -> list[tuple[str, str, str]]:
    """Name, value with unit, and explanation of each figure."""
    widths = graspable_range(design)
    wrapped = "nothing, too short" if widths.is_empty else f"{_mm(widths.minimum)} to {_mm(widths.maximum)} mm"
    load = "none" if widths.is_empty else f"{payload(design):.3g} kg"
    gripper = "none" if design.gripper is None else f"to {_mm(design.gripper.grasp_width)} mm"
    return [
        ("Graspable", wrapped, "Widths that the trunk wraps"),
        ("Payload", load, "At the smallest object; fitted to the paper's one number"),
        ("Width", f"{_mm(design.base_width)} to {_mm(design.tip_width)} mm", "From the base to the tip"),
        ("Mass", f"{_format(1e3 * design.total_mass, 4)} g", "Sections and gripper"),
        ("Sections", f"{design.n_section}, ratio {design.k_p:.3f}", "Each is the ratio times the one before"),
        ("Length", f"{_mm(design.length)} mm", "Straight trunk, without housing and gripper"),
        ("Tip gripper", gripper, "Widths that the fingers enclose"),
        ("Cable stroke", f"{_mm(design.cable_stroke)} mm", "Cable to pull in until all gaps on its side are shut"),
    ]


def format_figures(design: TrunkDesign) -> str:
    """HTML of the table."""
    cells = [
        f'<td title="{escape(why)}" style="opacity:0.7;padding:1px 4px 1px 0">{escape(name)}</td>'
        f'<td title="{escape(why)}" style="padding:1px 4px 1px 0"><b>{escape(value)}</b></td>'
        for name, value, why in list_figures(design)
    ]
    rows = "".join(f"<tr>{first}{second}</tr>" for first, second in zip(cells[::2], cells[1::2], strict=True))
    style = "font-size:0.8em;margin:0 0 0 0.6rem;border-spacing:0;white-space:nowrap"
    return f'<table class="figures" style="{style}">{rows}</table>'


def find_gap(design: TrunkDesign) -> str:
    """Widths that neither gripper nor trunk can take, in words; empty where there are none."""
    widths = graspable_range(design)
    if widths.is_empty:
        return "the trunk is too short to wrap anything: more sections"
    smallest = widths.minimum
    if design.gripper is None or design.gripper.grasp_width >= smallest:
        return ""
    width = design.gripper.grasp_width
    sizes = f"{_mm(width)} to {_mm(smallest)} mm"
    return f"objects of {sizes} fit neither the gripper nor the trunk's tip: a larger m or longer fingers"


def format_warnings(warnings: Sequence[str], is_checking: bool) -> str:
    """HTML of the warnings, or what was checked."""
    if warnings:
        lines = "".join(f"<li>{escape(each)}</li>" for each in warnings)
        listed = f'<ul style="margin:2px 0 0 1.1em;padding:0">{lines}</ul>'
        body = f'<span style="color:#D55E00">▲</span> <b>Warnings</b>{listed}'
    elif is_checking:
        body = '<span style="opacity:0.7">Checking whether the parts can be made …</span>'
    else:
        body = "✓ No warnings: curl, drums, parts and screws fit."
    return f'<div class="warnings" style="font-size:0.8em;margin:0 0.6rem 0.4rem 0.6rem">{body}</div>'


def format_legend(with_construction: bool) -> str:
    """HTML of the colours of the cables and, where it is shown, of the construction."""
    lines = ((CABLE, "cables"), *(_LINES if with_construction else ()))
    words = [
        f'<span style="white-space:nowrap"><span style="display:inline-block;width:1.1em;height:3px;'
        f'vertical-align:middle;background:rgb{color}"></span> {escape(text)}</span>'
        for color, text in lines
    ]
    return f'<div style="font-size:0.75em;margin:0 0.6rem 0.4rem 0.6rem;line-height:1.5">{" &ensp;".join(words)}</div>'


def _mm(length: float) -> str:
    return _format(1e3 * length, 3)


def _format(value: float, digits: int) -> str:
    """A positive number with some significant digits, and all of those before the point: no exponent."""
    return f"{value:.0f}" if value >= 10.0**digits - 0.5 else f"{value:.{digits}g}"
