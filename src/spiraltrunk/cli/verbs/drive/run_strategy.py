"""``spiraltrunk drive run`` and ``replay``: a strategy through motors and driver, and its log."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import read_text
from spiraltrunk.cli.object_check import check_object
from spiraltrunk.cli.output import DONE, FAILED, Answer, add_file_count, complain, format_json, open_out
from spiraltrunk.cli.progress import show_progress
from spiraltrunk.cli.verbs.drive.actions import add_action
from spiraltrunk.cli.verbs.drive.robot import compute_state, load_wiring, read_robot_file
from spiraltrunk.cli.verbs.drive.run_hardware import run_on_robot
from spiraltrunk.cli.verbs.drive.run_log import LOG, add_log, open_run_log
from spiraltrunk.cli.verbs.grasp import format_verdict

if TYPE_CHECKING:
    from spiraltrunk.control.strategy import Strategy
    from spiraltrunk.design import TrunkDesign
    from spiraltrunk.sim.objects.catalogue import ObjectSpec
    from spiraltrunk.workflows.drive.trial import DriveTrial


def add_run(actions: Any, name: str) -> None:
    """Add the action that runs a strategy."""
    parser = add_action(actions, name, _run, "home, arm, and run one strategy")
    parser.add_argument("strategy", type=read_text, metavar="STRATEGY", help="one of the nine")
    parser.add_argument(
        "--object", type=read_text, metavar="NAME",
        help="a catalogue name, or a solid such as cylinder:diameter_mm=72,height_mm=180,mass_g=350",
    )  # fmt: skip
    parser.add_argument(
        "--camera", type=read_text, metavar="MODULE:NAME",
        help="a Python function that tells where the object is, for a robot; the twin has a camera of its own",
    )  # fmt: skip
    parser.add_argument("--no-video", action="store_true", help="write neither film strip nor video")
    parser.add_argument("--out", type=read_text, metavar="DIR", help="write result, log, plots and video there")


def add_replay(actions: Any, name: str) -> None:
    """Add the action that summarises a log."""
    parser = add_action(actions, name, _replay, "read the log of a run, and draw its plots")
    parser.add_argument("log", type=read_text, metavar="LOG", help="an MCAP file that `drive run --out` wrote")
    parser.add_argument("--intact", action="store_true", help="of a damaged log, tell what stands before the damage")
    parser.add_argument("--out", type=read_text, metavar="DIR", help="write the plots there")


def _run(arguments: argparse.Namespace) -> Answer:
    from spiraltrunk import strategies
    from spiraltrunk.design import load_design
    from spiraltrunk.sim.objects.catalogue import DEFAULT_OBJECT, parse_object
    from spiraltrunk.workflows.drive.camera import load_camera

    strategy = strategies.get(arguments.strategy)
    usual = DEFAULT_OBJECT if DEFAULT_OBJECT in strategy.objects else strategy.objects[0]
    name = usual if arguments.object is None else arguments.object
    shape, design = parse_object(name), load_design(arguments.design)
    check_object(strategy, design, shape, name)
    file = read_robot_file(arguments, design)
    look = None if arguments.camera is None else load_camera(arguments.camera)
    if file is not None:
        return run_on_robot(arguments, design, file, strategy, name, look=look)
    if look is not None:
        complain("--camera is only tried once: the twin has a camera of its own", DONE)
    result = _run_on_twin(arguments, design, strategy, shape, name)
    code = DONE if result["success"] else FAILED
    if arguments.json:
        return code, format_json(result)
    return code, add_file_count(format_verdict(result), result, arguments, "\n  ")


def _run_on_twin(
    arguments: argparse.Namespace, design: TrunkDesign, strategy: Strategy[Any], shape: ObjectSpec, name: str
) -> dict[str, Any]:
    from spiraltrunk.workflows.drive.trial import run_on_twin
    from spiraltrunk.workflows.drive.twin.twin_robot import TwinOptions
    from spiraltrunk.workflows.grasp.artifacts import compute_result, list_files, write_artifacts

    missing, video, seed = None, not arguments.no_video, arguments.seed
    with (
        open_out(arguments.out, "drive", [*list_files(video=video), LOG]) as output,
        show_progress(sys.stderr) as progress,
    ):
        progress("homing", 0, 0)

        def run(log: Path | None) -> DriveTrial:
            wiring = load_wiring(arguments, design)
            return run_on_twin(
                design, shape, strategy=strategy, seed=seed, log=log,
                options=TwinOptions(seed=seed, is_real_time=arguments.real_time, file=wiring),
                watch=lambda seen, status: progress(status.phase, 0, 0),
            )  # fmt: skip

        if output is None:
            done = run(None)
            result = compute_result(done.trial, name)
        else:
            with open_run_log(output) as path, output.draft() as draft:
                done = run(path)
                add_log(path, draft)
                artifacts = write_artifacts(done.trial, name, draft, video=video, workers=2, progress=progress)
            result, missing = artifacts.result, artifacts.missing
    if missing is not None:
        complain(f"no film strip and no video: {missing}", DONE)
    drive = compute_state(done.snapshot) | {"bus": arguments.bus, "homing_s": done.homing}
    return result | {"drive": drive | {"warnings": list(done.warnings)}}


def _replay(arguments: argparse.Namespace) -> Answer:
    from spiraltrunk.report import format_table
    from spiraltrunk.workflows.drive.replay import PLOT, read_replay, summarise_replay, write_replay

    replay = read_replay(arguments.log, intact=arguments.intact)
    with open_out(arguments.out, "drive", [PLOT]) as output:
        if output is not None:
            with output.draft(is_partial=True) as draft:  # The folder may be the run's own, with its log.
                write_replay(replay, draft)
    if not replay.result["is_complete"]:
        damage = replay.result["damage"]
        how = "cut off (its program was ended)" if damage is None else f"damaged ({damage})"
        complain(f"the log is {how}: what follows is told up to there", DONE)
    files = [] if arguments.out is None else [PLOT]
    if arguments.json:
        return DONE, format_json(replay.result | {"files": files})
    rows = summarise_replay(replay, [str(Path(arguments.out) / name) for name in files])
    return DONE, format_table(rows, title=str(arguments.log), indent=2)
