"""Cost of a step of an environment over that of its physics, and memory over many episodes.

``python benchmarks/envs_tick.py [--ticks 1500] [--episodes 700]``

A 50 Hz tick is timed as a whole and, in the same ticks, the steps of MuJoCo in it; the ratio is of the two sums.
Times are the processor's in this thread, so that other work of the computer counts only as far as it takes the caches.
The episodes of the second part have five ticks each; ``--ticks 0`` takes it alone.
"""

from __future__ import annotations

import argparse
import contextlib
import ctypes
import gc
import resource
import time
from pathlib import Path

import gymnasium
import numpy as np

from spiraltrunk import strategies
from spiraltrunk.envs import StrategyAgent, TrunkEnv
from spiraltrunk.envs.register import IDS
from spiraltrunk.sim.scene.options import TIMESTEP

BAR = 1.25
"""Largest time of a tick over that of its physics [-]."""

MARKS = (100, 300, 500, 700)
"""Episodes after which memory is read [-]."""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Cost of a step of an environment, and memory over many episodes.")
    parser.add_argument("--ticks", type=int, default=1500)
    parser.add_argument("--episodes", type=int, default=700)
    parser.add_argument("--timestep-ms", type=float, default=1e3 * TIMESTEP, help="step of the physics (default 2)")
    given = parser.parse_args()
    for name in IDS if given.ticks else ():
        physics, whole = time_ticks(make(name, timestep=given.timestep_ms / 1e3), given.ticks)
        print(f"{name}: {1e3 * physics:.2f} ms of physics, {1e3 * whole:.2f} ms a tick, ratio {whole / physics:.3f}")
    print(f"bar of the ratio: {BAR}")
    for count, memory in measure_memory(given.episodes):
        print(f"resident memory after {count} episodes of 5 ticks: {memory:.0f} MB")


def make(name: str, **options: object) -> TrunkEnv:
    """An environment without wrappers."""
    env = gymnasium.make(name, disable_env_checker=True, **options).unwrapped
    assert isinstance(env, TrunkEnv)
    return env


def time_ticks(env: TrunkEnv, ticks: int) -> tuple[float, float]:
    """Mean time of the physics in a tick, and of the tick, while its strategy's actions are followed [s]."""
    strategy = strategies.get({"grasp": "wrap-vertical", "kick": "kick", "sweep": "sweep"}[env.job])
    env.reset(seed=1)
    agent = StrategyAgent(env, strategy)
    agent.reset()
    physics, advance = 0.0, env.plant.advance

    def timed(duration: float) -> None:
        nonlocal physics
        began = time.thread_time()
        advance(duration)
        physics += time.thread_time() - began

    env.plant.advance = timed  # type: ignore[method-assign]
    gc.collect()  # Of what was imported; a collection in 40 000 ticks is as long as 20 of them.
    whole, count = 0.0, 0
    while count < ticks:
        count += 1
        action = agent.act()
        began = time.thread_time()
        *_, is_terminated, is_truncated, _ = env.step(action)
        whole += time.thread_time() - began
        if agent.is_done or is_terminated or is_truncated:
            break
    return physics / count, whole / count


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
