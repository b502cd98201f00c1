"""``spiraltrunk survey``: randomised trials, and the success rate of each strategy."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import add_parser, read_count, read_seed, read_text
from spiraltrunk.cli.output import DONE, INTERRUPTED, Answer, add_file_count, complain, format_json, open_out
from spiraltrunk.cli.verbs.design_options import add_design, add_timestep, choose_timestep, load_robot
from spiraltrunk.cli.verbs.object_check import check_object
from spiraltrunk.cli.verbs.survey_progress import show_survey

if TYPE_CHECKING:
    from spiraltrunk.workflows.survey.plan import SurveyPlan


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(verbs, "survey", _run, "run randomised trials and count how often each strategy succeeds")
    parser.add_argument(
        "--strategies",
        type=read_text,
        default="all",
        metavar="NAMES",
        help="all nine (default), or names with commas, auto among them",
    )
    parser.add_argument(
        "--trials", type=read_count, default=50, metavar="N", help="trials of each strategy (default 50)"
    )
    parser.add_argument("--seed", type=read_seed, default=0, help="seed of all trials (default 0)")
    parser.add_argument(
        "--workers", type=read_count, metavar="N", help="processes that share the trials (default: the processors)"
    )
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


def _run(arguments: argparse.Namespace) -> Answer:
    from spiraltrunk.workflows.survey.resume_log import FILES, WRITER
    from spiraltrunk.workflows.survey.run_survey import MOST_WORKERS, run_survey
    from spiraltrunk.workflows.survey.tables import format_text

    plan = _build_plan(arguments)
    workers = min(len(os.sched_getaffinity(0)), MOST_WORKERS) if arguments.workers is None else arguments.workers
    done = 0
    try:
        with (
            open_out(arguments.out, WRITER, FILES) as output,
            show_survey(sys.stderr, list(plan.objects), plan.trials) as show,
        ):

            def watch(rows: Sequence[Any]) -> None:
                nonlocal done
                done = len(rows)
                show(rows)

            result = run_survey(plan, workers=workers, folder=output, watch=watch)
    except KeyboardInterrupt:
        kept = (
            "are lost, as there is no --out"
            if arguments.out is None
            else f"are in {arguments.out}; the same command goes on with the rest"
        )
        complain(f"{done} of {plan.trials * len(plan.objects)} trials {kept}", INTERRUPTED)
        raise
    return DONE, format_json(result) if arguments.json else add_file_count(format_text(result), result, arguments, "\n")


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
    )
