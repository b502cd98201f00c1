"""``spiraltrunk grasp``: one trial in simulation, and its artifacts."""

from __future__ import annotations

import argparse
import math
import os
import sys
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import add_parser, read_seed, read_text
from spiraltrunk.cli.output import (
    DONE,
    FAILED,
    Answer,
    UsageError,
    add_file_count,
    check_folder,
    complain,
    format_json,
    quote,
)
from spiraltrunk.cli.progress import show_progress

if TYPE_CHECKING:
    from spiraltrunk.control.strategy import Strategy
    from spiraltrunk.design import TrunkDesign
    from spiraltrunk.files.results import Progress
    from spiraltrunk.sim.objects.catalogue import ObjectSpec
    from spiraltrunk.workflows.grasp.trial import Trial

_GL = ("", "egl", "glfw", "glx", "osmesa", "cgl", "wgl", "on", "true", "1", "enable", "enabled", "off", "false", "0",
       "disable", "disabled")  # fmt: skip
"""Values of MUJOCO_GL that MuJoCo accepts."""

_WORKERS = 2
"""Processes that render a video: software OpenGL uses threads, so that more gain nothing."""


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(verbs, "grasp", _run, "run one trial in simulation")
    parser.add_argument(
        "strategy", type=read_text, nargs="?", default="wrap-vertical", metavar="STRATEGY",
        help="one of the nine (default wrap-vertical)",
    )  # fmt: skip
    parser.add_argument(
        "--object", type=read_text, metavar="NAME",
        help="a catalogue name, or a solid such as cylinder:diameter_mm=72,height_mm=180,mass_g=350",
    )  # fmt: skip
    parser.add_argument(
        "--design", type=read_text, default="paper", metavar="DESIGN",
        help="preset or TOML file (default paper, which the strategies are tuned for; the presets spirob-15 and "
        "spirob-1m run, but fail with the default object)",
    )  # fmt: skip
    parser.add_argument("--seed", type=read_seed, default=0, help="seed of the randomised scene (default 0)")
    parser.add_argument("--no-video", action="store_true", help="write neither film strip nor video")
    parser.add_argument("--out", type=read_text, metavar="DIR", help="write result, design, plots and video there")


def _run(arguments: argparse.Namespace) -> Answer:
    if os.environ.get("MUJOCO_GL", "").lower().strip() not in _GL:
        raise UsageError(f"MUJOCO_GL is {quote(os.environ['MUJOCO_GL'])}; allowed: egl, osmesa, glfw or unset")
    check_folder(arguments.out)
    from spiraltrunk import strategies
    from spiraltrunk.design import load_design
    from spiraltrunk.files.atomic import atomic_folder
    from spiraltrunk.sim.objects.catalogue import DEFAULT_OBJECT, parse_object
    from spiraltrunk.workflows.grasp.artifacts import FILES, compute_result, write_artifacts

    strategy = strategies.get(arguments.strategy)
    usual = DEFAULT_OBJECT if DEFAULT_OBJECT in strategy.objects else strategy.objects[0]
    name = usual if arguments.object is None else arguments.object
    shape, design = parse_object(name), load_design(arguments.design)
    _check_width(strategy, design, shape, name)
    _check_mass(strategy, design, shape, name)
    _warn_unchecked(design)
    if shape.warning:
        complain(shape.warning, DONE)

    missing = None
    if arguments.out is None:
        with show_progress(sys.stderr) as progress:
            result = compute_result(_run_trial(arguments, design, shape, progress), name)
    else:
        with atomic_folder(arguments.out, FILES) as draft, show_progress(sys.stderr) as progress:
            trial = _run_trial(arguments, design, shape, progress)
            video = not arguments.no_video
            artifacts = write_artifacts(trial, name, draft, video=video, workers=_WORKERS, progress=progress)
            result, missing = artifacts.result, artifacts.missing
    if missing is not None:
        complain(f"no film strip and no video: {missing}", DONE)
    code = DONE if result["success"] else FAILED
    if arguments.json:
        return code, format_json(result)
    return code, add_file_count(_format_verdict(result), result, arguments, "\n  ")


def _run_trial(arguments: argparse.Namespace, design: TrunkDesign, shape: ObjectSpec, progress: Progress) -> Trial:
    from spiraltrunk.workflows.grasp.trial import run_trial

    return run_trial(
        design, shape, strategy=arguments.strategy, seed=arguments.seed,
        watch=lambda seen, status: progress(status.phase, 0, 0),
    )  # fmt: skip


def _check_width(strategy: Strategy[Any], design: TrunkDesign, shape: ObjectSpec, name: str) -> None:
    """Refuse an object that the strategy cannot grasp, before anything is simulated."""
    smallest, largest = strategy.widths(design)
    if not smallest <= shape.width <= largest:
        low, high = math.ceil(1e4 * smallest) / 10, math.floor(1e4 * largest) / 10
        allowed = f"{low:g} to {high:g} mm, what {strategy.name} can take with the trunk {quote(design.name)}"
        raise UsageError(f"--object: {quote(name)} is {1e3 * shape.width:.4g} mm wide; allowed: {allowed}")


def _check_mass(strategy: Strategy[Any], design: TrunkDesign, shape: ObjectSpec, name: str) -> None:
    """Refuse an object that is too heavy for the trunk; warn where the arm's rated payload is exceeded."""
    from spiraltrunk.design import payload
    from spiraltrunk.sim.robot.arm import arm_payload

    if strategy.job != "grasp":
        return  # What is pushed along the ground is not carried.
    most = payload(design, shape.width)
    if shape.mass > most:
        allowed = f"at most {math.floor(1e3 * most):g} g, what the trunk {quote(design.name)} holds at that width"
        raise UsageError(f"--object: {quote(name)} has {1e3 * shape.mass:g} g; allowed: {allowed}")
    carried = design.housing.mass + design.housing.neck_mass + design.total_mass + shape.mass
    rated = arm_payload(design.arm)
    if rated is not None and carried > rated:
        complain(f"the arm carries {carried:.3g} kg, rated for {rated:g}: its torques are checked in the trial", DONE)


def _warn_unchecked(design: TrunkDesign) -> None:
    """Warn of limits of the arm that are unknown, and so not checked."""
    from spiraltrunk.control.arm_limits import find_missing_limits
    from spiraltrunk.sim.robot.arm import arm_limits

    unjudged = find_missing_limits(arm_limits(design.arm))
    if unjudged:
        complain(f"the arm {quote(design.arm.model, 200)} states no limit of {', '.join(unjudged)}: not judged", DONE)


def _format_verdict(result: dict[str, Any]) -> str:
    from spiraltrunk.report import format_table

    head = "success" if result["success"] else f"failed: {result['reason']}"
    rows = [
        ("lifted", f"{_scaled(result['lift_m'], 1e3)} mm"),
        ("carried", f"{_scaled(result['carry_m'], 1e3)} mm"),
        ("held by the trunk alone", f"{_scaled(result['hold_s'])} s"),
        ("set down from the target", f"{_scaled(result['place_error_m'], 1e3)} mm"),
        ("deepest overlap", f"{_scaled(result['max_penetration_m'], 1e3)} mm"),
        ("largest joint angle", f"{_scaled(result['max_joint_deg'])} deg"),
        ("speed", f"{_scaled(result['real_time_factor'])} times real time"),
    ]
    title = f"{result['strategy']}, {result['object']}, seed {result['seed']}: {head}"
    return format_table(rows, title=title, indent=2)


def _scaled(value: float | None, factor: float = 1.0) -> str:
    return "-" if value is None else f"{value * factor:.3g}"
