"""The equilibrium model is where MuJoCo comes to rest: 200 drawn pulls, tilts and loads, and some with friction.

The model has the simulation's hinges, holes and winders, and with friction its holes' stiffness, which the time step
bounds. Without friction the simulation's joint limits are made a thousand times as stiff, its joints heavy for that, so
that they end within a thousandth of a degree of the limit instead of some tenths past it; where a trunk rests does not
depend on its inertia. Cables are pulled together at an even speed. With friction limits are 100 times as stiff, joints
ten times as heavy, and one cable is pulled after the other along soft ramps.

With all three cables pulled against each other many shapes balance, and with friction even more; which is found depends
on the way there. So the model is loaded the same way, quasi-statically (`statics.QuasiStatic`): its winders turn as
fast as the simulation's, its joints are damped as much; and the simulation, without friction while it moves fast, is
damped so much that its inertia hardly counts. Told beside it is how many the model finds in one step from the straight
trunk, and with friction how many in small increments. Without friction it also starts from MuJoCo's rest: where it
stays within the claim, its forces balance there, and the rest is an equilibrium of the model, be it another than the
one it came to. Exits with 1 where a rest is no such equilibrium, and with 130 when interrupted.
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import os
import signal
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.files.atomic import atomic_file
from spiraltrunk.model import statics
from spiraltrunk.model.kinematics.frames import base_orientation
from spiraltrunk.model.kinematics.shape import Forces, History, Shape, Status
from spiraltrunk.model.statics import equilibrium
from spiraltrunk.model.statics.kernels.batch import find_ends
from spiraltrunk.model.statics.kernels.laws.energy import (
    Case,
    Control,
    Friction,
    Trunk,
    add_penalty,
    find_excess,
    linearise,
    place,
    room_for_work,
)
from spiraltrunk.model.statics.kernels.laws.joint_limits import reduce
from spiraltrunk.model.statics.kernels.projected_newton import descend, guarded_factor, room_for_steps
from spiraltrunk.model.statics.loads import read_forces
from spiraltrunk.sim.relaxation.relax import LoadStep, RelaxationOptions, RelaxationRig, Relaxed
from spiraltrunk.sim.robot.trunk import TrunkOptions

BAR = {"free": 0.5e-3, "friction": 2e-3}
"""Largest distance of any section's end, without and with friction [m]."""

MU = 0.15
"""Coefficient of the cases with friction [-]."""

FREE = RelaxationOptions(
    pull_speed=0.005, tension_speed=1.0, armature_factor=100.0, limit_factor=1000.0, damping_factor=8.0,
    brake_factor=40.0, time_most=300.0, has_gripper=False,
)  # fmt: skip
"""How the trunk is brought to rest without friction."""

SLOW = RelaxationOptions(
    pull_speed=0.375e-3, tension_speed=0.75e-3, has_smooth_ramps=True, armature_factor=10.0, limit_factor=100.0,
    time_most=300.0, has_gripper=False,
)  # fmt: skip
"""The same with friction: a trunk that swings, be it from a sudden start or a limit, shakes cables loose."""

QUASI_STATIC = {
    kind: statics.QuasiStatic(
        damping_time=rig.brake_factor * rig.damping_factor * PAPER.joint.damping_time, pull_speed=rig.pull_speed,
        tension_speed=rig.tension_speed,
    )
    for kind, rig in (("free", FREE), ("friction", SLOW))
}  # fmt: skip
"""The same for the model."""

TRUNK = TrunkOptions()

OPTIONS = statics.StaticsOptions(
    has_hinges=True, hole_set_back=TRUNK.hole_set_back, cable_stiffness=TRUNK.cable_gain, increment=2.5e-4
)


def draw_case(kind: str, trial: int) -> dict[str, Any]:
    """Pulls to 100 mm or tensions to 20 N on any cables, any tilt and roll, a load on every other trunk.

    With friction one cable is pulled after the other, up to 60 mm.
    """
    rng = np.random.default_rng([11, trial])
    used = rng.integers(1, 2**PAPER.n_cable) >> np.arange(PAPER.n_cable) & 1 == 1
    by_tension = bool(rng.integers(2)) and kind == "free"
    amount = rng.uniform(0.0, 20.0 if by_tension else 0.100 if kind == "free" else 0.060, PAPER.n_cable)
    return {
        "kind": kind, "trial": trial, "by_tension": by_tension, "used": used.tolist(), "amount": amount.tolist(),
        "theta_0": math.pi / 2 - float(rng.uniform(0.0, math.pi)), "roll": float(rng.uniform(-math.pi, math.pi)),
        "mass": float(rng.uniform(0.0, 0.5)) * int(rng.integers(2)), "section": int(rng.integers(PAPER.n_section)),
        "order": rng.permutation(PAPER.n_cable).tolist(),
    }  # fmt: skip


