"""Measures the trunk's stiffness under opposing dorsal and ventral cables: figures of validation/stiffness.md.

`make docs` runs it; it takes some minutes on one core.
"""

from __future__ import annotations

import json
import math
import os
import re
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from scipy.optimize import brentq

sys.path.insert(0, str(Path(__file__).parent))

from draw_stiffness import draw_stiffness
from study_forward_models import find_number

from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.model import statics
from spiraltrunk.model.kinematics.shape import Shape
from spiraltrunk.model.statics.equilibrium import Loads, StaticsOptions
from spiraltrunk.sim.relaxation.relax import LoadStep, RelaxationOptions, RelaxationRig
from spiraltrunk.sim.robot.trunk import TrunkOptions

DOCS = Path(__file__).parents[1]
MUS = (0.0, 0.2)
"""Friction between cables and holes [-]."""

DORSALS = (0.0, 1.0, 2.0, 5.0, 10.0)
"""Tension of the dorsal cable, pulled once the ventral ones are held by length [N]."""

SIMULATED = (0.0, 5.0, 10.0)
"""Of these the ones that are simulated too [N]."""

WAY = 5e-3
"""How far the tip is pushed [m]."""

FORCES = tuple(0.01 * 1.5**k for k in range(18))
"""Forces that push it, one after the other, up to 10 N [N]."""

SIM_FORCES = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
"""The same in the simulation [N]."""

SIDES = {"+x": (1.0, 0.0, 0.0), "-x": (-1.0, 0.0, 0.0), "+y": (0.0, 1.0, 0.0), "-y": (0.0, -1.0, 0.0)}
"""Directions in the sagittal plane, in the frame of `Shape`."""

ACROSS = (0.0, 0.0, 1.0)
TIP = PAPER.gripper.mass
GAIN = TrunkOptions().cable_gain
STEP = 0.2
"""Change of tension that is solved at once [N]: with 2 N and friction, the half curled trunk ends 80 deg off."""

MODES = ("tension", "length")
"""What the motors of the ventral cables hold; the dorsal one holds tension in both."""


@dataclass(frozen=True, kw_only=True)
class Posture:
    """What the ventral cables make of the trunk."""

    words: str
    theta_0: float
    bend_deg: float
    """Ventral bend summed over the joints."""


POSTURES = {
    "straight": Posture(words="hanging straight", theta_0=math.pi / 2, bend_deg=0.0),
    "curled": Posture(words="hanging, half curled", theta_0=math.pi / 2, bend_deg=255.0),
    "lying": Posture(words="base horizontal, half curled", theta_0=0.0, bend_deg=255.0),
}


def main() -> int:
    """Measure, draw, and put the numbers into the page."""
    figures = compute_figures()
    (DOCS / "studies" / "stiffness.json").write_text(json.dumps(figures, indent=1) + "\n")
    draw_stiffness(figures, DOCS / "images" / "stiffness.png")
    page = DOCS / "validation" / "stiffness.md"
    if page.exists():
        page.write_text(fill_page(page.read_text(), figures))
    return 0


def compute_figures() -> dict[str, Any]:
    """Every number of the page, rounded as it is told."""
    figures: dict[str, Any] = {"dorsal_n": list(DORSALS), "simulated_n": list(SIMULATED)}
    for name, posture in POSTURES.items():
        figures[name] = {}
        for mu in MUS:
            wrap = find_wrap(posture, mu)
            rows = {f"{dorsal:g}": measure_model(posture, mu, wrap, dorsal) for dorsal in DORSALS}
            for dorsal in SIMULATED:
                row = rows[f"{dorsal:g}"]
                sides = {mode: row[mode]["side"] for mode in MODES}
                row["simulated"] = measure_simulation(posture, mu, (wrap, dorsal), sides)
            figures[name][f"{mu:g}"] = rows
            print(name, mu, json.dumps(rows), file=sys.stderr, flush=True)
    return figures


# The model.


