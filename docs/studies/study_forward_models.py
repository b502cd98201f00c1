"""Compares the paper's forward model with the equilibrium: numbers, plots, tables of validation/forward_models.md.

`make docs` runs it; it takes about a minute on one core, once the models are compiled.
"""

from __future__ import annotations

import json
import math
import os
import re
import sys
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from draw_forward_models import draw_bending, draw_distance, draw_shapes, draw_twist

from spiraltrunk.design.presets import PAPER
from spiraltrunk.model import reference, statics
from spiraltrunk.model.kinematics.shape import Shape, Status
from spiraltrunk.model.statics import QuasiStatic, StaticsOptions, pull_sequences
from spiraltrunk.report.shape.shape_plot import build_shape_figure
from spiraltrunk.report.style import write_figure

DOCS = Path(__file__).parents[1]
MUS = (0.0, 0.1, 0.15, 0.2, 0.4)
"""Friction between cables and holes [-]: none, what the design's notes call sensible, and more."""

THETAS_DEG = (90, 0, 45, 135)
"""Angles of the base axis below the horizontal [deg]: hanging, lying, between the two, beyond the vertical."""

PULLS_MM = tuple(range(5, 131, 5))
"""The paper's 26 steps."""

SHARE_PULL_MM = 10
"""Pull at which shares are compared: no joint is shut yet in any model."""

TWISTS_MM = ((60, 10), (60, 30), (60, 60), (30, 10), (100, 20))
"""Pulls of cables 1 and 2."""

TRUNK = pull_sequences.carry_gripper(PAPER)
"""What the equilibrium is solved for: the gripper weighs in both models."""

ORDERS = ("1 then 2", "2 then 1", "together")
MM = 1e3
HANGING = math.pi / 2


def main() -> int:
    """Compute, draw, and put the tables into the page."""
    figures, shapes = compute_figures()
    (DOCS / "studies" / "forward_models.json").write_text(json.dumps(figures, indent=1) + "\n")
    images = DOCS / "images"
    draw_bending(figures, images / "forward_bending.png")
    draw_distance(figures, images / "forward_distance.png")
    draw_twist(figures, images / "forward_twist.png")
    draw_shapes(shapes, images / "forward_shapes.png")
    twisted = pull_sequences.pull_twist(PAPER, 0.06, 0.03, friction=0.1)
    title = "paper, equilibrium with friction 0.1: cable 1 pulled in by 60 mm, then cable 2 by 30 mm"
    write_figure(build_shape_figure(PAPER, twisted, HANGING, title=title), images / "shape.png")
    page = DOCS / "validation" / "forward_models.md"
    if page.exists():
        page.write_text(fill_page(page.read_text(), figures))
    return 0


def compute_figures() -> tuple[dict[str, Any], dict[str, Any]]:
    """Every number of the page, rounded as it is told, and the shapes to draw."""
    bends = {mu: {theta: _bend_on(mu, theta) for theta in THETAS_DEG} for mu in MUS}
    shut = _find_shutting({mu: bends[mu][90] for mu in MUS})
    figures = {
        "mu": list(MUS),
        "pull_mm": list(PULLS_MM),
        "rest_mm": {str(theta): _compare_rest(theta) for theta in THETAS_DEG},
        "share": _compare_shares({mu: bends[mu][90] for mu in MUS}),
        "shut_mm": shut,
        "shut_apart_mm": {_name(mu): _compare_shutting(shut["reference"], shut[_name(mu)]) for mu in MUS},
        "distance": {
            _name(mu): {str(theta): _compare_bends(bends[mu][theta], theta) for theta in THETAS_DEG} for mu in MUS
        },
        "not_converged": {_name(mu): _count_failed(bends[mu]) for mu in MUS},
        "tension_n": {_name(mu): {str(pull): _tension(bends[mu][90], pull) for pull in (60, 129)} for mu in MUS},
        "twist": _compare_twists(),
        "mirror_mm": _measure_mirror(),
        "doubts": _measure_doubts(),
    }
    shapes = {
        "dorsal": {"reference": reference.bend_dorsal(PAPER, 0.06, HANGING)}
        | {_name(mu): bends[mu][90][60] for mu in (0.0, 0.1, 0.4)},
        "twist": {"reference": reference.twist(PAPER, 0.06, 0.03, HANGING)}
        | {_name(mu): pull_sequences.pull_twist(PAPER, 0.06, 0.03, friction=mu) for mu in (0.0, 0.1, 0.4)},
    }
    return figures, shapes


# Bending.


