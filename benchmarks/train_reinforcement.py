"""Reinforcement learning of a stroke for the kick: soft actor-critic (stable-baselines3) by trial, without examples.

Backs the figures of docs/howto/policies.md. An episode is one choice: six numbers of the stroke for an object as seen
(`strategies.policy.stroke_strategy`). Each drawn world is tried several times. Before that, strokes drawn from a
uniform distribution tell what chance does.

    python benchmarks/train_reinforcement.py --tries 600 --out out/stroke.safetensors
    spiraltrunk survey --strategies policy:out/stroke.safetensors --trials 100
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import torch
from stable_baselines3 import SAC
from stable_baselines3.common.callbacks import BaseCallback

from spiraltrunk.design import presets
from spiraltrunk.files.results import read_versions
from spiraltrunk.report.learning_curve import Curve, build_learning_figure
from spiraltrunk.report.style import write_figure
from spiraltrunk.sim.scene.options import TIMESTEP
from spiraltrunk.strategies.policy.description import Layers, PolicyDescription
from spiraltrunk.strategies.policy.network import Network
from spiraltrunk.strategies.policy.policy_files import write_policy
from spiraltrunk.strategies.policy.stroke_strategy import INPUTS, OUTPUTS, StrokeStrategy
from spiraltrunk.strategies.push.kick import Kick
from spiraltrunk.workflows.learn.stroke_world import N_INPUT, N_OUTPUT, StrokeWorld
from spiraltrunk.workflows.survey.plan import derive_seed

MEAN = np.array([0.5, 0.5, 0.5, 0.1, 0.16, 0.3, 0.17, 0.15, 0.0, 0.0, 0.0, 0.0])
"""Means of the inputs, in SI units."""
SCALE = np.array([0.5, 0.5, 0.5, 0.02, 0.08, 0.1, 0.08, 0.05, 0.02, 0.02, 0.7, 0.7])
"""Scales of the inputs, in SI units."""
TRIES = 6
"""Tries in one drawn world."""
HIDDEN = 64
"""Units of each of two hidden layers."""


class StrokeEnv(gymnasium.Env):
    """One choice of a stroke in a drawn world; the episode ends with its outcome."""

    def __init__(self, seed: int, timestep: float | None) -> None:
        self.observation_space = gymnasium.spaces.Box(-10.0, 10.0, (N_INPUT,), np.float32)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (N_OUTPUT,), np.float32)
        self._seed, self._timestep = seed, timestep
        self._strategy = StrokeStrategy("stroke", describe({}), {"action": build_network([])})
        self.tries: list[tuple[float, bool, str]] = []
        self._world: StrokeWorld | None = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[np.ndarray, dict]:
        """A world for the next try, the present one as long as it was not tried often enough."""
        super().reset(seed=seed)
        number, part = divmod(len(self.tries), TRIES)
        if part == 0 or self._world is None:
            name = Kick.objects[number % len(Kick.objects)]
            world_seed = derive_seed(self._seed, "stroke", number)
            self._world = StrokeWorld(presets.PAPER, name, self._strategy, world_seed, self._timestep)
        return self._observe(), {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict]:
        """The outcome of a stroke."""
        outcome = self._world.strike(np.asarray(action, dtype=float))
        self.tries.append((outcome.reward, outcome.is_success, outcome.reason))
        print(f"{len(self.tries)}: {outcome.reward:.2f} {outcome.reason}", flush=True)
        return self._observe(), outcome.reward, True, False, {"is_success": outcome.is_success}

    def _observe(self) -> np.ndarray:
        return np.clip((self._world.inputs - MEAN) / SCALE, -10, 10).astype(np.float32)


class Keep(BaseCallback):
    """Write the policy now and then, and stop after a time."""

    def __init__(self, every: int, out: Path, minutes: float, provenance: dict[str, Any]) -> None:
        super().__init__()
        self._every, self._out, self._told = every, out, provenance
        self._end = time.monotonic() + 60 * minutes

    def _on_step(self) -> bool:
        if self.num_timesteps % self._every == 0:
            save(self._out, self.model, self._told | {"tries": self.num_timesteps})
        return time.monotonic() < self._end


def describe(provenance: dict[str, Any]) -> PolicyDescription:
    """Description of the policy."""
    taken = ("job", "support", "orientation", "holds", "needs_camera", "objects", "position", "push")
    return PolicyDescription(
        control_mode="stroke", inputs=INPUTS, outputs=OUTPUTS, n_cable=presets.PAPER.n_cable,
        networks={"action": Layers(sizes=(N_INPUT, HIDDEN, HIDDEN, N_OUTPUT), output="tanh")},
        widths=tuple(Kick().widths(presets.PAPER)), provenance=provenance,
        **{key: getattr(Kick, key) for key in taken},
    )  # fmt: skip


def build_network(parameters: list[np.ndarray]) -> Network:
    """The actor's mean as a network."""
    return Network(
        weights=tuple(parameters[::2]), biases=tuple(parameters[1::2]), activation="relu", output="tanh",
        input_mean=MEAN, input_scale=SCALE, output_mean=np.zeros(N_OUTPUT), output_scale=np.ones(N_OUTPUT),
    )  # fmt: skip