def design_of(case: dict[str, Any]) -> TrunkDesign:
    """The paper's trunk, with friction where the case has it."""
    return replace(PAPER, cable=replace(PAPER.cable, friction=MU if case["kind"] == "friction" else 0.0))


def commands(case: dict[str, Any]) -> list[np.ndarray]:
    """What each cable is given, stage by stage; nan is slack."""
    used, amount = np.array(case["used"]), np.array(case["amount"])
    if case["kind"] == "free":
        return [np.where(used, amount, np.nan)]
    out = [np.full(PAPER.n_cable, np.nan)]
    for c in case["order"]:
        if used[c]:
            out.append(out[-1].copy())
            out[-1][c] = amount[c]
    return out[1:]


def simulate(case: dict[str, Any]) -> tuple[Relaxed, statics.StaticsOptions]:
    """Where MuJoCo comes to rest, and the options of the model whose holes hold as stiffly before the cables slide."""
    options = replace(FREE if case["kind"] == "free" else SLOW, trunk=TRUNK)
    loads = np.zeros(PAPER.n_section)
    loads[case["section"]] = case["mass"]
    rig = RelaxationRig(design_of(case), theta_0=case["theta_0"], roll=case["roll"], loads=loads, options=options)
    name = "tension" if case["by_tension"] else "pull"
    same = OPTIONS if case["kind"] == "free" else replace(OPTIONS, hole_stiffness=rig.friction.stiffness)
    return rig.relax([LoadStep(**{name: values}) for values in commands(case)]), same


def loads_of(case: dict[str, Any]) -> statics.Loads:
    """The point mass of a case."""
    return statics.Loads(mass=case["mass"], section=case["section"])


def predict(case: dict[str, Any], options: statics.StaticsOptions, start: Shape | None = None) -> Shape:
    """Where the equilibrium model puts the trunk, through the same stages."""
    for values in commands(case):
        is_slack = np.isnan(values)
        given: dict[str, np.ndarray] = {"tension": np.where(is_slack, 0.0, values)}
        if not case["by_tension"]:
            most = np.where(is_slack, 0.0, PAPER.cable.tension_max)
            given = {"pull": np.where(is_slack, 0.0, values), "by_tension": is_slack, "tension": most}
        start = statics.solve(
            design_of(case), **given, theta_0=case["theta_0"], roll=case["roll"], loads=loads_of(case), start=start,
            options=options,
        )  # fmt: skip
    assert start is not None
    return start


def hinge_bends(joint_rotation: np.ndarray) -> np.ndarray:
    """Bends of the two hinges of every joint about y and z, shape (n_joint, 3) [rad]; the last is no torsion."""
    turn, even = joint_rotation, np.arange(len(joint_rotation)) % 2 == 0
    y = np.where(even, np.arctan2(-turn[:, 2, 0], turn[:, 2, 2]), np.arctan2(turn[:, 0, 2], turn[:, 2, 2]))
    z = np.where(even, np.arctan2(-turn[:, 0, 1], turn[:, 1, 1]), np.arctan2(turn[:, 1, 0], turn[:, 1, 1]))
    return np.stack([y, z, np.zeros_like(y)], axis=-1)


