"""Digests of episodes, to compare two versions of the code: equal where every number is, bit for bit.

``PYTHONPATH=CHECKOUT/src python benchmarks/envs_digest.py > digests.txt``, once for each version on one machine; then
``diff``. Episodes of every environment are driven by a strategy, others by random actions in every control mode.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import gymnasium
import numpy as np

from spiraltrunk import strategies
from spiraltrunk.control.encoding import ControlMode
from spiraltrunk.envs import StrategyAgent, TrunkEnv

DRIVEN = {
    "spiraltrunk/Grasp-v0": ("wrap-vertical", 900), "spiraltrunk/Kick-v0": ("kick", 400),
    "spiraltrunk/Sweep-v0": ("sweep", 700),
}  # fmt: skip
"""Strategy and steps of each driven episode."""

CONSTANT = ("task", "design")
"""Fields of messages that are the same in an episode."""


def main() -> None:
    """Print a line for each episode: its name, its steps and its digest."""
    for name, (strategy, steps) in DRIVEN.items():
        env = make(name)
        env.reset(seed=1)
        agent = StrategyAgent(env, strategies.get(strategy))
        agent.reset()
        print(name, strategy, *follow(env, agent.act, steps), flush=True)
    for mode in ControlMode:
        env = make("spiraltrunk/Grasp-v0", control_mode=mode.value, stage="ground", object="everyday", privileged=True)
        env.reset(seed=1)
        env.action_space.seed(0)
        actions = [0.3 * action for action in (env.action_space.sample() for _ in range(8)) for _ in range(25)]
        print("spiraltrunk/Grasp-v0", mode.value, *follow(env, iter(actions).__next__, len(actions)), flush=True)


def make(name: str, **options: Any) -> TrunkEnv:
    """An environment without wrappers, whose camera observes the object."""
    env = gymnasium.make(name, disable_env_checker=True, camera=True, **options).unwrapped
    assert isinstance(env, TrunkEnv)
    return env


def follow(env: TrunkEnv, act: Any, steps: int) -> tuple[int, str]:
    """Steps of an episode and the digest of all that it told: returned values, messages, ground truth, verdict."""
    digest, count, is_over = hashlib.sha256(), 0, False
    while count < steps and not is_over:
        told = env.step(act())
        count, is_over = count + 1, told[2] or told[3]
        add(digest, (told, env.observation))
    add(digest, (env.plant.trace, env.verdict()))
    return count, digest.hexdigest()[:32]


def add(digest: Any, value: object) -> None:
    """Add a value to a digest, each array by its type, shape and bytes."""
    if isinstance(value, Mapping):
        add(digest, [part for key in sorted(value) for part in (key, value[key])])
    elif isinstance(value, np.ndarray):
        digest.update(f"{value.dtype} {value.shape}".encode() + value.tobytes())
    elif isinstance(value, (tuple, list)):
        for part in value:
            add(digest, part)
    elif is_dataclass(value) and not isinstance(value, type):
        add(digest, [getattr(value, field.name) for field in fields(value) if field.name not in CONSTANT])
    else:
        digest.update(f"{type(value).__name__} {value!r}".encode())


if __name__ == "__main__":
    main()
