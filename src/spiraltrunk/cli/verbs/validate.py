"""``spiraltrunk validate``: recordings of motion capture against a model of the trunk."""

from __future__ import annotations

import argparse
import sys
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryFile
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import add_parser, read_number, read_text
from spiraltrunk.cli.output import DONE, Answer, UsageError, check_folder, complain, format_json, quote
from spiraltrunk.cli.progress import show_progress
from spiraltrunk.cli.verbs.shape_load import MODELS

if TYPE_CHECKING:
    from spiraltrunk.mocap.protocol.protocol import Protocol
    from spiraltrunk.mocap.protocol.schedule import Plan
    from spiraltrunk.mocap.session.session import SessionSettings

_MOST_TAKES = 200
_MOST_FRICTION = 2.0


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(verbs, "validate", _run, "recordings of motion capture against a model of the trunk")
    parser.add_argument(
        "takes", type=read_text, nargs="*", metavar="TAKE",
        help="a recording (Motive CSV, or C3D) as RUN=FILE, or a file whose name begins with the run's",
    )  # fmt: skip
    parser.add_argument(
        "--protocol", type=read_text, default="paper", metavar="FILE",
        help="what was done, a TOML file (default: the paper's protocol and a twist)",
    )  # fmt: skip
    parser.add_argument(
        "--axes", type=read_text, metavar="NAME",
        help="axis convention of the recordings, unless the protocol says it: y-up (Motive's own), z-up, x-up, or the "
        "file's axes that are right, up and towards the viewer, such as x,-z,y; --axes=-y,x,z where the first has a "
        "minus",
    )  # fmt: skip
    parser.add_argument("--model", choices=MODELS, default="reference", help="what they are held against (reference)")
    parser.add_argument(
        "--friction", type=read_number, metavar="MU",
        help="coefficient between cables and holes, statics only (default: the design's)",
    )  # fmt: skip
    parser.add_argument(
        "--alignment", type=read_text, metavar="HOW",
        help="base, run or shape, the last two also on chosen sections, such as run:1-5 (default: the protocol's)",
    )  # fmt: skip
    parser.add_argument(
        "--rotations", choices=("quaternion", "ignore"), help="ignore rotations of rigid bodies, as of Euler exports"
    )
    parser.add_argument("--design", type=read_text, metavar="DESIGN", help="a preset or TOML file (the protocol's)")
    parser.add_argument("--plan", action="store_true", help="no takes: print what to do in the session")
    parser.add_argument("--out", type=read_text, metavar="DIR", help="write the report, or with --plan the plan, there")


def _run(arguments: argparse.Namespace) -> Answer:
    _check(arguments)
    from spiraltrunk.design import load_design
    from spiraltrunk.mocap.protocol.toml import load_protocol
    from spiraltrunk.mocap.recordings.axes import read_axes
    from spiraltrunk.mocap.session.session import SessionSettings
    from spiraltrunk.mocap.signal.registration import read_alignment

    protocol = load_protocol(arguments.protocol)
    settings = SessionSettings(
        design=load_design(arguments.design or protocol.design), axes=arguments.axes, model=arguments.model,
        alignment=None if arguments.alignment is None else read_alignment(arguments.alignment),
        friction=None if arguments.friction is None else float(arguments.friction), rotations=arguments.rotations,
    )  # fmt: skip
    if settings.axes is not None:
        read_axes(settings.axes)
    return _plan(arguments, protocol, settings) if arguments.plan else _compare(arguments, protocol, settings)


def _check(arguments: argparse.Namespace) -> None:
    """Refuse arguments that do not go together, before any work is done."""
    if arguments.plan == bool(arguments.takes):
        what = "takes given with --plan" if arguments.takes else "no take given"
        raise UsageError(f"{what}; allowed: one TAKE or more, or --plan alone")
    if len(arguments.takes) > _MOST_TAKES:
        raise UsageError(f"{len(arguments.takes)} takes given; allowed: at most {_MOST_TAKES}")
    mu = arguments.friction
    if mu is not None and arguments.model != "statics":
        raise UsageError("--friction given with the model reference; allowed: --model statics, reference knows none")
    if mu is not None and not 0.0 <= mu < _MOST_FRICTION:
        raise UsageError(f"--friction is {mu.text}; allowed: 0 or more, below {_MOST_FRICTION:g}")
    if arguments.out is not None:
        check_folder(arguments.out)
        _try_folder(arguments.out)


