"""Behaviour cloning of a strategy: demonstrations are recorded, networks fitted, and policy and curve written.

Backs the figures of docs/howto/policies.md. Recording goes on where it was cut off; worlds of the demonstrations have
seeds of their own (`derive_seed` of ``--seed-worlds``), which no survey with another seed draws.

    python benchmarks/train_cloning.py --demos out/demos --trials 300 --out out/clone.safetensors
    spiraltrunk survey --strategies policy:out/clone.safetensors --trials 100
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from spiraltrunk import strategies
from spiraltrunk.design import presets
from spiraltrunk.errors import SpiralTrunkError
from spiraltrunk.report.learning_curve import Curve, build_learning_figure
from spiraltrunk.report.style import write_figure
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.strategies.policy.policy_files import write_policy
from spiraltrunk.workflows.grasp.trial import run_trial
from spiraltrunk.workflows.learn.clone_policy import ClonedPolicy, clone_policy
from spiraltrunk.workflows.learn.cloning import CloningOptions
from spiraltrunk.workflows.learn.episodes import load_episode, write_episode
from spiraltrunk.workflows.survey.plan import derive_seed


def main() -> None:
    """Record what is missing, train, and write."""
    arguments = _read_arguments()
    _record(arguments)
    files = sorted(arguments.demos.glob("*.npz"))[: arguments.trials]
    episodes = [load_episode(file, arguments.strategy) for file in files]
    if arguments.objects:
        episodes = [each for each in episodes if each.object in arguments.objects.split(",")]
    began = time.perf_counter()
    policy = clone_policy(
        episodes, strategies.get(arguments.strategy),
        options=CloningOptions(seed=arguments.seed, steps=arguments.steps), tell=_tell,
    )  # fmt: skip
    write_policy(arguments.out, policy.description, policy.networks)
    write_figure(_draw(policy), arguments.out.with_suffix(".png"), dpi=100)
    shown = policy.description.provenance["demonstrations"]
    print(f"{shown} of {len(episodes)} demonstrations, trained in {time.perf_counter() - began:.0f} s: {arguments.out}")


def _read_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--strategy", default="wrap-vertical")
    parser.add_argument("--demos", type=Path, required=True)
    parser.add_argument("--trials", type=int, default=300)
    parser.add_argument("--objects", default="", help="demonstrations of these alone, with commas")
    parser.add_argument("--timestep-ms", type=float, default=1.0, help="time step of the demonstrations")
    parser.add_argument("--seed-worlds", type=int, default=777)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--steps", type=int, default=4000)
    parser.add_argument("--out", type=Path, required=True)
    return parser.parse_args()


def _record(arguments: argparse.Namespace) -> None:
    strategy = strategies.get(arguments.strategy)
    for i in range(arguments.trials):
        file, name = arguments.demos / f"{i:04d}.npz", strategy.objects[i % len(strategy.objects)]
        if file.exists():
            continue
        seed = derive_seed(arguments.seed_worlds, strategy.name, i)
        try:
            timestep = 1e-3 * arguments.timestep_ms
            trial = run_trial(presets.PAPER, parse_object(name), strategy=strategy, seed=seed, timestep=timestep)
        except SpiralTrunkError as error:
            print(f"{i} {name}: {error}", flush=True)
            continue
        write_episode(file, trial, name)
        print(f"{i} {name}: {trial.verdict.reason}", flush=True)


def _tell(network: str, step: int, train: float, valid: float) -> None:
    print(f"{network} {step}: {train:.5f} {valid:.5f}", flush=True)


def _draw(policy: ClonedPolicy) -> object:
    curves = [
        Curve(
            title=title, xlabel="Updates", ylabel=loss, x=fit.steps, is_log=True,
            lines={"training, with noise": fit.train, "validation": fit.valid},
        )
        for title, loss, fit in (
            ("Set points", "Mean squared error [-]", policy.clone.action),
            ("Stages", "Cross entropy [-]", policy.clone.stage),
        )
    ]  # fmt: skip
    shown = policy.description.provenance["demonstrations"]
    return build_learning_figure(curves, f"Behaviour cloning from {shown} demonstrations")


if __name__ == "__main__":
    main()
