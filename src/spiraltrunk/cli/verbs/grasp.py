"""``spiraltrunk grasp``: one trial in simulation, and its artifacts."""

from __future__ import annotations

import argparse
import math
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import add_parser, read_seed, read_text
from spiraltrunk.cli.object_check import check_object, name_able, read_object, warn_infeasible, warn_laid
from spiraltrunk.cli.options.design import add_design, add_timestep, choose_timestep, load_robot
from spiraltrunk.cli.output import (
    DONE,
    FAILED,
    Answer,
    UsageError,
    add_file_count,
    complain,
    format_json,
    name_option,
    open_out,
    quote,
)
from spiraltrunk.cli.progress import print_if_slow, show_progress

if TYPE_CHECKING:
    from spiraltrunk.control.strategy import Strategy
    from spiraltrunk.design import TrunkDesign
    from spiraltrunk.files.results import Progress
    from spiraltrunk.sim.objects.catalogue import ObjectSpec
    from spiraltrunk.workflows.grasp.trial import Trial

_GL = ("", "egl", "glfw", "glx", "osmesa", "cgl", "wgl", "on", "true", "1", "enable", "enabled", "off", "false", "0",
       "disable", "disabled")  # fmt: skip
"""Values of MUJOCO_GL that MuJoCo accepts."""

_PUSHES = "kick and sweep push an object along the ground; they do not lift it and are not ranked"
"""Foot of a ranking on the ground."""

_WORKERS = 2
"""Processes that render a video: software OpenGL uses threads, so that more gain nothing."""


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(verbs, "grasp", _run, "run one trial in simulation")
    parser.add_argument(
        "strategy", type=read_text, nargs="?", default="wrap-vertical", metavar="STRATEGY",
        help="one of the nine (default wrap-vertical), or auto: the model ranks those that lift, the best is tried, "
        "and after a failed try the next; kick and sweep push along the ground and are not ranked; "
        "policy:FILE.safetensors is a learned one",
    )  # fmt: skip
    parser.add_argument(
        "--object", type=read_text, metavar="NAME",
        help="a catalogue name, a solid such as cylinder:diameter_mm=72,height_mm=180,mass_g=350, or a file such as "
        "stl:path=cup.stl,mass_g=120 (or obj, mjcf)",
    )  # fmt: skip
    parser.add_argument(
        "--stage", choices=("ground", "hung"), metavar="STAGE",
        help="what supports the object: ground or hung (default: ground for auto, else where the strategy grasps)",
    )  # fmt: skip
    add_design(parser)
    add_timestep(parser)
    parser.add_argument("--seed", type=read_seed, default=0, help="seed of the randomised scene (default 0)")
    parser.add_argument("--no-video", action="store_true", help="write neither film strip nor video")
    parser.add_argument("--out", type=read_text, metavar="DIR", help="write result, design, plots and video there")
    parser.add_argument(
        "--replay", type=read_text, metavar="FILE.html",
        help="write one file that plays the trial in any browser, without a server or a network (extra studio)",
    )  # fmt: skip


def _run(arguments: argparse.Namespace) -> Answer:
    if os.environ.get("MUJOCO_GL", "").lower().strip() not in _GL:
        raise UsageError(f"MUJOCO_GL is {quote(os.environ['MUJOCO_GL'])}; allowed: egl, osmesa, glfw or unset")
    from spiraltrunk.sim.objects.catalogue import DEFAULT_OBJECT
    from spiraltrunk.workflows.grasp.artifacts import compute_result, list_files, write_artifacts
    from spiraltrunk.workflows.grasp.choice.auto import get_strategy, list_objects

    usual = list_objects(arguments.strategy)
    usual_name = DEFAULT_OBJECT if DEFAULT_OBJECT in usual else usual[0]
    name = usual_name if arguments.object is None else arguments.object
    shape, design = read_object(name), load_robot(arguments)
    strategy = get_strategy(arguments.strategy, design, shape, arguments.stage)
    _check_stage(strategy, arguments.stage)
    check_object(strategy, design, shape, name)
    warn_infeasible(strategy, design, shape)
    warn_laid(strategy, shape)
    _warn_heavy(strategy, design, shape)
    _warn_unchecked(design)
    if shape.warning:
        complain(shape.warning, DONE)

    missing, video, replay = None, not arguments.no_video, _check_replay(arguments.replay)
    with open_out(arguments.out, "grasp", list_files(video=video)) as output, show_progress(sys.stderr) as progress:
        with name_able(design, shape, strategy):
            trial = _run_trial(arguments, design, shape, progress)
        if replay is not None:
            progress("replay", 0, 0)
            _write_replay(trial, f"{trial.strategy}, {name}, seed {trial.seed}: {trial.verdict.reason}", replay)
        if output is None:
            result = compute_result(trial, name)
        else:
            with output.draft() as draft:
                artifacts = write_artifacts(trial, name, draft, video=video, workers=_WORKERS, progress=progress)
            result, missing = artifacts.result, artifacts.missing
    if missing is not None:
        complain(f"no film strip and no video: {missing}", DONE)
    if result.get("attempts") == []:
        _name_alternatives(design, shape, strategy.support)
    code = DONE if result["success"] else FAILED
    if arguments.json:
        return code, format_json(result)
    return code, add_file_count(format_verdict(result), result, arguments, "\n  ")