def balance(case: dict[str, Any], rest: Relaxed) -> tuple[float, float]:
    """What the equilibrium model makes of MuJoCo's rest, with shut joints held as far open as they are there.

    Returns:
        The largest moment that it misses there, of shut joints along their rims alone, as across them their faces press
        [N m]; and the distance of the section ends to its own equilibrium, one step of Newton's away [m].
    """
    trunk, bend, count = equilibrium.build_trunk(PAPER, OPTIONS), hinge_bends(rest.shape.joint_rotation), PAPER.n_cable
    tension = np.maximum(rest.cable_tension, 0.0)
    posed = _pose(case, trunk, tension)
    work, system = room_for_work(PAPER.n_joint, count, 2), room_for_steps(PAPER.n_joint, count, 2, trunk.stiffness)
    linearise(bend, posed, tension, work)
    there = np.empty((2, PAPER.n_section, 3))
    find_ends(work.frames, trunk.length, there[0])
    reduce(bend, trunk, work, system)
    find_excess(work.gap, posed.control, tension, system)
    missing = float(np.abs(system.gradient).max())
    add_penalty(system, posed.control, TRUNK.cable_gain, work.hessian)
    guarded_factor(work, system.weight)
    descend(bend, trunk, work, system)
    step, normal = system.step.reshape(-1, 2), system.normal
    along = step[:, 1:] * np.stack([-normal[:, 1], normal[:, 0]], axis=-1)
    bend[:, :2] += np.where(system.pressed[:, None], along, step)
    place(bend, posed.base, trunk, work)
    find_ends(work.frames, trunk.length, there[1])
    return missing, float(np.linalg.norm(there[1] - there[0], axis=-1).max())


def _pose(case: dict[str, Any], trunk: Trunk, tension: np.ndarray) -> Case:
    """The case as the model's kernels read it, its winders mere springs where they pull by length."""
    fields, hold = read_forces(PAPER, loads_of(case)), np.zeros((PAPER.n_joint, PAPER.n_cable))
    gone = case["by_tension"] | (tension <= 0)
    length, most = np.zeros(PAPER.n_cable), np.full(PAPER.n_cable, PAPER.cable.tension_max)
    return Case(
        base_orientation(case["theta_0"], case["roll"]), trunk,
        (np.array(fields.direction), np.array(fields.factor), np.array(fields.moment)),
        Control(gone, length, most, np.zeros(PAPER.n_cable)), Friction(hold, hold.copy(), hold.copy(), 0.0),
    )  # fmt: skip


def distance(first: Shape, second: Shape) -> float:
    """Largest distance of two shapes' section ends [m]."""
    return float(np.linalg.norm(first.points - second.points, axis=-1).max())


def compare(kind: str, trial: int) -> dict[str, Any]:
    """One case as a row of the table."""
    case = draw_case(kind, trial)
    rest, options = simulate(case)
    alone = predict(case, replace(options, quasi_static=QUASI_STATIC[kind]))
    row = case | {
        "simulated": Status(int(rest.shape.status)).name, "solved": Status(int(alone.status)).name,
        "distance_m": distance(alone, rest.shape), "shut": int(rest.shape.is_shut.sum()),
        "past_limit_deg": math.degrees(max(float(rest.shape.joint_angle.max()) - PAPER.joint_limit, 0.0)),
        "tension_n": rest.cable_tension.tolist(), "tension_solved_n": _tension(alone).tolist(),
    }  # fmt: skip
    row["other_way_m"] = distance(predict(case, options), rest.shape)
    if kind == "friction":
        return row
    near = distance(predict(case, options, start_at(rest)), rest.shape)
    row["nearest_m"] = min(row["distance_m"], near)
    return row | dict(zip(("unbalance_nm", "same_limit_m"), balance(case, rest), strict=True))


def start_at(rest: Relaxed) -> Shape:
    """MuJoCo's rest as a start of the model: its bends and its tensions."""
    idle = np.zeros((PAPER.n_joint, PAPER.n_cable))
    tension = np.clip(rest.cable_tension, 0.0, PAPER.cable.tension_max)
    forces = Forces(
        cable_tension=tension, gap_tension=idle + tension, limit_reaction=idle[:, 0], tip_compliance=np.zeros((3, 3)),
        residual=np.array(0.0),
    )  # fmt: skip
    return replace(rest.shape, forces=forces, history=History(bend=hinge_bends(rest.shape.joint_rotation), anchor=idle))


def _tension(shape: Shape) -> np.ndarray:
    assert shape.forces is not None
    return shape.forces.cable_tension