def design_with(mu: float) -> TrunkDesign:
    """The paper's trunk; the gripper is a mass at its tip."""
    return replace(PAPER, gripper=None, cable=replace(PAPER.cable, friction=mu))


def solve(posture: Posture, mu: float, *, force: np.ndarray | None = None, **given: Any) -> Shape:
    """The equilibrium with the simulation's joints and holes; its winders give without friction, and with it do not."""
    options = StaticsOptions(
        has_hinges=True, hole_set_back=TrunkOptions().hole_set_back, tension_increment=STEP,
        cable_stiffness=GAIN if mu == 0 else math.inf,
    )  # fmt: skip
    loads = Loads(mass=TIP, force=force)
    return statics.solve(design_with(mu), theta_0=posture.theta_0, loads=loads, friction=mu, options=options, **given)


def find_wrap(posture: Posture, mu: float) -> float:
    """Tension of each ventral cable that bends the trunk as the posture says, the dorsal one slack [N]."""
    if posture.bend_deg == 0.0:
        return 0.0

    def miss(tension: float) -> float:
        along = solve(posture, mu, tension=(0.0, tension, tension)).joint_rotation[:, :, 0]
        return -float(np.degrees(np.arctan2(along[:, 1], along[:, 0])).sum()) - posture.bend_deg

    return float(brentq(miss, 0.5, 30.0, xtol=1e-3))


def brace(posture: Posture, mu: float, wrap: float, dorsal: float) -> Shape:
    """The trunk bent by the ventral cables, these then held by length, and the dorsal cable pulled."""
    bent = solve(posture, mu, tension=(0.0, wrap, wrap))
    return solve(posture, mu, start=bent, **_hold("length", mu, bent, dorsal))


def _hold(mode: str, mu: float, shape: Shape, dorsal: float) -> dict[str, Any]:
    tension = shape.forces.cable_tension
    if mode == "tension":
        return {"tension": np.array([dorsal, *tension[1:]])}
    give, most = 1 / GAIN if mu == 0 else 0.0, PAPER.cable.tension_max
    return {
        "pull": shape.cable_change + give * tension, "tension": np.array([dorsal, most, most]),
        "by_tension": np.array([True, False, False]),
    }  # fmt: skip


def push_model(posture: Posture, mu: float, tensions: tuple[float, float], mode: str, side: str) -> float:
    """Stiffness of the braced model towards one side [N/m]."""
    shape = brace(posture, mu, *tensions)
    held = _hold(mode, mu, shape, tensions[1])

    def reach(force: np.ndarray, start: Shape) -> Shape:
        return solve(posture, mu, start=start, force=force, **held)

    return _push_model(shape, reach, np.array({**SIDES, "z": ACROSS}[side]))


def measure_model(posture: Posture, mu: float, wrap: float, dorsal: float) -> dict[str, Any]:
    """Tensions, shift and stiffness of the model."""
    bent, shape = brace(posture, mu, wrap, 0.0), brace(posture, mu, wrap, dorsal)
    tension = shape.forces.cable_tension
    found: dict[str, Any] = {
        "ventral_n": _round(tension[1:].mean()),
        "mean_n": _round(tension.mean()),
        "moved_mm": _round(1e3 * np.linalg.norm(shape.points - bent.points, axis=-1).max()),
    }
    for mode in MODES:
        sides = {side: push_model(posture, mu, (wrap, dorsal), mode, side) for side in (*SIDES, "z")}
        across = sides.pop("z")
        side = min(sides, key=lambda one: sides[one])
        found[mode] = {"side": side, "in_plane": _round(sides[side]), "across": _round(across)}
    return found


def _push_model(rest: Shape, reach: Callable[[np.ndarray, Shape], Shape], side: np.ndarray) -> float:
    """Force over way at the tip that has moved by WAY along the force [N/m]."""
    shapes = {0.0: rest}

    def way(force: float) -> float:
        shapes[force] = reach(force * side, shapes[max(shapes)])
        return float((shapes[force].points[-1] - rest.points[-1]) @ side)

    return _find_stiffness(FORCES, way)


