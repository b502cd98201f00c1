"""A strategy on the real robot, whose object nobody observes but the strategy: a log, and no verdict."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

from spiraltrunk.control.loop import RunLog
from spiraltrunk.control.messages import CameraObservation, Observation, Task
from spiraltrunk.control.strategy import Status, Strategy
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import RunError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.driver.snapshot import Snapshot
from spiraltrunk.sim.objects.catalogue import ObjectSpec
from spiraltrunk.sim.robot.arm_ik import ArmReach
from spiraltrunk.sim.scene.build import build_task
from spiraltrunk.workflows.drive.hardware_robot import HardwareRobot
from spiraltrunk.workflows.drive.trial import run_logged
from spiraltrunk.workflows.grasp.choice.ground import set_ground
from spiraltrunk.workflows.grasp.world import AS_ANNOUNCED, draw_scene

NOT_JUDGED = "not judged"
"""Verdict of a run whose ground truth nobody knows."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class HardwareTrial:
    """A run on the real robot."""

    log: RunLog
    """Every message between robot and strategy."""
    snapshot: Snapshot
    """The driver at its end, before it let go."""
    homing: float
    """Time that homing took [s]."""
    warnings: tuple[str, ...]
    """Warnings of the driver during the run."""


def build_announced_task(design: TrunkDesign, shape: ObjectSpec, strategy: Strategy[Any]) -> Task:
    """The task of a strategy's scene with the object exactly where it is announced."""
    scene = draw_scene(shape, 0, strategy=strategy, spread=AS_ANNOUNCED)
    return build_task(design, set_ground(design, scene, strategy))


def run_on_hardware(
    robot: HardwareRobot,
    shape: ObjectSpec,
    strategy: Strategy[Any],
    *,
    camera: Callable[[], CameraObservation | None] | None = None,
    log: Path | None = None,
    watch: Callable[[Observation, Status], None] | None = None,
) -> HardwareTrial:
    """Home, arm, run the strategy for an object where its scene announces it, and let go. Never tried on a real robot.

    Args:
        robot: the robot with its arm in its home posture.
        shape: the object.
        strategy: what to do.
        camera: gives the latest observation of the object; None without a camera.
        log: MCAP file to write; None for none.
        watch: called after every step.

    Raises:
        ModelError: where the strategy cannot plan for the object.
        DriveError: where the robot cannot be homed or armed.
        RunError: where it has no arm, or no camera or gripper and the strategy needs one, or a fault ended homing or
            came while it let go.
    """
    if strategy.needs_camera and camera is None:
        raise RunError(f"{strategy.name} needs a camera, and there is none; allowed: strategies that need none")
    if strategy.holds == "fingers" and robot.file.servo is None:
        raise RunError(f"{strategy.name} needs the gripper; allowed: a robot file with a table [servo]")
    task = build_announced_task(robot.design, shape, strategy)
    plant = robot.build_plant(task, ArmReach(robot.design), camera)
    began = robot.clock.now()
    robot.prepare()
    homing, warnings = robot.clock.now() - began, dict[str, None]()

    def look(seen: Observation, status: Status) -> None:
        warnings.update(dict.fromkeys(robot.driver.snapshot().warnings))
        if watch is not None:
            watch(seen, status)

    run_log, snapshot = run_logged(robot, plant, strategy, log, look, bus=robot.file.bus)
    return HardwareTrial(log=run_log, snapshot=snapshot, homing=homing, warnings=tuple(warnings))


def summarise_hardware_trial(trial: HardwareTrial, strategy: Strategy[Any], shape: str) -> dict[str, Any]:
    """Result of a run, ready for JSON: what the strategy says of itself, and no verdict."""
    return {
        "strategy": strategy.name,
        "job": strategy.job,
        "object": shape,
        "verdict": NOT_JUDGED,
        "success": None,
        "gave_up": trial.log.gave_up,
        "duration_s": trial.log.observations[-1].time,
        "planning_s": trial.log.planning,
        "phases": list(dict.fromkeys(status.phase for status in trial.log.statuses)),
    }