def save(out: Path, model: SAC, provenance: dict[str, Any]) -> None:
    """Write the actor's mean as a policy."""
    parts = [*model.actor.latent_pi.parameters(), *model.actor.mu.parameters()]
    network = build_network([part.detach().numpy().astype(float) for part in parts])
    write_policy(out, describe(provenance), {"action": network})


def draw(tries: list[tuple[float, bool, str]], first: int) -> object:
    """Rate of success and reward over the tries, as means over the last 50."""
    window = 50

    def smooth(values: list[float]) -> list[float]:
        return [float(np.mean(values[max(0, i - window + 1) : i + 1])) for i in range(len(values))]

    x = list(range(1, len(tries) + 1))
    rate = smooth([100.0 * is_success for _, is_success, _ in tries])
    reward = smooth([reward for reward, _, _ in tries])
    label = f"mean of the last {window}"
    kind = f"Tries (the first {first} by chance)"
    curves = [
        Curve(title="Success", xlabel=kind, ylabel="Rate [%]", x=x, lines={label: rate}, bar=80.0),
        Curve(title="Reward", xlabel=kind, ylabel="Reward [-]", x=x, lines={label: reward}),
    ]
    return build_learning_figure(curves, "A stroke learned by trial (soft actor-critic)")


def main() -> None:
    """Train, and write policy and curve."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tries", type=int, default=600)
    parser.add_argument("--chance", type=int, default=40, help="first tries, drawn from a uniform distribution")
    parser.add_argument("--minutes", type=float, default=180.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--timestep-ms", type=float)
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    began = time.monotonic()
    timestep = None if arguments.timestep_ms is None else 1e-3 * arguments.timestep_ms
    env = StrokeEnv(888 + arguments.seed, timestep)
    model = SAC(
        "MlpPolicy", env, seed=arguments.seed, learning_starts=arguments.chance, train_freq=1, gradient_steps=15,
        batch_size=128, learning_rate=1e-3, gamma=0.0, target_entropy=-N_OUTPUT,
        policy_kwargs={"net_arch": [HIDDEN] * 2},
    )  # fmt: skip
    told = {
        "method": "soft actor-critic", "training_seed": arguments.seed, "worlds_seed": 888 + arguments.seed,
        "tries_in_a_world": TRIES, "timestep_ms": 1e3 * (timestep or TIMESTEP),
        "versions": read_versions("mujoco", "numpy", "torch", "stable-baselines3"),
    }  # fmt: skip
    model.learn(arguments.tries, callback=Keep(20, arguments.out, arguments.minutes, told))
    save(arguments.out, model, told | {"tries": len(env.tries)})
    write_figure(draw(env.tries, arguments.chance), arguments.out.with_suffix(".png"), dpi=100)
    by_chance = env.tries[: arguments.chance]
    print(f"{len(env.tries)} tries in {time.monotonic() - began:.0f} s")
    print(f"by chance {sum(each[1] for each in by_chance)} of {len(by_chance)}")
    print(f"of the last 100: {sum(each[1] for each in env.tries[-100:])}")


if __name__ == "__main__":
    main()