def _bend_on(mu: float, theta_deg: float) -> dict[int, Shape]:
    """Equilibria as cable 1 is pulled in millimetre by millimetre, each from the one before, by pull [mm]."""
    theta_0 = math.radians(theta_deg)
    rest = pull_sequences.rest(PAPER, theta_0, friction=mu)
    found, goal = {0: rest}, rest.cable_change.copy()
    for pull in range(1, PULLS_MM[-1] + 1):
        goal[0] = min(rest.cable_change[0] + pull / MM, 1.01 * PAPER.cable_stroke)
        found[pull] = _lead(found[pull - 1], goal, (0,), mu, theta_0=theta_0)
    return found


def _compare_rest(theta_deg: float) -> float:
    theta_0 = math.radians(theta_deg)
    return _round(_distance(reference.rest(PAPER, theta_0), pull_sequences.rest(PAPER, theta_0)).max(), 2)


def _compare_shares(bends: dict[float, dict[int, Shape]]) -> dict[str, list[float]]:
    """What part of cable 1's pull each joint takes, base to tip [-]."""
    start, end = (reference.bend_dorsal(PAPER, pull / MM, HANGING) for pull in (0, SHARE_PULL_MM))
    taken = {"reference": start.gap - end.gap}
    for mu, bend in bends.items():
        if pull_sequences.find_shut(PAPER, bend[SHARE_PULL_MM]).any():
            raise RuntimeError(f"a joint is shut at {SHARE_PULL_MM} mm with friction {mu}: shares say nothing")
        taken[_name(mu)] = bend[0].gap - bend[SHARE_PULL_MM].gap
    return {name: [_round(share, 4) for share in gap[:, 0] / gap[:, 0].sum()] for name, gap in taken.items()}


def _find_shutting(bends: dict[float, dict[int, Shape]]) -> dict[str, list[int | None]]:
    """Pull at which each joint is first shut, base to tip, None where 130 mm do not shut it [mm]."""
    asked = np.arange(1, PULLS_MM[-1] + 1)
    shut = {"reference": pull_sequences.find_shut(PAPER, reference.bend_dorsal(PAPER, asked / MM, HANGING))}
    for mu, bend in bends.items():
        shut[_name(mu)] = np.array([pull_sequences.find_shut(PAPER, bend[int(pull)]) for pull in asked])
    return {
        name: [int(asked[joint.argmax()]) if joint.any() else None for joint in found.T] for name, found in shut.items()
    }


def _compare_shutting(one: list[int | None], other: list[int | None]) -> int:
    """Largest difference between the pulls that shut a joint, of joints that both shut [mm]."""
    return max(abs(a - b) for a, b in zip(one, other, strict=True) if a is not None and b is not None)


def _compare_bends(bend: dict[int, Shape], theta_deg: float) -> dict[str, Any]:
    """Distance of the section ends between the two models over the paper's 26 pulls, None where not converged [mm]."""
    theta_0 = math.radians(theta_deg)
    far = {
        pull: None
        if _has_failed(bend[pull])
        else _distance(reference.bend_dorsal(PAPER, pull / MM, theta_0), bend[pull])
        for pull in PULLS_MM
    }
    rms = [None if one is None else _round(math.sqrt((one**2).mean())) for one in far.values()]
    known = [one for one in far.values() if one is not None]
    return {
        "rms_mm": rms,
        "mean_rms_mm": _round(np.mean([math.sqrt((one**2).mean()) for one in known])),
        "max_mm": _round(max(one.max() for one in known)),
    }


def _count_failed(bends: dict[int, dict[int, Shape]]) -> int:
    return sum(_has_failed(shape) for bend in bends.values() for shape in bend.values())


def _tension(bend: dict[int, Shape], pull: int) -> float | None:
    return None if _has_failed(bend[pull]) else _round(bend[pull].forces.cable_tension[0])


# Twisting.


def _compare_twists() -> dict[str, Any]:
    found: dict[str, Any] = {"reference": _describe(reference.twist(PAPER, 0.06, 0.03, HANGING))}
    for mu in MUS:
        shapes = {order: _twist(mu, 0.06, 0.03, order) for order in ORDERS}
        found[_name(mu)] = _describe(shapes["1 then 2"]) | {
            "orders": {order: _describe(shape) for order, shape in shapes.items()},
            "tension_n": [_round(value) for value in shapes["1 then 2"].forces.cable_tension[:2]],
            "rms_mm": {f"{one} {two}": _compare_twist(mu, one / MM, two / MM) for one, two in TWISTS_MM},
        }
    return found


