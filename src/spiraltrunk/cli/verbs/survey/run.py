"""Trials of ``spiraltrunk survey``, run here or on a cluster."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.object_check import check_object
from spiraltrunk.cli.options.design import choose_timestep, load_robot
from spiraltrunk.cli.options.engine import build_engine, count_workers
from spiraltrunk.cli.output import (
    DONE,
    INTERRUPTED,
    Answer,
    UsageError,
    add_file_count,
    complain,
    format_json,
    open_out,
)
from spiraltrunk.cli.verbs.survey.progress import show_survey

if TYPE_CHECKING:
    from spiraltrunk.workflows.survey.plan import SurveyPlan


def run_trials(arguments: argparse.Namespace) -> Answer:
    """Run the trials that are missing, and print the rates."""
    from spiraltrunk.workflows.survey.resume_log import FILES, WRITER
    from spiraltrunk.workflows.survey.run_survey import run_survey
    from spiraltrunk.workflows.survey.tables import format_text

    if arguments.shard is not None and arguments.out is None:
        raise UsageError("--shard: given without --out; allowed: --out DIR, where the shard is kept to be merged")
    plan, engine = build_plan(arguments), build_engine(arguments)
    counts = plan.count_trials()
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

            result = run_survey(plan, workers=count_workers(arguments), folder=output, engine=engine, watch=watch)
    except KeyboardInterrupt:
        kept = (
            "are lost, as there is no --out"
            if arguments.out is None
            else f"are in {arguments.out}; the same command goes on with the rest"
        )
        complain(f"{done} of {sum(counts.values())} trials {kept}", INTERRUPTED)
        raise
    for name, own in result["strategies"].items():
        if own["causes"].get("refused") == own["trials"]:
            complain(f"{name}: all {own['trials']} trials were refused before anything moved, see the reasons", DONE)
    return DONE, format_json(result) if arguments.json else add_file_count(format_text(result), result, arguments, "\n")


def build_plan(arguments: argparse.Namespace) -> SurveyPlan:
    """The survey's plan.

    Raises:
        UnknownName: for a strategy or object that does not exist.
        DesignError: for an impossible object or robot, or a number out of range.
        UsageError: for a strategy that is named twice, and an object that one of them cannot grasp.
    """
    from spiraltrunk import strategies
    from spiraltrunk.sim.objects.catalogue import parse_object
    from spiraltrunk.workflows.grasp.choice.auto import get_strategy, list_objects
    from spiraltrunk.workflows.survey.plan import SurveyPlan

    design = load_robot(arguments)
    names = strategies.NAMES if arguments.strategies == "all" else arguments.strategies.split(",")
    names = [name.strip() for name in names]
    if "" in names:
        raise UsageError("a strategy's name is empty; allowed: names with commas between them, or all")
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise UsageError(f"the strategy {twice!r} is named twice; allowed: each once")
    objects = {name: list_objects(name) for name in names}
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
