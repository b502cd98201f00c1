"""What a physics step of the default grasp costs by part, and how fast the grasp could be at best.

A grasp is run and every control tick's state kept. From these states the physics alone is stepped again, with and
without contacts, and MuJoCo's stages are timed one by one. A step of Gymnasium's humanoid, which many know, tells how
fast the machine is. Ratios are of figures measured in one run, on one core.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import gymnasium
import mujoco
import numpy as np

from spiraltrunk import strategies
from spiraltrunk.design import presets
from spiraltrunk.plant import Observation
from spiraltrunk.report.draft import write_draft
from spiraltrunk.run import run
from spiraltrunk.sim.objects import DEFAULT_OBJECT, parse_object
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.strategies.base import Status
from spiraltrunk.trial import draw_scene

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

Moment = tuple[np.ndarray, np.ndarray]
"""State after a control period, and the actuators' force ranges in it, which the winders change."""


def record_grasp() -> tuple[SimPlant, list[Moment], float]:
    """A plant after the default grasp, its moments, and the wall time of the loop [s]."""
    plant = SimPlant(presets.PAPER, draw_scene(parse_object(DEFAULT_OBJECT), 0))
    moments: list[Moment] = []
    size = mujoco.mj_stateSize(plant.model, STATE)
    spent = 0.0

    def keep(seen: Observation, status: Status) -> None:
        nonlocal spent
        began = time.perf_counter()
        state = np.empty(size)
        mujoco.mj_getState(plant.model, plant.data, state, STATE)
        moments.append((state, plant.model.actuator_forcerange.copy()))
        spent += time.perf_counter() - began

    began = time.perf_counter()
    run(plant, strategies.get("wrap-vertical"), watch=keep)
    return plant, moments, time.perf_counter() - began - spent


def time_physics(model: mujoco.MjModel, moments: Sequence[Moment], period: float) -> float:
    """Wall time of the physics alone, stepped for one control period from each moment [s]."""
    data, count, total = mujoco.MjData(model), round(period / model.opt.timestep), 0.0
    for moment in moments:
        _set(model, data, moment)
        began = time.perf_counter()
        mujoco.mj_step(model, data, count)
        total += time.perf_counter() - began
    return total


def time_stages(model: mujoco.MjModel, moments: Sequence[Moment]) -> dict[str, float]:
    """Mean wall time of each stage of one step [s]."""
    data, totals = mujoco.MjData(model), dict.fromkeys([*STAGES, *PARTS], 0.0)
    for moment in moments:
        _set(model, data, moment)
        mujoco.mj_step(model, data)
        for name, call in (STAGES | PARTS).items():
            began = time.perf_counter()
            call(model, data)
            totals[name] += time.perf_counter() - began
    means = {name: total / len(moments) for name, total in totals.items()}
    means["position"] -= sum(means[name] for name in PARTS)
    return {("position, the rest" if name == "position" else name): mean for name, mean in means.items()}


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
    state, model.actuator_forcerange[:] = moment
    mujoco.mj_setState(model, data, state, STATE)


def measure() -> dict[str, dict[str, float]]:
    """Real-time factors [-] of the grasp and of its floors, and parts of the loop's time [-]."""
    plant, moments, wall = record_grasp()
    model, period = plant.model, plant.control_period
    simulated = len(moments) * period
    physics = time_physics(model, moments, period)
    step = physics / (len(moments) * round(period / model.opt.timestep))
    stages = time_stages(model, moments)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    free = time_physics(model, moments, period)
    parts = {name: cost / step * physics / wall for name, cost in stages.items()}
    parts["integration and rest"] = (physics - physics / step * sum(stages.values())) / wall
    parts["Python loop"] = (wall - physics) / wall
    return {
        "real_time_factor": {
            "grasp": simulated / wall,
            "physics alone": simulated / physics,
            "physics without contacts": simulated / free,
        },
        "part_of_wall_time": parts,
        "step_us": {
            "physics": step * 1e6,
            "humanoid": time_humanoid() * 1e6,
            **{name: cost * 1e6 for name, cost in stages.items()},
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
        with write_draft(arguments.out / "speed.json") as draft:
            draft.write_text(json.dumps(figures, indent=2) + "\n")
    print(format_figures(figures))
    return 0


if __name__ == "__main__":
    sys.exit(main())