def _compare_twist(mu: float, pull_1: float, pull_2: float) -> float | None:
    shape = pull_sequences.pull_twist(PAPER, pull_1, pull_2, friction=mu)
    far = _distance(reference.twist(PAPER, pull_1, pull_2, HANGING), shape)
    return None if _has_failed(shape) else _round(math.sqrt((far**2).mean()))


def _twist(mu: float, pull_1: float, pull_2: float, order: str, options: StaticsOptions | None = None) -> Shape:
    """Cables 1 and 2 brought to the lengths that `pulls.pull_twist` ends with, in any order."""
    first = pull_sequences.pull_dorsal(PAPER, pull_1, friction=mu)
    goal = first.cable_change + np.array([0.0, pull_2, 0.0])
    rest = statics.solve(TRUNK, friction=mu, options=options)
    if order == "together":
        return _lead(rest, goal, (0, 1), mu, options=options)
    leader = 0 if order == "1 then 2" else 1
    return _lead(_lead(rest, goal, (leader,), mu, options=options), goal, (0, 1), mu, options=options)


def _describe(shape: Shape) -> dict[str, Any]:
    """How a twisted trunk is bent: direction by joint from dorsal towards cable 2, and how far out of one plane."""
    along = shape.joint_rotation[:, :, 0]
    direction = np.degrees(np.arctan2(along[:, 2], along[:, 1]))
    points = np.vstack([np.zeros(3), shape.points])
    normal = np.linalg.svd(points - points.mean(axis=0))[2][2]
    out = (points - points.mean(axis=0)) @ normal
    return {
        "direction_deg": [_round(value) for value in direction],
        "base_bend_deg": _round(math.degrees(shape.joint_angle[0])),
        "turn_deg": _round(np.ptp(direction)),
        "out_of_plane_mm": _round(MM * np.abs(out).max()),
        "tilt_deg": _round(math.degrees(math.acos(min(1.0, abs(normal[2]))))),
        "tip_z_mm": _round(MM * shape.points[-1, 2]),
        "converged": not _has_failed(shape),
    }


def _measure_mirror() -> float:
    """Distance of the twist with cables 1 and 2 changed over from the mirror image, friction 0.1: largest, [mm]."""
    shape = _twist(0.1, 0.06, 0.03, ORDERS[0])
    rest = pull_sequences.rest(PAPER, friction=0.1)
    first = _lead(rest, rest.cable_change + np.array([0.0, 0.06, 0.0]), (1,), 0.1)
    other = _lead(first, first.cable_change + np.array([0.03, 0.0, 0.0]), (0, 1), 0.1)
    across = np.array([-math.sqrt(3) / 2, 0.0, 0.5])  # Normal of the plane half-way between cables 1 and 2.
    image = shape.points - 2 * (shape.points @ across)[:, None] * across
    return _round(MM * np.linalg.norm(image - other.points, axis=-1).max(), 2)


def _measure_doubts() -> dict[str, float]:
    """How far choices inside the equilibrium move the twisted trunk, 60 then 30 mm, friction 0.1: largest, [mm]."""
    usual, shape = StaticsOptions(), _twist(0.1, 0.06, 0.03, ORDERS[0])
    changed = {
        "two hinges a joint": StaticsOptions(has_hinges=True),
        "joints that twist too": StaticsOptions(has_torsion=True),
        "holes half as stiff before cables slide": StaticsOptions(hole_stiffness=usual.hole_stiffness / 2),
        "holes twice as stiff": StaticsOptions(hole_stiffness=usual.hole_stiffness * 2),
        "half the increment of load": StaticsOptions(increment=usual.increment / 2),
        "wound at 5 mm/s, joints damped for 0.04 s": StaticsOptions(
            quasi_static=QuasiStatic(damping_time=0.04, pull_speed=5e-3)
        ),
    }
    return {
        name: _round(_distance(shape, _twist(0.1, 0.06, 0.03, ORDERS[0], options)).max(), 2)
        for name, options in changed.items()
    }


# Both.


def _lead(
    start: Shape,
    goal: np.ndarray,
    cables: tuple[int, ...],
    mu: float,
    *,
    theta_0: float = HANGING,
    options: StaticsOptions | None = None,
) -> Shape:
    """From ``start`` the named cables to ``goal`` [m], the others relaxed; in steps of 5 mm at most."""
    relaxed = np.ones(PAPER.n_cable, bool)
    relaxed[list(cables)] = False
    begin, shape = start.cable_change, start
    steps = max(1, math.ceil(float(np.abs(goal - begin)[~relaxed].max()) / 5e-3))
    for step in range(1, steps + 1):
        shape = statics.solve(
            TRUNK, pull=begin + (goal - begin) * step / steps, by_tension=relaxed, theta_0=theta_0,
            tension=np.where(relaxed, 0.0, PAPER.cable.tension_max), friction=mu, start=shape, options=options,
        )  # fmt: skip
    return shape


