"""``spiraltrunk validate``: recordings of motion capture against a model of the trunk."""

from __future__ import annotations

import argparse
import math
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import add_parser, read_number, read_text
from spiraltrunk.cli.output import DONE, Answer, UsageError, add_file_count, complain, format_json, open_out, quote
from spiraltrunk.cli.progress import show_progress
from spiraltrunk.cli.verbs.shape.load import MODELS

if TYPE_CHECKING:
    from spiraltrunk.mocap.protocol.protocol import Protocol
    from spiraltrunk.mocap.session.session import SessionSettings


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(verbs, "validate", _run, "compare recordings of motion capture with a model of the trunk")
    parser.add_argument(
        "takes", type=read_text, nargs="*", metavar="TAKE",
        help="a recording (Motive CSV, or C3D) as RUN=FILE, or a file whose name begins with the run's",
    )  # fmt: skip
    parser.add_argument(
        "--protocol", type=read_text, default="paper", metavar="FILE",
        help="protocol of the session, a TOML file (default: the paper's protocol and a twist)",
    )  # fmt: skip
    parser.add_argument(
        "--axes", type=read_text, metavar="NAME",
        help="axis convention of the recordings, unless the protocol has it: y-up (Motive's own), z-up, x-up, or the "
        "file's axes that are right, up and towards the viewer, such as x,-z,y; --axes=-y,x,z where the first has a "
        "minus",
    )  # fmt: skip
    parser.add_argument(
        "--model", choices=MODELS, default="reference", help="model to compare with (default reference)"
    )
    parser.add_argument(
        "--friction", type=read_number, metavar="MU",
        help="coefficient between cables and holes, for statics (default: the design's)",
    )  # fmt: skip
    parser.add_argument(
        "--alignment", type=read_text, metavar="HOW",
        help="base, run or shape, the last two also on chosen sections, such as run:1-5 (default: the protocol's)",
    )  # fmt: skip
    parser.add_argument(
        "--rotations", choices=("quaternion", "ignore"),
        help="ignore: do not read the rotations of rigid bodies, as for exports with Euler angles",
    )  # fmt: skip
    parser.add_argument(
        "--design", type=read_text, metavar="DESIGN", help="preset or TOML file (default: the protocol's)"
    )
    parser.add_argument("--plan", action="store_true", help="no takes: print a checklist of the session")
    parser.add_argument(
        "--out", type=read_text, metavar="DIR", help="write the report, or with --plan the checklist, there"
    )


def _run(arguments: argparse.Namespace) -> Answer:
    if arguments.plan == bool(arguments.takes):
        what = "takes given with --plan" if arguments.takes else "no take given"
        raise UsageError(f"{what}; allowed: one TAKE or more, or --plan alone")
    from spiraltrunk.design import load_design
    from spiraltrunk.mocap.protocol.toml import load_protocol
    from spiraltrunk.mocap.session.session import SessionSettings
    from spiraltrunk.mocap.signal.registration import read_alignment

    protocol = load_protocol(arguments.protocol)
    design = load_design(arguments.design or protocol.design)
    _check_alignment(arguments.alignment, design.n_section)
    settings = SessionSettings(
        design=design, axes=arguments.axes, model=arguments.model,
        alignment=None if arguments.alignment is None else read_alignment(arguments.alignment),
        friction=arguments.friction, rotations=arguments.rotations,
    )  # fmt: skip
    return _plan(arguments, protocol, settings) if arguments.plan else _compare(arguments, protocol, settings)


def _check_alignment(text: str | None, n_section: int) -> None:
    """Refuse sections that the design has not."""
    most = max((int(number) for number in re.findall(r"[0-9]{1,9}", text or "")), default=0)
    if most > n_section:
        allowed = f"sections 1 to {n_section}, as the design has, three or more, such as run:1-5"
        raise UsageError(f"--alignment is {quote(str(text))}, with section {most}; allowed: {allowed}")


