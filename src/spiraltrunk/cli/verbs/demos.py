"""``spiraltrunk demos``: recorded trials as a data set for learning."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import add_parser, read_count, read_seed, read_text
from spiraltrunk.cli.options.design import add_design, add_timestep
from spiraltrunk.cli.options.engine import add_engine, add_shard, add_workers, build_engine, count_workers
from spiraltrunk.cli.output import DONE, INTERRUPTED, Answer, UsageError, complain, format_count, format_json, open_out
from spiraltrunk.cli.progress import print_progress
from spiraltrunk.cli.verbs.survey.folders import OF_TRIALS, refuse_others
from spiraltrunk.cli.verbs.survey.progress import show_survey
from spiraltrunk.cli.verbs.survey.run import build_plan

if TYPE_CHECKING:
    from spiraltrunk.workflows.demos.options import RecordingOptions
    from spiraltrunk.workflows.demos.run_demos import DemosPlan

_FORMATS = ("lerobot", "robomimic", "minari")

_OF_TRIALS = (*(name for name in OF_TRIALS if name != "strategies"), "format", "cameras", "size", "fps", "mode", "all")
"""Options of what is run and recorded."""


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(verbs, "demos", _run, "record trials and write them as a data set for learning")
    parser.add_argument(
        "strategies", type=read_text, nargs="?", metavar="STRATEGIES", help="names with commas, auto among them, or all"
    )
    parser.add_argument(
        "--trials", type=read_count, metavar="N", help="trials of each strategy; needed, but not with --merge"
    )
    parser.add_argument(
        "--out", type=read_text, required=True, metavar="DIR",
        help="write the data set there; the same command resumes what was interrupted",
    )  # fmt: skip
    parser.add_argument(
        "--format", choices=_FORMATS,
        help="lerobot (LeRobotDataset v3.0), robomimic (HDF5) or minari (extra demos); needed, but not with --merge",
    )  # fmt: skip
    parser.add_argument("--seed", type=read_seed, default=0, help="seed of all trials (default 0)")
    add_workers(parser)
    parser.add_argument(
        "--object", type=read_text, metavar="NAME",
        help="the object of every trial, as in grasp (default: in turn the objects of the strategy)",
    )  # fmt: skip
    add_design(parser)
    add_timestep(parser)
    add_shard(parser)
    add_engine(parser)
    _add_recording(parser)
    parser.set_defaults(defaults={name: parser.get_default(name) for name in _OF_TRIALS})
    parser.add_argument(
        "--merge", type=read_text, nargs="+", metavar="DIR",
        help="run nothing: merge all N shards in these folders into the data set in --out",
    )  # fmt: skip


def _add_recording(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--cameras", type=read_text, metavar="NAMES",
        help="cameras with commas: front, side, top, close (default: none; each needs OpenGL and time)",
    )  # fmt: skip
    parser.add_argument(
        "--size", type=read_count, metavar="PIXELS", help="width and height of the pictures of --cameras (default 96)"
    )
    parser.add_argument(
        "--fps", type=read_count, metavar="N",
        help="frames per second: 1, 2, 5, 10, 25 or 50 (default 50, with cameras 10)",
    )  # fmt: skip
    parser.add_argument(
        "--mode", type=read_text, metavar="MODE",
        help="what an action sets, a control mode of the environments (default delta-pose-tension-pull, which alone "
        "says all that the strategies command)",
    )  # fmt: skip
    parser.add_argument("--all", action="store_true", help="record failed trials as well")


def _run(arguments: argparse.Namespace) -> Answer:
    if arguments.merge is not None:
        return _merge(arguments)
    needed = {"STRATEGIES": arguments.strategies, "--trials": arguments.trials, "--format": arguments.format}
    missing = [name for name, given in needed.items() if given is None]
    if missing:
        raise UsageError(
            f"{', '.join(missing)} missing; allowed: STRATEGIES --trials N --format F --out DIR, or --merge"
        )
    return _record(arguments)


def _merge(arguments: argparse.Namespace) -> Answer:
    """Merge shards into one data set.

    Raises:
        UsageError: with an option of trials.
        SurveyError: where the folders are not all shards of one command.
    """
    from spiraltrunk.workflows.demos.merge_demos import merge_demos, read_plan
    from spiraltrunk.workflows.demos.run_demos import WRITER, list_files

    if arguments.strategies is not None:
        raise UsageError("STRATEGIES are of no use with --merge, which runs nothing; allowed: --out alone")
    refuse_others(arguments, _OF_TRIALS, "--merge", "--out alone")
    plan = read_plan(arguments.merge)
    with open_out(arguments.out, WRITER, list_files(plan.format)) as output:
        assert output is not None
        result = merge_demos(arguments.merge, output, progress=_print_begin)
    return DONE, format_json(result) if arguments.json else _format_text(result, arguments.out)


def _print_begin(step: str, count: int, total: int) -> None:
    if count == 0:
        print_progress(step, sys.stderr)


def _record(arguments: argparse.Namespace) -> Answer:
    from spiraltrunk.workflows.demos.run_demos import WRITER, list_files, run_demos

    plan = _build_plan(arguments)
    counts, engine, done = plan.survey.count_trials(), build_engine(arguments), 0
    try:
        with (
            open_out(arguments.out, WRITER, list_files(plan.format)) as output,
            show_survey(sys.stderr, counts) as show,
        ):
            assert output is not None

            def watch(rows: Sequence[Any]) -> None:
                nonlocal done
                done = len(rows)
                show(rows)

            result = run_demos(
                plan, folder=output, workers=count_workers(arguments), engine=engine, watch=watch, progress=_print_begin
            )
    except KeyboardInterrupt:
        kept = f"are in {arguments.out}; the same command goes on with the rest"
        complain(f"{done} of {sum(counts.values())} trials {kept}", INTERRUPTED)
        raise
    return DONE, format_json(result) if arguments.json else _format_text(result, arguments.out)


def _build_plan(arguments: argparse.Namespace) -> DemosPlan:
    """The trials, and the data set to write from them.

    Raises:
        UnknownName: for a strategy, object, camera or control mode that does not exist.
        DesignError: for an impossible object or robot, or a number out of range.
        UsageError: for an object that one of the strategies cannot grasp, or pictures without OpenGL.
        ModuleNotFoundError: where the format needs a package that is missing.
    """
    from spiraltrunk.workflows.demos.dataset.formats import get_format
    from spiraltrunk.workflows.demos.run_demos import DemosPlan

    survey, recording = build_plan(arguments), _build_recording(arguments)
    get_format(arguments.format).check_packages()
    if recording.mode == "joint-tension":
        from spiraltrunk.workflows.demos.recording.frames import read_arm_joints

        read_arm_joints(survey.design)
    return DemosPlan(survey=survey, recording=recording, format=arguments.format)


def _build_recording(arguments: argparse.Namespace) -> RecordingOptions:
    from spiraltrunk.control.encoding import ControlMode
    from spiraltrunk.workflows.demos.options import CONTROL_RATE, PICTURE_RATE, PICTURE_SIZE, RecordingOptions

    if arguments.cameras is not None and os.environ.get("MUJOCO_GL", "").lower().strip() in ("disable", "disabled"):
        raise UsageError("--cameras: pictures need OpenGL, but MUJOCO_GL disables it; allowed: egl, osmesa or glfw")
    if arguments.size is not None and arguments.cameras is None:
        raise UsageError("--size is of no use without --cameras, as it is that of pictures; allowed: both, or neither")
    cameras = () if arguments.cameras is None else tuple(name.strip() for name in arguments.cameras.split(","))
    usual = PICTURE_RATE if cameras else CONTROL_RATE
    return RecordingOptions(
        cameras=cameras, size=PICTURE_SIZE if arguments.size is None else arguments.size,
        fps=usual if arguments.fps is None else arguments.fps,
        mode=ControlMode.DELTA_POSE_TENSION_PULL.value if arguments.mode is None else arguments.mode,
        keeps_failures=arguments.all,
    )  # fmt: skip


def _format_text(result: dict[str, Any], out: str) -> str:
    from spiraltrunk.report import format_table

    rows = [
        (name, f"{told['demonstrations']} recorded, {told['successes']} of {told['trials']} succeeded")
        for name, told in result["strategies"].items()
    ]
    if not result["demonstrations"]:
        return f"{format_table(rows)}\nno data set, as no trial was recorded"
    return (
        f"{format_table(rows)}\n{format_count(result['demonstrations'], 'demonstration')} ({result['format']}) in {out}"
    )
