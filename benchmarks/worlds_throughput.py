"""Many worlds of one grasp: worlds x steps per second on the CPU and on MuJoCo Warp, and how far Warp is from C.

A grasp is recorded: its state, set points and tension limits every 0.2 s. Each world starts at one of these moments and
makes steps of 1 ms with its set points held. Measured are

- `mujoco.batch`, one process with threads, at 1 to --most worlds,
- processes with one thread each, the worlds shared among them,
- MuJoCo Warp on its CPU device, and on a GPU where there is one, at 64 to 8192 worlds there.

Warp computes in float32. Its difference from C is told as the largest difference of a joint coordinate after 1 and
after 20 steps, over moments with and without contact, beside that of C from itself with the state rounded to float32.

Each rate stands beside the same per second of processor time, which other work on the machine disturbs little.

Strategies, inverse kinematics and cable friction are Python between the steps: this is the speed of physics alone. Warp
is no dependency of the project; without it, that part is left out and says why:

    python -m venv --system-site-packages warp && warp/bin/pip install mujoco-warp==4.0.0
    PYTHONPATH=src warp/bin/python benchmarks/worlds_throughput.py --out out/worlds
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import mujoco
import numpy as np
from mujoco.batch import Batch

from spiraltrunk import strategies
from spiraltrunk.control.loop import run
from spiraltrunk.control.messages import Observation
from spiraltrunk.control.strategy import Status
from spiraltrunk.design import presets
from spiraltrunk.processes.pool import run_jobs
from spiraltrunk.sim.objects.catalogue import DEFAULT_OBJECT, parse_object
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.workflows.grasp.world import draw_scene

TIMESTEP = 1e-3
"""Time step, that of the published figures [s]."""

PERIOD = 0.2
"""Time between two recorded moments [s]."""

STEPS = 20
"""Steps of a measured call, one control period."""

GOLDEN = (5**0.5 - 1) / 2
"""Multiples of it modulo 1 are spread evenly, however many there are [-]."""

GPU_WORLDS = (64, 256, 1024, 4096, 8192)

CONTACTS, ROWS = 64, 256
"""Contacts and constraint rows of a world that Warp makes room for; the recorded grasp has at most 16 and 62."""


@dataclass(frozen=True, kw_only=True)
class Moments:
    """Recorded moments of a grasp; the first axis is the moment."""

    qpos: np.ndarray
    qvel: np.ndarray
    qacc_warmstart: np.ndarray
    ctrl: np.ndarray
    actuator_forcerange: np.ndarray
    contacts: np.ndarray

    def repeat(self, count: int) -> Moments:
        """As many moments as there are worlds, any number of them spread over the grasp, whose parts cost unlike."""
        chosen = (len(self.qpos) * ((0.5 + np.arange(count) * GOLDEN) % 1.0)).astype(int)
        return Moments(**{name: values[chosen] for name, values in vars(self).items()})


class Job(NamedTuple):
    """Worlds of one process."""

    folder: str
    worlds: int
    seconds: float


def record(until: float) -> tuple[mujoco.MjModel, Moments]:
    """The default grasp, up to a time [s]."""
    strategy = strategies.get("wrap-vertical")
    scene = replace(draw_scene(parse_object(DEFAULT_OBJECT), 0, strategy=strategy), timestep=TIMESTEP)
    plant = SimPlant(presets.PAPER, scene)
    found: dict[str, list[np.ndarray]] = {name: [] for name in Moments.__annotations__}

    class _Enough(Exception):
        pass

    def watch(observation: Observation, status: Status) -> None:
        if observation.time > until:
            raise _Enough
        if round(observation.time / plant.control_period) % round(PERIOD / plant.control_period):
            return
        for name in ("qpos", "qvel", "qacc_warmstart", "ctrl"):
            found[name].append(getattr(plant.data, name).copy())
        found["actuator_forcerange"].append(plant.model.actuator_forcerange.copy())
        found["contacts"].append(np.array(plant.data.ncon))

    with contextlib.suppress(_Enough):
        run(plant, strategy, watch=watch)
    return plant.model, Moments(**{name: np.array(values) for name, values in found.items()})


def save(folder: Path, model: mujoco.MjModel, moments: Moments) -> None:
    mujoco.mj_saveModel(model, str(folder / "model.mjb"))
    np.savez(folder / "moments.npz", **vars(moments))


def load(folder: Path) -> tuple[mujoco.MjModel, Moments]:
    with np.load(folder / "moments.npz") as stored:
        return mujoco.MjModel.from_binary_path(str(folder / "model.mjb")), Moments(**dict(stored))


def build_batch(model: mujoco.MjModel, moments: Moments, worlds: int, threads: int) -> Batch:
    own, batch = moments.repeat(worlds), Batch(model, worlds, threads)
    for name in ("qpos", "qvel", "qacc_warmstart", "ctrl"):
        batch.bind(name)[:] = getattr(own, name)
    batch.expand("actuator_forcerange")[:] = own.actuator_forcerange
    return batch


class Rate(NamedTuple):
    """Worlds x steps per second."""

    per_s: float
    per_processor_s: float


class Clock:
    """Wall and processor time of measured calls."""

    def __init__(self) -> None:
        self.wall = self.processor = 0.0
        self.calls = 0

    @contextlib.contextmanager
    def measure(self) -> Iterator[None]:
        began = time.perf_counter(), time.process_time()
        yield
        self.wall += time.perf_counter() - began[0]
        self.processor += time.process_time() - began[1]
        self.calls += 1

    def compute_rate(self, worlds: int) -> Rate:
        steps = worlds * STEPS * self.calls
        return Rate(steps / self.wall, steps / self.processor)


def measure_batch(model: mujoco.MjModel, moments: Moments, worlds: int, threads: int, seconds: float) -> Rate:
    """The rate of calls that each start anew at the recorded moments, whose cost is that of the grasp."""
    own, batch = moments.repeat(worlds), build_batch(model, moments, worlds, threads)
    bound = {name: batch.bind(name) for name in ("qpos", "qvel", "qacc_warmstart")}
    batch.step(nstep=1)
    clock = Clock()
    while clock.wall < seconds:
        for name, values in bound.items():
            values[:] = getattr(own, name)
        with clock.measure():
            batch.step(nstep=STEPS)
    return clock.compute_rate(worlds)


def measure_job(job: Job) -> Rate:
    model, moments = load(Path(job.folder))
    return measure_batch(model, moments, job.worlds, 1, job.seconds)


def measure_processes(folder: Path, worlds: int, processes: int, seconds: float) -> Rate:
    jobs = [Job(str(folder), max(1, worlds // processes), seconds)] * processes
    rates = [outcome.unwrap() for outcome in run_jobs(measure_job, jobs, processes)]
    return Rate(sum(rate.per_s for rate in rates), sum(rate.per_processor_s for rate in rates) / processes)


def step_in_c(model: mujoco.MjModel, moments: Moments, i: int, steps: int, *, is_rounded: bool = False) -> np.ndarray:
    """Joint coordinates after some steps from a moment, optionally from its state rounded to float32."""
    data = mujoco.MjData(model)
    model.actuator_forcerange[:] = moments.actuator_forcerange[i]
    for name in ("qpos", "qvel", "qacc_warmstart", "ctrl"):
        values = getattr(moments, name)[i]
        getattr(data, name)[:] = values.astype(np.float32) if is_rounded else values
    mujoco.mj_step(model, data, steps)
    return data.qpos.copy()


def put_worlds(warp: Any, mjw: Any, model: mujoco.MjModel, own: Moments) -> tuple[Any, Any]:
    """Warp's model and data with a world for each moment."""
    worlds = len(own.qpos)
    theirs = mjw.put_model(model)
    data = mjw.put_data(model, mujoco.MjData(model), nworld=worlds, nconmax=CONTACTS, njmax=ROWS)
    for name in ("qpos", "qvel", "qacc_warmstart", "ctrl"):
        getattr(data, name).assign(getattr(own, name).astype(np.float32))
    theirs.actuator_forcerange = warp.array(own.actuator_forcerange.astype(np.float32), dtype=warp.vec2)
    return theirs, data


