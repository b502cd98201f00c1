"""One trial of a strategy on the twin, through motors, bus and driver, evaluated by the verdict of the simulation."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, final

from spiraltrunk import strategies
from spiraltrunk.control.loop import RunLog, run
from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.control.plant import CONTROL_PERIOD, Plant
from spiraltrunk.control.strategy import Status, Strategy
from spiraltrunk.design.toml import format_design
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import RunError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.files.results import read_versions
from spiraltrunk.hardware.driver.snapshot import Snapshot
from spiraltrunk.hardware.driver.threaded_driver import Driver
from spiraltrunk.hardware.log import LoggedPlant, LogMetadata, LogWriter, describe_task
from spiraltrunk.hardware.plant import HardwarePlant
from spiraltrunk.hardware.twin.clock import STEP, TwinClock
from spiraltrunk.sim.objects.catalogue import ObjectSpec
from spiraltrunk.workflows.drive.recorder import Recorder
from spiraltrunk.workflows.drive.robot import Robot
from spiraltrunk.workflows.drive.twin.twin_robot import TwinOptions, TwinRobot
from spiraltrunk.workflows.grasp.choice.ground import set_ground
from spiraltrunk.workflows.grasp.trial import Trial
from spiraltrunk.workflows.grasp.verdict.evidence import Evidence
from spiraltrunk.workflows.grasp.verdict.jobs import JOBS
from spiraltrunk.workflows.grasp.world import Spread, draw_scene


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class DriveTrial:
    """A trial on the twin."""

    trial: Trial
    """Log, ground truth and verdict, as of a trial on the ideal machine."""
    snapshot: Snapshot
    """The driver at its end, before it let go."""
    homing: float
    """Simulated time that homing took [s]."""
    warnings: tuple[str, ...]
    """Warnings of the driver during the run."""


@final
class _Kept(Plant):
    """Keeps what passes between plant and strategy, also of a run that a fault ends."""

    control_period = CONTROL_PERIOD

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        self.control_period = plant.control_period
        self.observations: list[Observation] = []
        self.commands: list[Command] = []
        self.statuses: list[Status] = []

    def reset(self) -> Observation:
        self.observations.append(self._plant.reset())
        return self.observations[0]

    def step(self, command: Command) -> Observation:
        seen = self._plant.step(command)
        self.commands.append(command)
        self.observations.append(seen)
        return seen

    def watch(self, observation: Observation, status: Status) -> None:
        self.statuses.append(status)

    def build_log(self, gave_up: str) -> RunLog:
        """Log of a run that ended early."""
        count = len(self.statuses)
        return RunLog(
            observations=tuple(self.observations[: count + 1]), commands=tuple(self.commands[:count]),
            statuses=tuple(self.statuses), gave_up=gave_up,
        )  # fmt: skip


def run_on_twin(
    design: TrunkDesign,
    shape: ObjectSpec,
    *,
    strategy: str | Strategy[Any] = "wrap-vertical",
    seed: int = 0,
    spread: Spread | None = None,
    options: TwinOptions | None = None,
    log: Path | None = None,
    prepare: Callable[[TwinRobot], None] | None = None,
    watch: Callable[[Observation, Status], None] | None = None,
) -> DriveTrial:
    """Draw a scene as `run_trial` does, home and arm a twin in it, and run the strategy on it, unchanged.

    The twin has no noise or delay added to its sensors: both come from its encoders, its bus and its estimates. The
    camera and the arm's torques have the errors of the scene.

    Args:
        design: the robot.
        shape: the object.
        strategy: by its name, or one of your own.
        seed: seed of scene and twin.
        spread: how far scenes differ.
        options: the twin; its seed is ``seed`` unless given.
        log: MCAP file to write; None for none.
        prepare: called with the twin before homing, such as to inject faults.
        watch: called after every step.

    Raises:
        ModelError: where the strategy cannot plan for the object.
        RunError: where the twin cannot be homed or armed.
        OutputError: where the log exists.
    """
    chosen = strategies.get(strategy) if isinstance(strategy, str) else strategy
    drawn = replace(draw_scene(shape, seed, strategy=chosen, spread=spread), timestep=STEP)
    scene = set_ground(design, drawn, chosen)
    with TwinRobot(design, scene, TwinOptions(seed=seed) if options is None else options) as robot:
        if prepare is not None:
            prepare(robot)
        robot.prepare()
        homing, began = robot.clock.now(), time.perf_counter()
        warnings: dict[str, None] = {}

        def look(seen: Observation, status: Status) -> None:
            warnings.update(dict.fromkeys(robot.driver.snapshot().warnings))
            if watch is not None:
                watch(seen, status)

        run_log, snapshot = run_logged(robot, robot.build_plant(), chosen, log, look, bus="virtual", seed=seed)
        assert robot.machine is not None
        factor = robot.machine.trace[-1].time / max(1e-9, time.perf_counter() - began)
        trial = Trial(
            strategy=chosen.name, seed=seed, options=scene, plant=robot.machine, log=run_log,
            verdict=JOBS[chosen.job](Evidence.from_run(robot.machine, run_log)), real_time_factor=factor,
        )  # fmt: skip
        return DriveTrial(trial=trial, snapshot=snapshot, homing=homing, warnings=tuple(warnings))


def run_logged(
    robot: Robot, plant: HardwarePlant, strategy: Strategy[Any], path: Path | None,
    watch: Callable[[Observation, Status], None], *, bus: str, seed: int | None = None,
) -> tuple[RunLog, Snapshot]:  # fmt: skip
    """Run the strategy on an armed robot until it is done or a fault ends it, and let go.

    Returns what passed between robot and strategy, and the driver's state at the end of the run, before it let go. The
    log is closed after that: it takes up to seconds, in which nothing renews the driver's targets.

    Args:
        robot: the robot.
        plant: its plant.
        strategy: what to do.
        path: MCAP file to write; None for none.
        watch: called after every step.
        bus: the motors' bus, "virtual" for the twin.
        seed: the twin's seed; None for the real robot.

    Raises:
        OutputError: where the log exists.
        RunError: where a fault ended it before its first step, or came while it let go.
    """
    if path is None:
        return _run_to_fault(robot, plant, strategy, watch), robot.finish()
    metadata = LogMetadata(
        design=format_design(robot.design), bus=bus, is_twin=bus == "virtual", seed=seed,
        versions=read_versions("mujoco", "mink", "numpy"), provenance=f"spiraltrunk drive run {strategy.name}",
        task=describe_task(plant.task),
    )  # fmt: skip
    with LogWriter(path, robot.clock.now(), metadata, waits=isinstance(robot.clock, TwinClock)) as writer:
        logged, record = LoggedPlant(plant, writer, robot.clock), Recorder(writer)

        def look(seen: Observation, status: Status) -> None:
            logged.watch(seen, status)
            record(robot.driver)
            watch(seen, status)

        run_log = _run_to_fault(robot, logged, strategy, look)
        snapshot = _finish(robot, record)
        logged.end(run_log)
        return run_log, snapshot


def _finish(robot: Robot, record: Recorder) -> Snapshot:
    """Let go as `Robot.finish` does, with it in the log."""
    shown = robot.watch

    def look(driver: Driver) -> None:
        record(driver)
        if shown is not None:
            shown(driver)

    record(robot.driver)
    robot.watch = look
    try:
        return robot.finish()
    finally:
        robot.watch = shown
        record(robot.driver)


def _run_to_fault(
    robot: Robot, plant: Plant, strategy: Strategy[Any], watch: Callable[[Observation, Status], None]
) -> RunLog:
    """Run the strategy; a latched fault ends it as if it gave up, with the fault's text."""
    kept = _Kept(plant)

    def look(seen: Observation, status: Status) -> None:
        kept.watch(seen, status)
        watch(seen, status)

    try:
        return run(kept, strategy, watch=look)
    except RunError as error:
        if not robot.driver.faults or not kept.statuses:
            raise
        log = kept.build_log(str(error))
        return replace(log, statuses=(*log.statuses[:-1], replace(log.statuses[-1], gave_up=str(error))))
