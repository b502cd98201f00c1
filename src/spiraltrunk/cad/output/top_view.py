"""Top view of the open housing as an SVG picture: motors, drums, winding sense, guides and openings."""

from __future__ import annotations

import math

from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.geometry.csg import polar
from spiraltrunk.cad.housing.housing import PORT_TURN, find_bracket
from spiraltrunk.cad.housing.layout import POST, HousingLayout, find_layout
from spiraltrunk.cad.housing.winder import find_drum, motor_angles
from spiraltrunk.design.trunk import TrunkDesign

_SCALE = 4.0
"""Units of the picture per mm."""

_COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""Colours of the cables (Okabe and Ito)."""

_MARGIN = 32.0
"""Room for words around the housing [mm]."""


def find_port(layout: HousingLayout) -> float:
    """Angle of the opening for the wires from dorsal, anticlockwise seen from the trunk [rad]."""
    return (layout.posts[0] + PORT_TURN) % (2 * math.pi)


def find_servo(design: TrunkDesign, options: MakeOptions) -> float:
    """Angle of the servo's bracket from dorsal, anticlockwise seen from the trunk [rad].

    The lid is turned over for assembly, so its angles change their sign.
    """
    turn, _ = find_bracket(design, find_layout(design, options), options)
    return (-turn - math.pi / 2) % (2 * math.pi)


def find_touch(guide: tuple[float, float], drum: tuple[float, float], radius: float) -> tuple[float, float]:
    """Where a cable from its guide meets its drum, on the side towards the housing's wall [mm]."""
    apart = math.dist(guide, drum)
    bearing = math.atan2(drum[1] - guide[1], drum[0] - guide[0])
    way, spread = math.sqrt(apart**2 - radius**2), math.asin(radius / apart)
    ends = [
        (guide[0] + way * math.cos(bearing + side * spread), guide[1] + way * math.sin(bearing + side * spread))
        for side in (1, -1)
    ]
    return max(ends, key=lambda end: math.hypot(*end))


def format_top_view(design: TrunkDesign, options: MakeOptions) -> str:
    """The open housing seen from the trunk, dorsal to the right, as SVG."""
    layout = find_layout(design, options)
    size = 2 * _SCALE * (layout.radius + _MARGIN)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{size:.0f}" height="{size + 70:.0f}" '
        f'viewBox="{-size / 2:.0f} {-size / 2:.0f} {size:.0f} {size + 70:.0f}" font-family="sans-serif" '
        'font-size="20" text-anchor="middle">',
        f'<rect x="{-size / 2:.0f}" y="{-size / 2:.0f}" width="100%" height="100%" fill="white"/>',
        '<defs><marker id="head" orient="auto" markerWidth="5" markerHeight="5" refX="2" refY="2.5">'
        '<path d="M0,0 L5,2.5 L0,5 z" fill="#222222"/></marker></defs>',
        _circle((0.0, 0.0), layout.radius, "#222222", 3),
        *(_circle(polar(layout.post, angle, 0.0)[:2], POST, "#222222", 2) for angle in layout.posts),
        *_draw_winders(design, layout, options),
        *_draw_openings(design, layout, options),
        _text((0.0, -layout.radius - _MARGIN - 4.0), "seen from the trunk; arrows: the sense that pulls"),
        _text(
            (0.0, -layout.radius - _MARGIN - 11.0),
            "dashed: motor; full: drum; small: guide above it in the lid; at the wall: posts",
        ),
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def _draw_winders(design: TrunkDesign, layout: HousingLayout, options: MakeOptions) -> list[str]:
    drum, ring = find_drum(design, options), 1e3 * float(design.hole_position[0, 0, 1])
    lines = []
    for k, (angle, axis) in enumerate(zip(design.cable.angles, motor_angles(design), strict=True)):
        color, (x, y, _), (gx, gy, _) = _COLORS[k % 6], polar(layout.ring, axis, 0.0), polar(ring, angle, 0.0)
        tx, ty = find_touch((gx, gy), (x, y), drum.radius)
        arrow = 0.6 * drum.radius
        begin, end = polar(arrow, axis - 1.0, 0.0), polar(arrow, axis + 1.0, 0.0)
        lines += [
            _circle((x, y), options.motor.diameter / 2, "#888888", 2, "8 6"),
            _circle((x, y), drum.radius, color, 4),
            _circle((gx, gy), 3.0, color, 4),
            f'<line x1="{_SCALE * gx:.1f}" y1="{-_SCALE * gy:.1f}" x2="{_SCALE * tx:.1f}" y2="{-_SCALE * ty:.1f}" '
            f'stroke="{color}" stroke-width="4"/>',
            f'<path d="M{_SCALE * (x + begin[0]):.1f},{-_SCALE * (y + begin[1]):.1f} A{_SCALE * arrow:.1f},'
            f'{_SCALE * arrow:.1f} 0 0 0 {_SCALE * (x + end[0]):.1f},{-_SCALE * (y + end[1]):.1f}" fill="none" '
            'stroke="#222222" stroke-width="3" marker-end="url(#head)"/>',
            _text((x, y - drum.radius - 5.0), f"motor {k + 1}"),
            _text(polar(ring - 7.5 - 7.5 * abs(math.cos(angle)), angle, 0.0)[:2], f"guide {k + 1}"),
        ]
    return lines


def _draw_openings(design: TrunkDesign, layout: HousingLayout, options: MakeOptions) -> list[str]:
    marks = [(0.0, "dorsal"), (find_port(layout), "wires")]
    if design.gripper is not None:
        marks.append((find_servo(design, options), "servo (lid)"))
    lines = []
    for angle, name in marks:
        low, high = polar(layout.radius, angle, 0.0), polar(layout.radius + 4.0, angle, 0.0)
        lines.append(
            f'<line x1="{_SCALE * low[0]:.1f}" y1="{-_SCALE * low[1]:.1f}" x2="{_SCALE * high[0]:.1f}" '
            f'y2="{-_SCALE * high[1]:.1f}" stroke="#222222" stroke-width="8"/>'
        )
        away = 12.0 + 0.5 * len(name) * abs(math.cos(angle))  # The text is centred there, and wide.
        lines.append(_text(polar(layout.radius + away, angle, 0.0)[:2], name))
    return lines


def _circle(at: tuple[float, float], radius: float, color: str, width: float, dash: str = "none") -> str:
    return (
        f'<circle cx="{_SCALE * at[0]:.1f}" cy="{-_SCALE * at[1]:.1f}" r="{_SCALE * radius:.1f}" fill="none" '
        f'stroke="{color}" stroke-width="{width:g}" stroke-dasharray="{dash}"/>'
    )


def _text(at: tuple[float, float], text: str) -> str:
    return f'<text x="{_SCALE * at[0]:.1f}" y="{-_SCALE * at[1] + 7:.1f}" fill="#222222">{text}</text>'
