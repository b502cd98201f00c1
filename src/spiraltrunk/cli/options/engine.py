"""Options of the commands that run many trials: what runs them, and where."""

from __future__ import annotations

import argparse
import os
from typing import TYPE_CHECKING

from spiraltrunk.cli.arguments import read_count, read_text
from spiraltrunk.cli.output import UsageError, quote
from spiraltrunk.errors import DesignError

if TYPE_CHECKING:
    from spiraltrunk.processes.pool import Engine
    from spiraltrunk.workflows.survey.plan import Shard


def add_engine(parser: argparse.ArgumentParser) -> None:
    """Add ``--engine`` and ``--address``."""
    parser.add_argument(
        "--engine", choices=("local", "ray"), default="local",
        help="what runs the trials: processes of this machine (default), or Ray (extra cluster)",
    )  # fmt: skip
    parser.add_argument(
        "--address", type=read_text, metavar="HOST",
        help="Ray cluster that runs them, as 10.0.0.1:6379, or auto for the one of this node (default: a Ray of its "
        "own on this machine)",
    )  # fmt: skip


def add_workers(parser: argparse.ArgumentParser) -> None:
    """Add ``--workers``."""
    parser.add_argument(
        "--workers", type=read_count, metavar="N", help="processes that share the trials (default: the processors)"
    )


def add_shard(parser: argparse.ArgumentParser) -> None:
    """Add ``--shard``."""
    parser.add_argument(
        "--shard", type=_read_shard, metavar="I/N",
        help="run part I of N alone, from 1/N to N/N, on one of N machines; --merge puts them together",
    )  # fmt: skip


def _read_shard(text: str) -> Shard:
    """A shard, as an argument's type."""
    from spiraltrunk.workflows.survey.plan import parse_shard

    try:
        return parse_shard(text)
    except DesignError as error:
        raise argparse.ArgumentTypeError(f"{quote(text)} given; allowed: {error.allowed}") from None


def build_engine(arguments: argparse.Namespace) -> Engine | None:
    """What runs the trials; None for the pool of this machine.

    Raises:
        UsageError: for an address without Ray, and for a number of workers of a cluster.
        MissingPackage: without Ray, where it is asked for.
    """
    if arguments.engine == "local":
        if arguments.address is not None:
            raise UsageError(f"--address: {quote(arguments.address)} given; allowed: with --engine ray")
        return None
    from spiraltrunk.processes.ray_engine import RayEngine, load_ray

    if arguments.address is not None and arguments.workers is not None:
        raise UsageError("--workers: given with --address; allowed: one of them: a cluster uses all its processors")
    load_ray()  # Refused before anything is written.
    return RayEngine(address=arguments.address)


def count_workers(arguments: argparse.Namespace) -> int:
    """Processes that share the trials."""
    from spiraltrunk.workflows.survey.run_survey import MOST_WORKERS

    return min(len(os.sched_getaffinity(0)), MOST_WORKERS) if arguments.workers is None else int(arguments.workers)