def compare_with_c(warp: Any, mjw: Any, model: mujoco.MjModel, moments: Moments, count: int) -> dict[str, Any]:
    """Largest differences of a joint coordinate [rad or m] from C, median and largest over moments."""
    chosen = np.linspace(0, len(moments.qpos) - 1, count).astype(int)
    told: dict[str, Any] = {}
    for steps in (1, STEPS):
        own = Moments(**{name: values[chosen] for name, values in vars(moments).items()})
        theirs, data = put_worlds(warp, mjw, model, own)
        for _ in range(steps):
            mjw.step(theirs, data)
        found = data.qpos.numpy()
        c = np.array([step_in_c(model, moments, i, steps) for i in chosen])
        rounded = np.array([step_in_c(model, moments, i, steps, is_rounded=True) for i in chosen])
        for name, values in (("warp", found), ("c_from_float32", rounded)):
            error = np.abs(values - c).max(axis=-1)
            for kind, mask in (("free", own.contacts == 0), ("contact", own.contacts > 0)):
                if mask.any():
                    told[f"{name}, {steps} steps, {kind}"] = {
                        "moments": int(mask.sum()), "median": float(np.median(error[mask])),
                        "largest": float(error[mask].max()),
                    }  # fmt: skip
    return told


def measure_warp(warp: Any, mjw: Any, model: mujoco.MjModel, own: Moments, seconds: float) -> Rate:
    """The rate on the present device, a graph of a whole control period on a GPU."""
    theirs, data = put_worlds(warp, mjw, model, own)
    starts = {name: getattr(data, name).numpy() for name in ("qpos", "qvel", "qacc_warmstart")}
    mjw.step(theirs, data)
    graph = None
    if warp.get_device().is_cuda:
        with warp.ScopedCapture() as capture:
            for _ in range(STEPS):
                mjw.step(theirs, data)
        graph = capture.graph
    clock = Clock()
    while clock.wall < seconds:
        for name, values in starts.items():
            getattr(data, name).assign(values)
        warp.synchronize()
        with clock.measure():
            if graph is None:
                for _ in range(STEPS):
                    mjw.step(theirs, data)
            else:
                warp.capture_launch(graph)
            warp.synchronize()
    return clock.compute_rate(len(own.qpos))