def _check_replay(given: str | None) -> Path | None:
    """The file of a replay, where one is asked for.

    Raises:
        UsageError: where it does not end in .html, cannot be written or must not be replaced.
        ModuleNotFoundError: without the page's packages.
    """
    if given is None:
        return None
    from spiraltrunk.files.output_file import check_output_file
    from spiraltrunk.studio.grasp.replay import format_replay  # noqa: F401  # Refused before the trial.

    file = Path(given)
    if file.suffix.lower() != ".html":
        raise UsageError(f"--replay: {quote(given)} given; allowed: a file that ends in .html")
    with name_option("--replay"):
        check_output_file(file, "html")
    return file


def _write_replay(trial: Trial, title: str, file: Path) -> None:
    from spiraltrunk.files.output_file import write_output_file
    from spiraltrunk.studio.grasp.replay import format_replay
    from spiraltrunk.workflows.grasp.recording import record

    with name_option("--replay"):
        write_output_file(file, format_replay(record(trial, title)).encode(), "html")


def _name_alternatives(design: TrunkDesign, shape: ObjectSpec, stage: str) -> None:
    """Print the options with which another strategy can take an object that `auto` refused."""
    from spiraltrunk.workflows.grasp.choice.ranking import find_alternatives

    with print_if_slow("looking for options with which another strategy can take the object", sys.stderr):
        found = find_alternatives(design, shape, stage)
    for option, name in found.items():
        complain(f"{name} can take it with {option}", DONE)


def _run_trial(arguments: argparse.Namespace, design: TrunkDesign, shape: ObjectSpec, progress: Progress) -> Trial:
    from spiraltrunk.workflows.grasp.trial import run_trial

    return run_trial(
        design, shape, strategy=arguments.strategy, stage=arguments.stage, seed=arguments.seed,
        timestep=choose_timestep(arguments), watch=lambda seen, status: progress(status.phase, 0, 0),
    )  # fmt: skip


def _check_stage(strategy: Strategy[Any], stage: str | None) -> None:
    """Refuse a stage on which a strategy does not grasp.

    Raises:
        UsageError: with the stage on which it does.
    """
    if stage not in (None, strategy.support):
        allowed = f"{strategy.support}, where {strategy.name} works; or auto, which chooses a strategy for the stage"
        raise UsageError(f"--stage: {stage} given; allowed: {allowed}")


def _warn_heavy(strategy: Strategy[Any], design: TrunkDesign, shape: ObjectSpec) -> None:
    """Warn where the arm's rated payload is exceeded."""
    from spiraltrunk.sim.robot.arm import arm_payload

    carried = design.housing.total_mass + design.housing.total_neck_mass + design.total_mass + shape.mass
    rated = arm_payload(design.arm)
    if strategy.job == "grasp" and rated is not None and carried > rated:
        complain(f"the arm carries {carried:.3g} kg, rated for {rated:g}: its torques are checked in the trial", DONE)


def _warn_unchecked(design: TrunkDesign) -> None:
    """Warn of limits of the arm that are unknown, and so not checked."""
    from spiraltrunk.control.arm_limits import find_missing_limits
    from spiraltrunk.sim.robot.arm import arm_limits

    unjudged = find_missing_limits(arm_limits(design.arm))
    if unjudged:
        complain(f"the arm {quote(design.arm.model, 200)} states no limit of {', '.join(unjudged)}: not judged", DONE)


def format_verdict(result: dict[str, Any]) -> str:
    """The verdict of a trial as a table."""
    from spiraltrunk.report import format_table

    title = f"{result['strategy']}, {result['object']}, seed {result['seed']}"
    if result.get("attempts") == []:  # Nothing moved.
        return f"{title}: no strategy can take it{_format_choice(result)}"
    head = "success" if result["success"] else f"failed: {result['reason']}"
    lifted = [
        ("lifted", f"{_scaled(result['lift_m'], 1e3)} mm"),
        ("carried", f"{_scaled(result['carry_m'], 1e3)} mm"),
        ("held by the trunk alone", f"{_scaled(result['hold_s'])} s"),
        ("set down from the target", f"{_scaled(result['place_error_m'], 1e3)} mm"),
    ]
    is_kick = result["strategy"] == "kick"
    rows = [
        *([("pushed", f"{_scaled(result['carry_m'], 1e3)} mm")] if is_kick else lifted),
        ("deepest overlap", f"{_scaled(result['max_penetration_m'], 1e3)} mm"),
        ("largest joint angle", f"{_scaled(result['max_joint_deg'])} deg"),
        ("speed", f"{_scaled(result['real_time_factor'])} times real time"),
    ]
    return format_table(rows, title=f"{title}: {head}", indent=2) + _format_choice(result)


def _format_choice(result: dict[str, Any]) -> str:
    """What a run that chose its strategy tried and ranked; empty for another."""
    from spiraltrunk.report import format_table

    if "candidates" not in result:
        return ""
    tries = [(each["strategy"], each["outcome"] + _format_correction(each)) for each in result["attempts"]]
    ranked = [(each["strategy"], f"{each['score']:.2f}", each["reason"]) for each in result["candidates"]]
    tried = f"\n{format_table(tries, title='tried', indent=2)}" if tries else ""
    ground = result["world"]["ground_m"]
    title = "ranked" if ground is None else f"ranked, over a ground of {ground:g} m unless another is told"
    pushes = "" if ground is None else f"\n  {_PUSHES}"
    return f"{tried}\n{format_table(ranked, title=title, indent=2)}{pushes}"


def _format_correction(attempt: dict[str, Any]) -> str:
    """By how far a try aimed beside the place, against the error of the try before; empty where it did not."""
    aside = math.hypot(*attempt["place_correction_m"])
    return f"; aimed {100 * aside:.0f} cm beside the place, against the error before" if aside > 0.0 else ""


def _scaled(value: float | None, factor: float = 1.0) -> str:
    return "-" if value is None else f"{value * factor:.3g}"