def _try_folder(folder: str) -> None:
    """Refuse an ``--out`` that cannot be made or written to: make it, write, and take both away again."""
    target = Path(folder)
    made = [path for path in (target, *target.parents) if not path.exists()]
    try:
        target.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=target):
            pass
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise UsageError(f"--out: {quote(folder, 200)}: {why}; allowed: a folder that can be made or written") from None
    finally:
        for path in made:
            with suppress(OSError):  # Never made, or somebody else has put something there.
                path.rmdir()


def _compare(arguments: argparse.Namespace, protocol: Protocol, settings: SessionSettings) -> Answer:
    from spiraltrunk.mocap.protocol.protocol import sort_takes
    from spiraltrunk.workflows.validate.artifacts import write_comparison
    from spiraltrunk.workflows.validate.comparison import compare_to_model, compute_result

    takes = sort_takes(protocol, arguments.takes)
    with show_progress(sys.stderr) as progress:
        comparison = compare_to_model(protocol, takes, settings, progress)
        progress("report", 0, 1)
        result = compute_result(comparison) if arguments.out is None else write_comparison(comparison, arguments.out)
    for note in result["notes"]:
        complain(f"note: {note}", DONE)
    return DONE, format_json(result) if arguments.json else _format(result, arguments.out)


def _format(result: dict[str, Any], out: str | None) -> str:
    """The figures as tables."""
    from spiraltrunk.report import format_table
    from spiraltrunk.workflows.validate.page import format_run, pair_with_paper

    friction = "" if result["friction"] is None else f" with friction {result['friction']:g}"
    rows = [(name, *format_run(run)) for name, run in result["runs"].items()]
    title = f"{result['design']}, {result['model']}{friction}, alignment {result['alignment']}; RMSE in mm"
    header = ("run", "shapes", "takes", "sections", "mean", "max", "largest distance", "takes differ")
    paper = format_table(
        pair_with_paper(result), header=("in mm", "synthetic" if result["is_made_up"] else "here", "paper"),
        title="The paper's figures, of its authors' model and robot", indent=2,
    )  # fmt: skip
    text = f"{format_table(rows, header=header, title=title, indent=2)}\n\n{paper}"
    return text if out is None else f"{text}\n\n{len(result['files'])} files in {out}"


def _plan(arguments: argparse.Namespace, protocol: Protocol, settings: SessionSettings) -> Answer:
    from spiraltrunk.mocap.protocol.checklist import format_plan, format_schedule
    from spiraltrunk.mocap.protocol.schedule import build_plan

    plans = [build_plan(settings.design, protocol, run) for run in protocol.runs]
    text = format_plan(settings.design, protocol, plans)
    files = ["plan.md", "protocol.toml", "schedule.csv"] if arguments.out is not None else []
    if arguments.out is not None:
        from spiraltrunk.files.atomic import atomic_folder

        with atomic_folder(arguments.out, files) as draft:
            (draft / "plan.md").write_text(text)
            (draft / "protocol.toml").write_text(_read_protocol(arguments.protocol))
            (draft / "schedule.csv").write_text(format_schedule(settings.design, plans))
        complain(f"{', '.join(files)} written to {arguments.out}", DONE)
    if arguments.json:
        return DONE, format_json(_tell_plans(protocol, settings, plans) | {"files": files})
    return DONE, text.rstrip("\n")


def _read_protocol(path_or_name: str) -> str:
    from spiraltrunk.mocap.protocol.toml import PACKAGED, read_packaged

    return read_packaged() if path_or_name == PACKAGED else Path(path_or_name).read_text(encoding="utf-8-sig")


def _tell_plans(protocol: Protocol, settings: SessionSettings, plans: list[Plan]) -> dict[str, Any]:
    """What the winders are told, in plain values; null for slack cables."""
    import math

    runs = {
        plan.run.name: {
            "kind": plan.run.kind, "theta0_deg": math.degrees(plan.run.theta_0), "takes": plan.run.takes,
            "cable_m": [None if plan.run.kind == "rest" else told.tolist() for told in plan.told],
        }
        for plan in plans
    }  # fmt: skip
    return {"protocol": protocol.name, "design": settings.design.name, "runs": runs}
