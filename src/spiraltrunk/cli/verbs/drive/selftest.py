"""``spiraltrunk drive selftest``: every fault on the twin."""

from __future__ import annotations

import argparse
import math
import sys
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import read_text
from spiraltrunk.cli.output import DONE, FAILED, Answer, format_json
from spiraltrunk.cli.progress import show_progress
from spiraltrunk.cli.verbs.drive.actions import add_action
from spiraltrunk.cli.verbs.drive.robot import check_twin
from spiraltrunk.errors import UnknownName

if TYPE_CHECKING:
    from spiraltrunk.workflows.drive.selftest import FaultResult


def add_selftest(actions: Any, name: str) -> None:
    """Add the action that injects every fault."""
    parser = add_action(actions, name, _run, "inject every fault into the twin, and tell when it is noticed and safe")
    parser.add_argument("--only", type=read_text, nargs="+", metavar="FAULT", help="these faults (default: all)")


def _run(arguments: argparse.Namespace) -> Answer:
    from spiraltrunk.design import load_design
    from spiraltrunk.workflows.drive.selftest import SCENARIOS, run_selftest

    check_twin(arguments)
    names = tuple(arguments.only or SCENARIOS)
    for name in names:
        if name not in SCENARIOS:
            raise UnknownName("fault", name, SCENARIOS)
    with show_progress(sys.stderr) as progress:
        found = run_selftest(load_design(arguments.design), seed=arguments.seed, names=names, progress=progress)
    code = DONE if all(result.holds for result in found.values()) else FAILED
    if arguments.json:
        return code, format_json({"seed": arguments.seed, "faults": {n: _to_json(r) for n, r in found.items()}})
    from spiraltrunk.report import format_table

    rows = [
        (name, _milliseconds(r.detected), _milliseconds(r.safe), _milliseconds(r.bar), r.cause or "-",
         "yes" if r.holds else "NO")
        for name, r in found.items()
    ]  # fmt: skip
    header = ("fault", "noticed [ms]", "safe [ms]", "bar [ms]", "as", "holds")
    return code, format_table(rows, header=header)


def _milliseconds(value: float | None) -> str:
    return "-" if value is None else f"{1e3 * value:.0f}"


def _to_json(result: FaultResult) -> dict[str, Any]:
    return {
        "detected_s": result.detected,
        "safe_s": result.safe,
        "bar_s": result.bar,
        "holds": result.holds,
        "cause": result.cause,
        "tracking_ratio": None if math.isnan(result.tracking) else result.tracking,
        "wound_mm": 1e3 * result.wound,
        "warnings": list(result.warnings),
    }
