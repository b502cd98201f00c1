"""Behaviour cloning of a strategy: networks fitted to the episodes of a data set; policy and curve are written.

Backs the figures of docs/howto/policies.md. A survey with another seed than the demonstrations' draws other worlds.

    spiraltrunk demos wrap-vertical --trials 96 --seed 1777 --format robomimic --timestep-ms 2 --out out/demos
    python benchmarks/train_cloning.py --demos out/demos --most 300 --out out/clone.safetensors
    spiraltrunk survey --strategies policy:out/clone.safetensors --trials 100 --seed 306 --timestep-ms 2
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from spiraltrunk import strategies
from spiraltrunk.report.learning_curve import Curve, build_learning_figure
from spiraltrunk.report.style import write_figure
from spiraltrunk.strategies.policy.policy_files import write_policy
from spiraltrunk.workflows.learn.clone_policy import ClonedPolicy, clone_policy
from spiraltrunk.workflows.learn.cloning import CloningOptions
from spiraltrunk.workflows.learn.episodes import list_episodes, read_episode


def main() -> None:
    """Record what is missing, train, and write."""
    arguments = _read_arguments()
    episodes = [read_episode(file) for file in list_episodes(arguments.demos, arguments.strategy)]
    if arguments.objects:
        episodes = [each for each in episodes if each.object in arguments.objects.split(",")]
    episodes = episodes[: arguments.most]
    began = time.perf_counter()
    policy = clone_policy(
        episodes, strategies.get(arguments.strategy),
        options=CloningOptions(seed=arguments.seed, steps=arguments.steps), on_check=_print_check,
    )  # fmt: skip
    write_policy(arguments.out, policy.description, policy.networks)
    write_figure(_draw(policy), arguments.out.with_suffix(".png"), dpi=100)
    shown = policy.description.provenance["demonstrations"]
    print(f"{shown} of {len(episodes)} demonstrations, trained in {time.perf_counter() - began:.0f} s: {arguments.out}")


def _read_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--strategy", default="wrap-vertical")
    parser.add_argument("--demos", type=Path, required=True, help="folder of spiraltrunk demos")
    parser.add_argument("--most", type=int, default=300, help="episodes to learn from, the first ones (default 300)")
    parser.add_argument("--objects", default="", help="demonstrations of these alone, with commas")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--steps", type=int, default=CloningOptions().steps, help="most updates of each network")
    parser.add_argument("--out", type=Path, required=True)
    return parser.parse_args()


def _print_check(network: str, step: int, train: float, valid: float) -> None:
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