def run_warp(model: mujoco.MjModel, moments: Moments, asked: argparse.Namespace) -> dict[str, Any]:
    """Figures of MuJoCo Warp, or why there are none."""
    try:
        import mujoco_warp as mjw
        import warp
    except ModuleNotFoundError as error:
        return {"skipped": f"the package {error.name!r} is not installed: pip install mujoco-warp==4.0.0"}
    warp.config.quiet = True
    warp.init()
    told: dict[str, Any] = {"device": str(warp.get_device()), "difference": {}, "worlds": {}}
    with warp.ScopedDevice("cpu" if not warp.is_cuda_available() else "cuda:0"):
        told["difference"] = compare_with_c(warp, mjw, model, moments, asked.moments)
        worlds = GPU_WORLDS if warp.is_cuda_available() else tuple(n for n in (1, 8, 64) if n <= asked.most)
        for count in worlds:
            rate = measure_warp(warp, mjw, model, moments.repeat(count), asked.seconds)
            tell(f"Warp on {told['device']}, {count} worlds", rate)
            told["worlds"][count] = rate._asdict()
    return told


def tell(what: str, rate: Rate) -> None:
    print(
        f"{what}: {rate.per_s:,.0f} worlds x steps/s, {rate.per_processor_s:,.0f} per second of processor time",
        file=sys.stderr, flush=True,
    )  # fmt: skip


def list_worlds(most: int) -> Sequence[int]:
    return [n for n in (1, 4, 16, 64, 256, 1024, 4096) if n <= most]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("out/worlds"))
    parser.add_argument("--most", type=int, default=256, help="most worlds on the CPU (default 256)")
    parser.add_argument("--seconds", type=float, default=3.0, help="time of each measurement (default 3)")
    parser.add_argument("--until", type=float, default=40.0, help="recorded time of the grasp [s] (default all)")
    parser.add_argument("--moments", type=int, default=16, help="moments at which Warp is compared with C")
    parser.add_argument("--threads", type=int, default=len(os.sched_getaffinity(0)))
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    if not (asked.out / "moments.npz").exists():
        save(asked.out, *record(asked.until))
    model, moments = load(asked.out)
    result: dict[str, Any] = {
        "processors": asked.threads, "moments": len(moments.qpos), "contacts_mean": float(moments.contacts.mean()),
        "timestep_s": model.opt.timestep, "batch": {}, "processes": {},
    }  # fmt: skip
    for worlds in list_worlds(asked.most):
        rate = measure_batch(model, moments, worlds, asked.threads, asked.seconds)
        tell(f"mujoco.batch, {asked.threads} threads, {worlds} worlds", rate)
        result["batch"][worlds] = rate._asdict()
    for processes in dict.fromkeys((1, asked.threads)):
        rate = measure_processes(asked.out, asked.most, processes, asked.seconds)
        tell(f"{processes} processes, {asked.most} worlds", rate)
        result["processes"][processes] = rate._asdict()
    result["warp"] = run_warp(model, moments, asked)
    text = json.dumps(result, indent=2, allow_nan=False)
    (asked.out / "worlds.json").write_text(text + "\n")
    print(text)


if __name__ == "__main__":
    main()