def _compare(arguments: argparse.Namespace, protocol: Protocol, settings: SessionSettings) -> Answer:
    from spiraltrunk.mocap.protocol.protocol import sort_takes
    from spiraltrunk.workflows.validate.artifacts import WRITER, list_files, write_comparison
    from spiraltrunk.workflows.validate.comparison import compare_to_model, compute_result

    takes = sort_takes(protocol, arguments.takes)
    names = list_files([protocol.run(name) for name in takes])
    with open_out(arguments.out, WRITER, names) as output, show_progress(sys.stderr) as progress:
        comparison = compare_to_model(protocol, takes, settings, progress)
        progress("report", 0, 1)
        result = compute_result(comparison) if output is None else write_comparison(comparison, output)
    for note in result["notes"]:
        complain(f"note: {note}", DONE)
    return DONE, format_json(result) if arguments.json else add_file_count(_format(result), result, arguments)


def _format(result: dict[str, Any]) -> str:
    """The figures as tables."""
    from spiraltrunk.report import format_table
    from spiraltrunk.workflows.validate.page import format_run, pair_with_paper

    friction = "" if result["friction"] is None else f" with friction {result['friction']:g}"
    title = f"{result['design']}, {result['model']}{friction}, alignment {result['alignment']}; RMSE in mm"
    header = ("run", "shapes", "takes", "sections", "mean", "max", "largest distance", "takes differ")
    rows = [(name, *format_run(run)) for name, run in result["runs"].items()]
    paper = format_table(
        pair_with_paper(result), header=("in mm", "synthetic" if result["is_made_up"] else "here", "paper"),
        title="The paper's figures, of its authors' model and robot", indent=2,
    )  # fmt: skip
    return f"{format_table(rows, header=header, title=title, indent=2)}\n\n{paper}"


def _plan(arguments: argparse.Namespace, protocol: Protocol, settings: SessionSettings) -> Answer:
    from spiraltrunk.design.toml import format_design
    from spiraltrunk.files.atomic import write_file, write_text
    from spiraltrunk.mocap.protocol.checklist import format_checklist, format_schedule
    from spiraltrunk.mocap.protocol.schedule import build_schedule

    schedules = [build_schedule(settings.design, protocol, run) for run in protocol.runs]
    text = format_checklist(settings.design, protocol, schedules)
    files = ["plan.md", "protocol.toml", "schedule.csv", "trunk.toml"]
    with open_out(arguments.out, "validate --plan") as output:
        if output is None:
            files = []
        else:
            copy = _copy_protocol(arguments.protocol, protocol, files[-1])
            with output.draft() as draft:
                write_text(draft / "plan.md", text)
                write_file(draft / "protocol.toml", copy)
                write_text(draft / "schedule.csv", format_schedule(settings.design, schedules))
                write_text(draft / "trunk.toml", format_design(settings.design))
            complain(f"{', '.join(files)} written to {arguments.out}", DONE)
    if not arguments.json:
        return DONE, text.rstrip("\n")
    runs = {
        schedule.run.name: {
            "kind": schedule.run.kind, "theta0_deg": math.degrees(schedule.run.theta_0), "takes": schedule.run.takes,
            "cable_m": [None] if schedule.run.kind == "rest" else schedule.commanded,
        }
        for schedule in schedules
    }  # fmt: skip
    return DONE, format_json({"protocol": protocol.name, "design": settings.design.name, "runs": runs, "files": files})


def _copy_protocol(source: str, protocol: Protocol, design: str) -> bytes:
    """Content of the protocol with ``design``, a file beside it, for its design; unchanged where it has that."""
    from dataclasses import replace

    from spiraltrunk.errors import TakeError
    from spiraltrunk.mocap.protocol.toml import PACKAGED, parse_protocol, read_packaged

    data = read_packaged().encode() if source == PACKAGED else Path(source).read_bytes()
    if parse_protocol(data, source=source).design == design:
        return data
    lines = data.decode("utf-8-sig").splitlines(keepends=True)
    end = next((i for i, line in enumerate(lines) if line.lstrip().startswith("[")), len(lines))
    top = [line for line in lines[:end] if not re.match(r"""\s*(design|"design"|'design')\s*=""", line)]
    data = "".join([f'design = "{design}"\n', *top, *lines[end:]]).encode()
    allowed = "a protocol whose design is a key on one line, above all tables"
    try:
        copy = parse_protocol(data, source=source)
    except TakeError:
        raise UsageError(f"--protocol is {quote(source)}; allowed with --plan --out: {allowed}") from None
    if copy != replace(protocol, design=design, name=copy.name):
        raise UsageError(f"--protocol is {quote(source)}; allowed with --plan --out: {allowed}")
    return data
