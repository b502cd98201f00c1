"""``spiraltrunk survey --merge`` and ``--compare``, which read folders of surveys and run nothing."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from pathlib import Path

from spiraltrunk.cli.output import DONE, Answer, UsageError, add_file_count, format_json, open_out, quote

OF_TRIALS = (
    "strategies",
    "trials",
    "seed",
    "workers",
    "object",
    "design",
    "friction",
    "timestep",
    "shard",
    "engine",
    "address",
)
"""Options of the trials that are run."""


def merge(arguments: argparse.Namespace) -> Answer:
    """Merge shards into one survey.

    Raises:
        UsageError: without ``--out``, and with an option of trials.
        SurveyError: where the folders are not all shards of one survey.
    """
    from spiraltrunk.workflows.survey.merge import merge_surveys
    from spiraltrunk.workflows.survey.resume_log import FILES, WRITER
    from spiraltrunk.workflows.survey.tables import format_text

    refuse_others(arguments, OF_TRIALS, "--merge", "--out alone")
    with open_out(arguments.out, WRITER, FILES) as output:
        if output is None:
            raise UsageError("--merge needs --out; allowed: --merge DIR... --out DIR, where the survey is written")
        result = merge_surveys(arguments.merge, output)
    return DONE, format_json(result) if arguments.json else add_file_count(format_text(result), result, arguments, "\n")


def compare(arguments: argparse.Namespace) -> Answer:
    """Compare two surveys.

    Raises:
        UsageError: with an option of trials, and with ``--merge`` or ``--out``.
        SurveyError: where a folder holds no survey.
    """
    from spiraltrunk.workflows.survey.compare.compare_surveys import compare_surveys
    from spiraltrunk.workflows.survey.compare.comparison_text import format_comparison

    refuse_others(arguments, OF_TRIALS, "--compare", "nothing but --json")
    for name in ("merge", "out"):
        if getattr(arguments, name) is not None:
            raise UsageError(f"--compare and --{name} exclude each other; allowed: --compare DIR DIR alone")
    first, second = (Path(folder).resolve() for folder in arguments.compare)
    if first == second:
        raise UsageError(f"--compare: {quote(arguments.compare[0])} given twice; allowed: folders of two surveys")
    result = compare_surveys(*arguments.compare)
    return DONE, format_json(result) if arguments.json else format_comparison(result)


def refuse_others(arguments: argparse.Namespace, names: Iterable[str], option: str, allowed: str) -> None:
    """Refuse options of trials, which a folder's own settings answer.

    Args:
        arguments: what was given, with the ``defaults`` of the options.
        names: the options to refuse, as attributes of the arguments.
        option: the option that they do not go with.
        allowed: what goes with it, in words.

    Raises:
        UsageError: with the first that was given.
    """
    for name in names:
        if getattr(arguments, name) != arguments.defaults[name]:
            given = {"timestep": "timestep-ms"}.get(name, name)
            raise UsageError(f"--{given} is of no use with {option}, which runs nothing; allowed: {allowed}")