def _distance(one: Shape, other: Shape) -> np.ndarray:
    """Between the section ends of two shapes, shape (n_section,) [mm]."""
    return MM * np.linalg.norm(one.points - other.points, axis=-1)


def _has_failed(shape: Shape) -> bool:
    return int(shape.status) == Status.NOT_CONVERGED


def _name(mu: float) -> str:
    return f"{mu:g}"


def _round(value: float, digits: int = 1) -> float:
    return round(float(value), digits) + 0.0


# The page.


def fill_page(text: str, figures: dict[str, Any]) -> str:
    """The page with its tables and its numbers put in again; a number stands before the comment that names it."""
    for name, table in format_tables(figures).items():
        text = re.sub(
            rf"(<!-- table {name} -->\n).*?(<!-- end -->)", lambda m, t=table: m[1] + t + m[2], text, flags=re.S
        )
    return re.sub(r"-?[\d.]+(<!-- = (.*?) -->)", lambda m: f"{find_number(figures, m[2]):g}{m[1]}", text)


def find_number(figures: dict[str, Any], path: str) -> float:
    """The number behind keys and indices joined by slashes; ``percent`` before them multiplies by 100."""
    percent, _, rest = path.rpartition(" of ")
    value: Any = figures
    for key in rest.split("/"):
        value = value[int(key)] if isinstance(value, list) else value[key]
    return round(100 * value, 1) if percent else value


def format_tables(figures: dict[str, Any]) -> dict[str, str]:
    """The page's tables by name."""
    names = [_name(mu) for mu in figures["mu"]]
    twist, thetas = figures["twist"], [str(theta) for theta in THETAS_DEG]
    far = {mu: figures["distance"][mu] for mu in names}
    pairs = [f"{one} {two}" for one, two in TWISTS_MM]
    columns = (
        "direction base to tip [deg]",
        "turn [deg]",
        "out of plane [mm]",
        "plane turned by [deg]",
        "tensions [N]",
    )
    return {
        "distance": _format(
            ["mu", *(f"theta_0 = {theta} deg" for theta in thetas)],
            [[mu, *(_tell_distance(far[mu][theta]) for theta in thetas)] for mu in names],
        ),
        "force": _format(
            ["mu", "60 mm", "129 mm"],
            [[mu, *(_tell(figures["tension_n"][mu][pull]) for pull in ("60", "129"))] for mu in names],
        ),
        "twist": _format(["", *columns], [_tell_twist(name, twist[name]) for name in ("reference", *names)]),
        "orders": _format(["mu", *ORDERS], [_tell_orders(mu, twist[mu]["orders"]) for mu in names]),
        "twist-distance": _format(
            ["mu", *(f"{pair.replace(' ', ', ')} mm" for pair in pairs)],
            [[mu, *(_tell(twist[mu]["rms_mm"][pair]) for pair in pairs)] for mu in names],
        ),
        "doubts": _format(
            ["change", "moves the trunk by up to [mm]"],
            [[name, f"{value:g}"] for name, value in figures["doubts"].items()],
        ),
    }  # fmt: skip


def _tell_distance(told: dict[str, Any]) -> str:
    return f"{told['mean_rms_mm']:g} / {told['max_mm']:g}"


def _tell_orders(mu: str, orders: dict[str, Any]) -> list[str]:
    return [mu, *(f"{orders[one]['out_of_plane_mm']:g} mm, {orders[one]['turn_deg']:g} deg" for one in ORDERS)]


def _tell_twist(name: str, told: dict[str, Any]) -> list[str]:
    direction = told["direction_deg"]
    tension = ", ".join(f"{value:g}" for value in told["tension_n"]) if "tension_n" in told else "-"
    shown = name if name == "reference" else f"mu = {name}"
    ends = f"{direction[0]:g} -> {direction[-1]:g}"
    return [shown, ends, *(f"{told[key]:g}" for key in ("turn_deg", "out_of_plane_mm", "tilt_deg")), tension]


def _tell(value: float | None) -> str:
    return "not converged" if value is None else f"{value:g}"


def _format(header: list[str], rows: list[list[str]]) -> str:
    lines = [header, ["---"] * len(header), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


if __name__ == "__main__":
    sys.exit(main())
