"""``spiraltrunk optimize``: which trunk grasps best."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from spiraltrunk.cli.arguments import add_parser, read_count, read_number, read_seed, read_text
from spiraltrunk.cli.options.engine import add_engine, add_workers, build_engine, count_workers
from spiraltrunk.cli.output import DONE, INTERRUPTED, Answer, add_file_count, complain, format_json
from spiraltrunk.cli.progress import show_progress


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(verbs, "optimize", _run, "search for the trunk that grasps best (extra optimize)")
    parser.add_argument(
        "--out", type=read_text, metavar="DIR", required=True,
        help="keep trials, journal and result there; the same command goes on with an interrupted search",
    )  # fmt: skip
    parser.add_argument(
        "--trials", type=read_count, default=40, metavar="N",
        help="trunks to draw (default 40), those that cannot be made among them; a larger number goes on with a "
        "search that is complete",
    )  # fmt: skip
    parser.add_argument(
        "--objects",
        type=read_count,
        default=20,
        metavar="N",
        help="drawn objects that each trunk is evaluated with (default 20)",
    )
    parser.add_argument(
        "--unseen", type=read_count, default=40, metavar="N",
        help="other objects, for the best trunk beside the paper's at the end (default 40; 0 for none)",
    )  # fmt: skip
    parser.add_argument(
        "--strategy", type=read_text, default="auto", metavar="NAME", help="strategy of all trials (default auto)"
    )
    parser.add_argument(
        "--kind", type=read_text, metavar="NAME", help="class of the drawn objects, as in everyday: (default: all)"
    )
    parser.add_argument(
        "--friction", type=read_number, default=0.0, metavar="MU",
        help="coefficient of friction between cables and holes (default 0)",
    )  # fmt: skip
    parser.add_argument("--seed", type=read_seed, default=0, help="seed of objects, worlds and search (default 0)")
    add_workers(parser)
    add_engine(parser)


def _run(arguments: argparse.Namespace) -> Answer:
    from spiraltrunk.workflows.optimize.optimize import run_search
    from spiraltrunk.workflows.optimize.settings import SearchSettings
    from spiraltrunk.workflows.optimize.tables import format_text

    settings = SearchSettings(
        candidates=arguments.trials, objects=arguments.objects, unseen=arguments.unseen, strategy=arguments.strategy,
        kind=arguments.kind, friction=float(arguments.friction), seed=arguments.seed,
    )  # fmt: skip
    engine, workers = build_engine(arguments), count_workers(arguments)
    try:
        with show_progress(sys.stderr) as progress:
            result = run_search(settings, arguments.out, workers=workers, engine=engine, progress=progress)
    except KeyboardInterrupt:
        complain(f"what has ended is in {arguments.out}; the same command goes on with the rest", INTERRUPTED)
        raise
    if arguments.json:
        return DONE, format_json(result)
    return DONE, add_file_count(format_text(result), result, arguments, "\n")
