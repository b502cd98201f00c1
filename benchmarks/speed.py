"""What a physics step of the default grasp costs by part, and how fast the grasp could be at best.

A grasp is run, its physics timed within the loop, and every control tick's state kept. From these states the physics is
stepped again, by turns with and without contacts, and MuJoCo's stages are timed one by one. A step of Gymnasium's
humanoid, which many know, tells how fast the machine is. Ratios are of figures measured in one run, on one core.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import gymnasium
import mujoco
import numpy as np

from spiraltrunk import strategies
from spiraltrunk.control.loop import run
from spiraltrunk.control.messages import Observation
from spiraltrunk.control.strategy import Status
from spiraltrunk.design import presets
from spiraltrunk.files.atomic import atomic_file
from spiraltrunk.sim.objects.catalogue import DEFAULT_OBJECT, parse_object
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.workflows.grasp.world import draw_scene

STATE = mujoco.mjtState.mjSTATE_INTEGRATION

STAGES: dict[str, Callable[..., None]] = {
    "position": mujoco.mj_fwdPosition,
    "velocity": mujoco.mj_fwdVelocity,
    "forces": mujoco.mj_fwdActuation,
    "acceleration": mujoco.mj_fwdAcceleration,
    "constraint solver": mujoco.mj_fwdConstraint,
}
"""Stages of a step in MuJoCo's order; what is left of a step is the integration."""

PARTS: dict[str, Callable[..., None]] = {"tendons": mujoco.mj_tendon, "collision": mujoco.mj_collision}
"""Parts of the stage "position" that are told apart, timed by calling them once more."""

Moment = tuple[np.ndarray, np.ndarray, np.ndarray]
"""State at the start of a control period, the actuators' targets in it, and their force ranges, which winders change.

The targets' jumps from period to period cost the solver iterations, so they belong to the physics.
"""


def record_grasp() -> tuple[SimPlant, list[Moment], float, float]:
    """A plant after the default grasp, its moments, and the wall times of the loop and of the physics in it [s]."""
    plant = SimPlant(presets.PAPER, draw_scene(parse_object(DEFAULT_OBJECT), 0))
    ends: list[Moment] = []
    size, step = mujoco.mj_stateSize(plant.model, STATE), mujoco.mj_step
    kept = stepped = 0.0

    def keep(seen: Observation, status: Status) -> None:
        nonlocal kept
        began = time.perf_counter()
        state = np.empty(size)
        mujoco.mj_getState(plant.model, plant.data, state, STATE)
        ends.append((state, plant.data.ctrl.copy(), plant.model.actuator_forcerange.copy()))
        kept += time.perf_counter() - began

    def timed(model: mujoco.MjModel, data: mujoco.MjData, count: int = 1) -> None:
        nonlocal stepped
        began = time.perf_counter()
        step(model, data, count)
        stepped += time.perf_counter() - began

    began = time.perf_counter()
    mujoco.mj_step = timed
    try:
        run(plant, strategies.get("wrap-vertical"), watch=keep)
    finally:
        mujoco.mj_step = step
    wall = time.perf_counter() - began - kept
    return plant, [(before[0], *after[1:]) for before, after in pairwise(ends)], wall, stepped


def cost_of_contacts(model: mujoco.MjModel, moments: Sequence[Moment], period: float) -> float:
    """Time of the physics over that without contacts, both stepped for a control period from each moment [-]."""
    datas, count, totals = (mujoco.MjData(model), mujoco.MjData(model)), round(period / model.opt.timestep), [0.0, 0.0]
    flags = model.opt.disableflags
    for moment in moments:
        for i, without in enumerate((0, int(mujoco.mjtDisableBit.mjDSBL_CONTACT))):
            model.opt.disableflags = flags | without
            _set(model, datas[i], moment)
            began = time.perf_counter()
            mujoco.mj_step(model, datas[i], count)
            totals[i] += time.perf_counter() - began
    model.opt.disableflags = flags
    return totals[0] / totals[1]


