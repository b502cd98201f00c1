"""Cost of a step of an environment over that of its physics, and memory over many episodes.

``python benchmarks/envs_tick.py [--ticks 1500] [--episodes 700]``

A 50 Hz tick is timed as a whole. Then a twin of the environment repeats it, once to time the calls that advance the
physics in it, and once by steps of MuJoCo alone, from the same state with the same controls. Ratios are of the sums.
Times are the processor's in this thread, so that other work of the computer counts only as far as it takes the caches.
The episodes of the second part have five ticks each; ``--ticks 0`` takes it alone.
"""

from __future__ import annotations

import argparse
import contextlib
import copy
import ctypes
import gc
import resource
import statistics
import time
from pathlib import Path
from typing import NamedTuple

import gymnasium
import mujoco
import numpy as np

from spiraltrunk import strategies
from spiraltrunk.envs import StrategyAgent, TrunkEnv
from spiraltrunk.envs.register import IDS
from spiraltrunk.sim.scene.options import TIMESTEP

BAR = 1.25
"""Largest time of a tick over that of its physics [-]."""

BLOCK = 25
"""Ticks before the twin repeats them [-]: one by one, each environment would find the other's data in the caches."""

MARKS = (100, 300, 500, 700)
"""Episodes after which memory is read [-]."""


class Times(NamedTuple):
    """Mean times of a tick [ms]."""

    whole: float
    """The tick."""
    within: float
    """The calls that advance the physics in it."""
    alone: float
    """The same steps of MuJoCo by themselves, from the same states with the same controls."""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Cost of a step of an environment, and memory over many episodes.")
    parser.add_argument("--ticks", type=int, default=1500)
    parser.add_argument("--episodes", type=int, default=700)
    parser.add_argument("--timestep-ms", type=float, default=1e3 * TIMESTEP, help="step of the physics (default 2)")
    parser.add_argument("--control-mode", default="delta-pose-tension", help="what actions set (default %(default)s)")
    given = parser.parse_args()
    for name in IDS if given.ticks else ():
        env, twin = (make(name, timestep=given.timestep_ms / 1e3, control_mode=given.control_mode) for _ in range(2))
        times = time_ticks(env, twin, given.ticks)
        print(
            f"{name} {given.control_mode}: {times.whole:.2f} ms a tick, ratio {times.whole / times.alone:.3f} to its "
            f"steps of MuJoCo alone ({times.alone:.2f} ms), {times.whole / times.within:.3f} to the physics within "
            f"({times.within:.2f} ms)",
            flush=True,
        )
    print(f"bar of the ratio: {BAR}")
    for count, memory in measure_memory(given.episodes):
        print(f"resident memory after {count} episodes of 5 ticks: {memory:.0f} MB")


def make(name: str, **options: object) -> TrunkEnv:
    """An environment without wrappers."""
    env = gymnasium.make(name, disable_env_checker=True, **options).unwrapped
    assert isinstance(env, TrunkEnv)
    return env


def time_ticks(env: TrunkEnv, twin: TrunkEnv, ticks: int) -> Times:
    """Mean times of a tick while a strategy's actions are followed; the twin repeats the ticks to time the physics."""
    strategy = strategies.get({"grasp": "wrap-vertical", "kick": "kick", "sweep": "sweep"}[env.job])
    env.reset(seed=1)
    twin.reset(seed=1)
    agent = StrategyAgent(env, strategy)
    agent.reset()
    whole, within, alone = [], [], []
    gc.collect()  # Of what was imported; a collection in 40 000 ticks is as long as 20 of them.
    is_over = False
    while len(whole) < ticks and not is_over:
        actions = []
        while len(actions) < BLOCK and not is_over:
            actions.append(agent.act())
            began = time.thread_time()
            *_, is_terminated, is_truncated, _ = env.step(actions[-1])
            whole.append(time.thread_time() - began)
            is_over = agent.is_done or is_terminated or is_truncated
        for action in actions:
            for times, spent in zip((within, alone), time_physics(twin, action), strict=True):
                times.append(spent)
    return Times(*(1e3 * statistics.fmean(times) for times in (whole, within, alone)))


def time_physics(env: TrunkEnv, action: np.ndarray) -> tuple[float, float]:
    """Time of the calls that advance the physics in a step, and that of the same steps of MuJoCo alone [s]."""
    plant = env.plant
    model, data, advance = plant.model, plant.data, plant.advance
    controls, within = [], 0.0

    def timed(duration: float) -> None:
        nonlocal within
        controls.append((data.ctrl.copy(), round(duration / plant.options.timestep)))
        began = time.thread_time()
        advance(duration)
        within += time.thread_time() - began

    before = copy.copy(data)
    plant.advance = timed  # type: ignore[method-assign]
    env.step(action)
    plant.advance = advance  # type: ignore[method-assign]
    began = time.thread_time()
    for ctrl, steps in controls:
        before.ctrl[:] = ctrl
        mujoco.mj_step(model, before, steps)
    alone = time.thread_time() - began
    assert np.array_equal(before.qpos, data.qpos), "the physics alone went elsewhere"
    return within, alone


def measure_memory(episodes: int) -> list[tuple[int, float]]:
    """Episodes of `MARKS`, and the last one, with the resident memory after them, each in a world of its own [MB]."""
    env, taken = make("spiraltrunk/Grasp-v0", episode_s=0.1), []
    action = np.zeros(env.action_space.shape, np.float32)
    for episode in range(episodes):
        env.reset(seed=episode)
        for _ in range(5):
            env.step(action)
        if episode + 1 in (*MARKS, episodes):
            gc.collect()
            taken.append((episode + 1, read_memory()))
    return taken


def read_memory() -> float:
    """Resident memory of this process, without what the C library holds back for later [MB]."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL("libc.so.6").malloc_trim(0)
    statm = Path("/proc/self/statm")
    if statm.exists():
        return int(statm.read_text().split()[1]) * resource.getpagesize() / 1e6
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


if __name__ == "__main__":
    main()
