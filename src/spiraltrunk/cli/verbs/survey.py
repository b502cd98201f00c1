"""``spiraltrunk survey``: many drawn trials, and how often each strategy succeeds."""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import add_parser, read_seed, read_text
from spiraltrunk.cli.output import DONE, INTERRUPTED, Answer, check_folder, complain, format_json, quote
from spiraltrunk.cli.verbs.survey_progress import show_survey

if TYPE_CHECKING:
    from spiraltrunk.workflows.survey.plan import Plan

_MOST_TRIALS, _MOST_WORKERS = 100_000, 64


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(verbs, "survey", _run, "many drawn trials, and how often each strategy succeeds")
    parser.add_argument(
        "--strategies", type=read_text, default="all", metavar="NAMES", help="all (default), or names with commas"
    )
    parser.add_argument(
        "--trials", type=_read_trials, default=50, metavar="N", help="trials of each strategy (default 50)"
    )
    parser.add_argument("--seed", type=read_seed, default=0, help="what all worlds are drawn from (default 0)")
    parser.add_argument(
        "--workers", type=_read_workers, metavar="N", help="processes that share the trials (default: the processors)"
    )
    parser.add_argument(
        "--object", type=read_text, metavar="NAME",
        help="the object of every trial, as in grasp (default: in turn those that the strategy is for)",
    )  # fmt: skip
    parser.add_argument(
        "--out", type=read_text, metavar="DIR",
        help="write trials, table and pictures there; the same command goes on with what was cut off",
    )  # fmt: skip


def _run(arguments: argparse.Namespace) -> Answer:
    if arguments.out is not None:
        check_folder(arguments.out)
    from spiraltrunk.workflows.survey.run_survey import run_survey
    from spiraltrunk.workflows.survey.tables import format_text

    plan = _build_plan(arguments)
    workers = arguments.workers or min(_count_processors(), _MOST_WORKERS)
    folder = None if arguments.out is None else Path(arguments.out)
    seen: list[Sequence[Any]] = [()]
    try:
        with show_survey(sys.stderr, list(plan.objects), plan.trials) as show:

            def watch(rows: Sequence[Any]) -> None:
                seen[0] = rows
                show(rows)

            result = run_survey(plan, workers=workers, folder=folder, watch=watch)
    except KeyboardInterrupt:
        _tell_rest(plan, len(seen[0]), arguments.out)
        raise
    return DONE, format_json(result) if arguments.json else _with_files(format_text(result), result, arguments.out)


def _build_plan(arguments: argparse.Namespace) -> Plan:
    """The plan that was asked for.

    Raises:
        UnknownName: for a strategy or object that does not exist.
        DesignError: for an object that cannot be.
    """
    from spiraltrunk import strategies
    from spiraltrunk.sim.objects.catalogue import parse_object
    from spiraltrunk.workflows.survey.plan import Plan

    names = strategies.NAMES if arguments.strategies == "all" else arguments.strategies.split(",")
    objects = {name: strategies.get(name).objects for name in (name.strip() for name in names)}
    if arguments.object is not None:
        parse_object(arguments.object)
        objects = dict.fromkeys(objects, (arguments.object,))
    return Plan(objects=objects, trials=arguments.trials, seed=arguments.seed)


def _tell_rest(plan: Plan, done: int, out: str | None) -> None:
    """Say what is left of a survey that was cut off."""
    total = plan.trials * len(plan.objects)
    kept = "are lost, as there is no --out" if out is None else f"are in {out}; the same command goes on with the rest"
    complain(f"{done} of {total} trials {kept}", INTERRUPTED)


def _with_files(text: str, result: dict[str, Any], out: str | None) -> str:
    return text if out is None else f"{text}\n{len(result['files'])} files in {out}"


def _count_processors() -> int:
    return len(os.sched_getaffinity(0))


def _read_trials(text: str) -> int:
    return _read_count(text, _MOST_TRIALS)


def _read_workers(text: str) -> int:
    return _read_count(text, _MOST_WORKERS)


def _read_count(text: str, most: int) -> int:
    if not re.fullmatch(r"[0-9]{1,10}", text) or not 1 <= int(text) <= most:
        raise argparse.ArgumentTypeError(f"{quote(text)} given; allowed: a whole number from 1 to {most}")
    return int(text)