def share_stages(model: mujoco.MjModel, moments: Sequence[Moment], period: float) -> dict[str, float]:
    """Part of each stage in the time of a step [-], in steps drawn evenly from the control period."""
    data, totals, whole = mujoco.MjData(model), dict.fromkeys([*STAGES, *PARTS], 0.0), 0.0
    rng, count = np.random.default_rng(0), round(period / model.opt.timestep)
    for moment in moments:
        _set(model, data, moment)
        mujoco.mj_step(model, data, int(rng.integers(count)))
        began = time.perf_counter()
        mujoco.mj_step(model, data)
        whole += time.perf_counter() - began
        for name, call in (STAGES | PARTS).items():
            began = time.perf_counter()
            call(model, data)
            totals[name] += time.perf_counter() - began
    totals["position"] -= sum(totals[name] for name in PARTS)
    shares = {("position, the rest" if name == "position" else name): part / whole for name, part in totals.items()}
    return shares | {"integration and rest": 1.0 - sum(shares.values())}


def time_humanoid(steps: int = 3000) -> float:
    """Mean wall time of a step of Gymnasium's humanoid, 23 velocities, falling and lying, by MuJoCo's usual solver [s].

    One evaluation a step, where the file asks for four (RK4).
    """
    path = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets" / "humanoid.xml"
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.integrator, model.opt.solver = mujoco.mjtIntegrator.mjINT_EULER, mujoco.mjtSolver.mjSOL_NEWTON
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    began = time.perf_counter()
    mujoco.mj_step(model, data, steps)
    return (time.perf_counter() - began) / steps


def _set(model: mujoco.MjModel, data: mujoco.MjData, moment: Moment) -> None:
    state, ctrl, model.actuator_forcerange[:] = moment
    mujoco.mj_setState(model, data, state, STATE)
    data.ctrl[:] = ctrl


def measure() -> dict[str, dict[str, float]]:
    """Real-time factors [-] of the grasp and of its floors, and parts of the loop's time [-]."""
    plant, moments, wall, physics = record_grasp()
    model, period = plant.model, plant.control_period
    simulated = plant.trace[-1].time
    step = physics / simulated * model.opt.timestep
    shares = share_stages(model, moments, period)
    parts = {name: share * physics / wall for name, share in shares.items()}
    return {
        "real_time_factor": {
            "grasp": simulated / wall,
            "physics alone": simulated / physics,
            "physics without contacts": simulated / physics * cost_of_contacts(model, moments, period),
        },
        "part_of_wall_time": parts | {"Python loop": (wall - physics) / wall},
        "step_us": {
            "physics": step * 1e6,
            "humanoid": time_humanoid() * 1e6,
            **{name: share * step * 1e6 for name, share in shares.items()},
        },
    }


def format_figures(figures: dict[str, dict[str, float]]) -> str:
    """Both tables as text."""
    lines = ["times real time"]
    lines += [f"  {name:<26}{value:8.1f}" for name, value in figures["real_time_factor"].items()]
    lines += ["part of the grasp's wall time"]
    lines += [f"  {name:<26}{100 * value:7.1f} %" for name, value in figures["part_of_wall_time"].items()]
    ours, humanoid = figures["step_us"]["physics"], figures["step_us"]["humanoid"]
    lines.append(f"a physics step takes {ours:.0f} us, {ours / humanoid:.1f} times one of Gymnasium's humanoid")
    return "\n".join(lines)


def main(argv: Sequence[str] | None = None) -> int:
    """Measure, print, and write speed.json where asked to."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0], allow_abbrev=False)
    parser.add_argument("--out", type=Path, metavar="DIR", help="write speed.json there")
    arguments = parser.parse_args(argv)
    figures = measure()
    if arguments.out is not None:
        with atomic_file(arguments.out / "speed.json") as draft:
            draft.write_text(json.dumps(figures, indent=2) + "\n")
    print(format_figures(figures))
    return 0


if __name__ == "__main__":
    sys.exit(main())
