"""``spiraltrunk bench``: the performance claims."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import add_parser, read_text
from spiraltrunk.cli.output import DONE, FAILED, Answer, format_json, open_out
from spiraltrunk.cli.progress import show_progress

if TYPE_CHECKING:
    from spiraltrunk.files.output_folder import OutputFolder
    from spiraltrunk.workflows.bench import Claim

_KEYS = ("ours", "other", "ratio", "bar", "holds")


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(verbs, "bench", _run, "measure the performance claims, each as a ratio")
    parser.add_argument("--peers", action="store_true", help="also against PyElastica (extra peers)")
    parser.add_argument("--out", type=read_text, metavar="DIR", help="write result.json there, after each claim")


def _run(arguments: argparse.Namespace) -> Answer:
    from spiraltrunk.workflows.bench import CLAIMS, PEERS, check_peers

    if arguments.peers:
        check_peers()
    chosen = CLAIMS | PEERS if arguments.peers else CLAIMS
    with open_out(arguments.out, "bench", ["result.json"]) as output:
        result = _measure(chosen, output)
    claims = result["claims"]
    code = DONE if all(claim["holds"] for claim in claims.values()) else FAILED
    return code, format_json(result) if arguments.json else _format_claims(claims)


def _measure(claims: dict[str, Callable[[], Claim]], output: OutputFolder | None) -> dict[str, Any]:
    """The claims' figures; after each claim the folder holds those so far."""
    measured: dict[str, dict[str, Any]] = {}
    result: dict[str, Any] = {"claims": measured, "complete": not claims}
    with show_progress(sys.stderr) as progress:
        for i, (name, measure) in enumerate(claims.items()):
            progress(name, i, len(claims))
            claim = measure()
            measured[name] = {key: getattr(claim, key) for key in _KEYS}
            result = {"claims": measured, "complete": len(measured) == len(claims)}
            if output is not None:
                _write(output, result)
    return result


def _write(output: OutputFolder, result: dict[str, Any]) -> None:
    from spiraltrunk.files.atomic import write_text

    with output.draft() as draft:
        write_text(draft / "result.json", format_json(result) + "\n")


def _format_claims(claims: dict[str, dict[str, Any]]) -> str:
    from spiraltrunk.report import format_table

    rows = [
        (
            name,
            *(f"{claim[key]:.3g}" for key in _KEYS[:3]),
            f"{claim['bar']:g}",
            "holds" if claim["holds"] else "missed",
        )
        for name, claim in claims.items()
    ]
    return format_table(rows, header=("claim", *_KEYS[:4], ""))
