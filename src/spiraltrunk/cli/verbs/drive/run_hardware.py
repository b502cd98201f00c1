"""``spiraltrunk drive run`` on a bus that is named: a log and no verdict."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.output import DONE, FAILED, Answer, UsageError, add_file_count, format_json, open_out
from spiraltrunk.cli.progress import show_progress
from spiraltrunk.cli.verbs.drive.robot import compute_state
from spiraltrunk.cli.verbs.drive.run_log import LOG, add_log, open_run_log

if TYPE_CHECKING:
    from spiraltrunk.control.strategy import Strategy
    from spiraltrunk.design.trunk import TrunkDesign
    from spiraltrunk.hardware.setup.robot_file import RobotFile
    from spiraltrunk.workflows.drive.camera import Camera, Look
    from spiraltrunk.workflows.drive.hardware_robot import HardwareRobot

RESULT = "result.json"
"""Name of the result."""


def run_on_robot(
    arguments: argparse.Namespace, design: TrunkDesign, file: RobotFile, strategy: Strategy[Any], name: str,
    *, look: Look | None = None,
) -> Answer:  # fmt: skip
    """Run the strategy on the real robot, for an object of this name.

    Raises:
        UsageError: where the file names no arm, or the strategy needs a camera or the gripper and there is none.
    """
    from spiraltrunk.workflows.drive.camera import Camera
    from spiraltrunk.workflows.drive.hardware_robot import HardwareRobot

    if file.arm == "none":
        raise UsageError('the robot has no arm; allowed: arm = "panda:HOST" or "franky:HOST" in the file of --robot')
    if strategy.needs_camera and look is None:
        raise UsageError(f"{strategy.name} needs a camera; allowed: --camera MODULE:NAME, or a strategy without one")
    if strategy.holds == "fingers" and file.servo is None:
        raise UsageError(f"{strategy.name} needs the gripper; allowed: a table [servo] in the file of --robot")
    with HardwareRobot(design, file, without_watchdog=arguments.without_watchdog) as robot:
        camera = None if look is None else Camera(look, arguments.camera, robot.clock)
        result = _run(arguments, robot, strategy, name, camera)
    code = FAILED if result["gave_up"] else DONE
    if arguments.json:
        return code, format_json(result)
    end = f"gave up: {result['gave_up']}" if result["gave_up"] else "came to its end"
    text = f"{strategy.name} {end} after {result['duration_s']:.1f} s; {result['verdict']}"
    return code, add_file_count(text, result, arguments, "\n  ")


def _run(
    arguments: argparse.Namespace, robot: HardwareRobot, strategy: Strategy[Any], name: str, camera: Camera | None
) -> dict[str, Any]:
    from spiraltrunk.sim.objects.catalogue import parse_object
    from spiraltrunk.workflows.drive.hardware_trial import run_on_hardware, summarise_hardware_trial

    with open_out(arguments.out, "drive", [RESULT, LOG]) as output, show_progress(sys.stderr) as progress:
        progress("homing", 0, 0)

        def run(log: Any) -> dict[str, Any]:
            done = run_on_hardware(
                robot,
                parse_object(name),
                strategy,
                camera=camera,
                log=log,
                watch=lambda seen, status: progress(status.phase, 0, 0),
            )
            state = compute_state(done.snapshot) | {"bus": robot.file.bus, "homing_s": done.homing}
            state["warnings"] = list(done.warnings)
            return summarise_hardware_trial(done, strategy, name) | {"drive": state}

        if output is None:
            return run(None)
        with open_run_log(output) as log, output.draft() as draft:
            result = run(log)
            add_log(log, draft)
            result["files"] = [RESULT, LOG]
            (draft / RESULT).write_text(format_json(result) + "\n")
        return result