def summarise(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Median and largest distances, the cases beyond the claim, and those that rest in another equilibrium."""
    out: dict[str, Any] = {}
    for kind, bar in BAR.items():
        own = [row for row in rows if row["kind"] == kind]
        figures = {
            name: {part: float(np.percentile([row[name] for row in own], at)) for part, at in _PARTS.items()}
            for name in ("distance_m", "nearest_m", "same_limit_m", "past_limit_deg", "unbalance_nm")
            if own and name in own[0]
        }
        beyond = [row["trial"] for row in own if not row.get("nearest_m", row["distance_m"]) <= bar]
        elsewhere = [row["trial"] for row in own if not row["distance_m"] <= bar and row["trial"] not in beyond]
        other_way = sum(row["other_way_m"] <= bar for row in own)
        out[kind] = {
            "cases": len(own), "bar_m": bar, **figures, "other_way": other_way, "beyond": beyond, "elsewhere": elsewhere
        }  # fmt: skip
    return out


_PARTS = {"median": 50, "p90": 90, "largest": 100}


_OTHER_WAY = {
    "free": "in one step from the straight trunk",
    "friction": f"in increments of {1e3 * OPTIONS.increment:g} mm",
}


def format_summary(summary: dict[str, Any], rows: Sequence[dict[str, Any]]) -> str:
    """Both tables as text, in mm, with every case beyond the claim."""
    lines = []
    for kind, part in summary.items():
        same = part["cases"] - len(part["beyond"]) - len(part["elsewhere"])
        lines.append(
            f"{kind}: {same} of {part['cases']} within {1e3 * part['bar_m']:g} mm, {len(part['elsewhere'])} in another "
            f"equilibrium of the model, {len(part['beyond'])} in none"
        )
        lines.append(f"  {part['other_way']} {_OTHER_WAY[kind]}")
        for name in ("distance_m", "nearest_m", "same_limit_m", "past_limit_deg", "unbalance_nm"):
            if name in part:
                scale = 1e3 if name.endswith("_m") else 1.0
                values = ", ".join(f"{key} {scale * value:.3g}" for key, value in part[name].items())
                lines.append(f"  {name.replace('_m', '_mm') if scale > 1 else name:<16}{values}")
        told = ("distance_m", "nearest_m", "same_limit_m", "unbalance_nm", "shut", "simulated", "solved")
        for row in rows:
            if row["kind"] == kind and row["trial"] in part["beyond"] + part["elsewhere"]:
                lines.append(f"  trial {row['trial']}: " + ", ".join(f"{key} {row.get(key)}" for key in told))
    return "\n".join(lines)


def run_all(cases: Sequence[tuple[str, int]], workers: int) -> Iterator[dict[str, Any]]:
    """Rows as the cases end; leaving early drops what has not begun."""
    if workers <= 1:
        yield from (compare(*case) for case in cases)
        return
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_ignore_interrupt)
    try:
        for future in as_completed([pool.submit(compare, *case) for case in cases]):
            yield future.result()
    finally:
        processes = list((pool._processes or {}).values())
        pool.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.terminate()
        for process in processes:
            process.join()


def _ignore_interrupt() -> None:
    """Ctrl-C reaches every process of the terminal; the first one alone answers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def main(argv: Sequence[str] | None = None) -> int:
    """Compare, print, and write statics_parity.json where asked to."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0], allow_abbrev=False)
    parser.add_argument("--trials", type=int, default=200, help="without friction")
    parser.add_argument("--friction-trials", type=int, default=20)
    parser.add_argument("--workers", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--out", type=Path, metavar="DIR", help="write statics_parity.json there")
    asked = parser.parse_args(argv)
    cases = [("free", k) for k in range(asked.trials)] + [("friction", k) for k in range(asked.friction_trials)]
    rows: list[dict[str, Any]] = []
    code = 0
    try:
        for row in run_all(cases, asked.workers):
            rows.append(row)
            told = f"{row['kind']} {row['trial']}: {1e3 * row['distance_m']:.3f} mm"
            print(f"{len(rows)}/{len(cases)} {told}", file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        code = 130
    rows.sort(key=lambda row: (row["kind"], row["trial"]))
    summary = summarise(rows)
    if asked.out is not None:
        with atomic_file(asked.out / "statics_parity.json") as draft:
            draft.write_text(json.dumps({"summary": summary, "cases": rows}, indent=1) + "\n")
    print(format_summary(summary, rows))
    return code or int(any(part["beyond"] for part in summary.values()))


if __name__ == "__main__":
    sys.exit(main())
