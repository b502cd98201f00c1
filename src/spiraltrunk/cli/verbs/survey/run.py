"""Trials of ``spiraltrunk survey``, run here or on a cluster."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.output import (
    DONE,
    INTERRUPTED,
    Answer,
    UsageError,
    add_file_count,
    complain,
    format_json,
    open_out,
    quote,
)
from spiraltrunk.cli.verbs.design_options import choose_timestep, load_robot
from spiraltrunk.cli.verbs.object_check import check_object
from spiraltrunk.cli.verbs.survey.progress import show_survey

if TYPE_CHECKING:
    from spiraltrunk.processes.pool import Engine
    from spiraltrunk.workflows.survey.plan import SurveyPlan


def run_trials(arguments: argparse.Namespace) -> Answer:
    """Run the trials that are not there yet, and tell the rates."""
    from spiraltrunk.workflows.survey.resume_log import FILES, WRITER
    from spiraltrunk.workflows.survey.run_survey import MOST_WORKERS, run_survey
    from spiraltrunk.workflows.survey.tables import format_text

    plan, engine = _build_plan(arguments), _build_engine(arguments)
    counts = plan.count_trials()
    workers = min(len(os.sched_getaffinity(0)), MOST_WORKERS) if arguments.workers is None else arguments.workers
    done = 0
    try:
        with (
            open_out(arguments.out, WRITER, FILES) as output,
            show_survey(sys.stderr, counts) as show,
        ):

            def watch(rows: Sequence[Any]) -> None:
                nonlocal done
                done = len(rows)
                show(rows)

            result = run_survey(plan, workers=workers, folder=output, engine=engine, watch=watch)
    except KeyboardInterrupt:
        kept = (
            "are lost, as there is no --out"
            if arguments.out is None
            else f"are in {arguments.out}; the same command goes on with the rest"
        )
        complain(f"{done} of {sum(counts.values())} trials {kept}", INTERRUPTED)
        raise
    return DONE, format_json(result) if arguments.json else add_file_count(format_text(result), result, arguments, "\n")


def _build_engine(arguments: argparse.Namespace) -> Engine | None:
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


def _build_plan(arguments: argparse.Namespace) -> SurveyPlan:
    """The survey's plan.

    Raises:
        UnknownName: for a strategy or object that does not exist.
        DesignError: for an impossible object or robot, or a number out of range.
        UsageError: for an object that one of the strategies cannot grasp.
    """
    from spiraltrunk import strategies
    from spiraltrunk.sim.objects.catalogue import parse_object
    from spiraltrunk.workflows.grasp.choice.auto import get_strategy, list_objects
    from spiraltrunk.workflows.survey.plan import SurveyPlan

    design = load_robot(arguments)
    names = strategies.NAMES if arguments.strategies == "all" else arguments.strategies.split(",")
    objects = {name: list_objects(name) for name in (name.strip() for name in names)}
    if arguments.object is not None:
        shape = parse_object(arguments.object)
        for name in objects:
            check_object(get_strategy(name, design, shape), design, shape, arguments.object)
        objects = dict.fromkeys(objects, (arguments.object,))
    return SurveyPlan(
        objects=objects,
        trials=arguments.trials,
        seed=arguments.seed,
        design=design,
        timestep=choose_timestep(arguments),
        shard=arguments.shard,
    )
