"""``spiraltrunk bench``: the performance claims."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import add_parser, read_text
from spiraltrunk.cli.output import DONE, FAILED, Answer, check_folder, format_json
from spiraltrunk.cli.progress import show_progress

if TYPE_CHECKING:
    from spiraltrunk.workflows.bench import Claim


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(verbs, "bench", _run, "the performance claims, each as a ratio measured now")
    parser.add_argument("--peers", action="store_true", help="against PyElastica as well (extra peers)")
    parser.add_argument("--out", type=read_text, metavar="DIR", help="write result.json there")


def _run(arguments: argparse.Namespace) -> Answer:
    if arguments.out is not None:
        check_folder(arguments.out)
    from spiraltrunk.files.atomic import atomic_folder
    from spiraltrunk.workflows.bench import CLAIMS, PEERS, check_peers

    if arguments.peers:
        check_peers()
    asked = CLAIMS | PEERS if arguments.peers else CLAIMS
    if arguments.out is None:
        claims = _measure(asked)
    else:
        with atomic_folder(arguments.out, ("result.json",)) as draft:
            claims = _measure(asked)
            (draft / "result.json").write_text(format_json({"claims": claims}) + "\n")
    code = DONE if all(claim["holds"] for claim in claims.values()) else FAILED
    return code, format_json({"claims": claims}) if arguments.json else _format_claims(claims)


def _measure(claims: dict[str, Callable[[], Claim]]) -> dict[str, dict[str, Any]]:
    with show_progress(sys.stderr) as tell:
        measured = {}
        for i, (name, measure) in enumerate(claims.items()):
            tell(name, i, len(claims))
            measured[name] = measure()
    return {
        name: {"ours": claim.ours, "other": claim.other, "ratio": claim.ratio, "bar": claim.bar, "holds": claim.holds}
        for name, claim in measured.items()
    }


def _format_claims(claims: dict[str, dict[str, Any]]) -> str:
    from spiraltrunk.report import format_table

    header = ("claim", "ours", "other", "ratio", "bar", "")
    rows = [
        (name, f"{claim['ours']:.3g}", f"{claim['other']:.3g}", f"{claim['ratio']:.3g}", f"{claim['bar']:g}",
         "holds" if claim["holds"] else "missed")
        for name, claim in claims.items()
    ]  # fmt: skip
    return format_table(rows, header=header)
