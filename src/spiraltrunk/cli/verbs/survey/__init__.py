"""``spiraltrunk survey``: randomised trials, and the success rate of each strategy."""

from __future__ import annotations

import argparse
from typing import Any

from spiraltrunk.cli.arguments import add_parser, read_count, read_seed, read_text
from spiraltrunk.cli.options.design import add_design, add_timestep
from spiraltrunk.cli.options.engine import add_engine, add_shard, add_workers
from spiraltrunk.cli.output import Answer
from spiraltrunk.cli.verbs.survey.folders import OF_TRIALS, compare, merge
from spiraltrunk.cli.verbs.survey.run import run_trials


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(verbs, "survey", _run, "run randomised trials and count how often each strategy succeeds")
    parser.add_argument(
        "--strategies",
        type=read_text,
        default="all",
        metavar="NAMES",
        help="all nine (default), or names with commas, auto and policy:FILE.safetensors among them",
    )
    parser.add_argument(
        "--trials", type=read_count, default=50, metavar="N", help="trials of each strategy (default 50)"
    )
    parser.add_argument("--seed", type=read_seed, default=0, help="seed of all trials (default 0)")
    add_workers(parser)
    parser.add_argument(
        "--object", type=read_text, metavar="NAME",
        help="the object of every trial, as in grasp (default: in turn the objects of the strategy)",
    )  # fmt: skip
    add_design(parser)
    add_timestep(parser)
    parser.add_argument(
        "--out", type=read_text, metavar="DIR",
        help="write trials, table and plots there; the same command resumes an interrupted survey",
    )  # fmt: skip
    add_shard(parser)
    add_engine(parser)
    parser.set_defaults(defaults={name: parser.get_default(name) for name in OF_TRIALS})
    _add_folders(parser)


def _add_folders(parser: argparse.ArgumentParser) -> None:
    """Add the options that run nothing and read folders."""
    parser.add_argument(
        "--merge", type=read_text, nargs="+", metavar="DIR",
        help="run nothing: merge all N shards in these folders into the survey in --out",
    )  # fmt: skip
    parser.add_argument(
        "--compare", type=read_text, nargs=2, metavar="DIR",
        help="run nothing: tell in which strategies two surveys of the same worlds differ significantly",
    )  # fmt: skip


def _run(arguments: argparse.Namespace) -> Answer:
    if arguments.compare is not None:
        return compare(arguments)
    return run_trials(arguments) if arguments.merge is None else merge(arguments)