def _find_stiffness(forces: tuple[float, ...], way: Callable[[float], float]) -> float:
    """Force over way where the tip has moved by WAY, or at the largest force where it has not [N/m]."""
    before = (0.0, 0.0)
    for force in forces:
        moved = way(force)
        if moved >= WAY:
            share = (WAY - before[1]) / (moved - before[1])
            return (before[0] + share * (force - before[0])) / WAY
        before = (force, moved)
    return before[0] / max(before[1], 1e-9)


# The simulation.


def measure_simulation(
    posture: Posture, mu: float, tensions: tuple[float, float], sides: dict[str, str]
) -> dict[str, Any]:
    """Stiffness of the simulated trunk where the model has it least, brought there in the same order."""
    wrap, dorsal = tensions
    loads = np.zeros(PAPER.n_section)
    loads[-1] = TIP
    speed = math.inf if mu == 0 else 1.0
    options = RelaxationOptions(has_gripper=False, tension_speed=speed, pull_speed=speed)
    rig = RelaxationRig(design_with(mu), theta_0=posture.theta_0, loads=loads, options=options)
    bent, most = LoadStep(tension=(0.0, wrap, wrap)), PAPER.cable.tension_max
    found = rig.relax([bent])
    held = np.maximum(found.cable_pull + found.cable_tension / GAIN, 0.0)
    braced = [bent, LoadStep(pull=(math.nan, *held[1:]), tension=(dorsal, most, most))]
    told: dict[str, Any] = {"mean_n": _round(rig.relax(braced).cable_tension.mean())}
    for mode in MODES:
        rig.relax(braced)
        if mode == "tension":
            rig.push(np.zeros(3), hold="tension")
        told[mode] = _round(_push_simulation(rig, np.array(SIDES[sides[mode]])))
    return told


def _push_simulation(rig: RelaxationRig, side: np.ndarray) -> float:
    start = rig.push(np.zeros(3)).shape.points[-1]
    return _find_stiffness(SIM_FORCES, lambda force: float((rig.push(force * side).shape.points[-1] - start) @ side))


def _round(value: float) -> float:
    """Three digits are told, and no more than four decimals."""
    return float(f"{round(float(value), 4):.3g}") + 0.0


# The page.


def fill_page(text: str, figures: dict[str, Any]) -> str:
    """The page with its tables and its numbers put in again; a number stands before the comment that names it."""
    for name, table in format_tables(figures).items():
        text = re.sub(
            rf"(<!-- table {name} -->\n).*?(<!-- end -->)", lambda m, t=table: m[1] + t + m[2], text, flags=re.S
        )
    return re.sub(r"-?[\d.]+(<!-- = (.*?) -->)", lambda m: f"{find_number(figures, m[2]):g}{m[1]}", text)


def format_tables(figures: dict[str, Any]) -> dict[str, str]:
    """The page's tables by name."""
    header = (
        "dorsal [N]", "ventral, each [N]", "moved [mm]", "by tension: in plane", "across", "by length: in plane",
        "across", "simulated: by tension", "by length",
    )  # fmt: skip
    tables = {}
    for name in POSTURES:
        for mu, rows in figures[name].items():
            lines = [header, ["---"] * len(header), *(_tell(dorsal, row) for dorsal, row in rows.items())]
            tables[f"{name}-{mu}"] = "".join(f"| {' | '.join(line)} |\n" for line in lines)
    return tables


def _tell(dorsal: str, row: dict[str, Any]) -> list[str]:
    values = [row["ventral_n"], row["moved_mm"], *(row[mode][key] for mode in MODES for key in ("in_plane", "across"))]
    simulated = [f"{row['simulated'][mode]:g}" if "simulated" in row else "" for mode in MODES]
    return [dorsal, *(f"{value:g}" for value in values), *simulated]


if __name__ == "__main__":
    sys.exit(main())
