"""From a trial to its episode."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, final

import numpy as np

from spiraltrunk.control.encoding import parse_control_mode
from spiraltrunk.control.loop import RunLog
from spiraltrunk.control.messages import Observation
from spiraltrunk.control.strategy import Strategy
from spiraltrunk.design.toml import format_design
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.sim.scene.scene_file import format_scene
from spiraltrunk.workflows.demos.options import RecordingOptions
from spiraltrunk.workflows.demos.recording.episode import (
    MILESTONE_NAMES,
    PHASE_NAMES,
    Episode,
    describe_task,
    stack_commands,
    stack_observations,
)
from spiraltrunk.workflows.demos.recording.frames import encode_frames
from spiraltrunk.workflows.demos.recording.pictures import record_videos
from spiraltrunk.workflows.grasp.artifacts import compute_result
from spiraltrunk.workflows.grasp.trial import Trial, build_plant, run_plant

SCHEMA = 3
"""Version of the content of an episode's file."""

_UNTOLD = ("files", "world", "versions", "real_time_factor")
"""Parts of a trial's result that are not stored with its verdict; the last differs from run to run."""


@final
class Recorder:
    """Runs a trial and keeps what its log does not: velocities, and joint positions that commands lead to."""

    def __init__(self) -> None:
        self.trial: Trial | None = None
        """The trial that has run."""
        self.job = ""
        """What counts as success: the strategy's job."""
        self.velocity: list[np.ndarray] = []
        """Generalised velocities after each command, shape (n_v,) each [m/s, rad/s]."""
        self.arm_position: list[np.ndarray] = []
        """Joint positions of the arm that each command leads to, shape (n_arm,) each [rad]."""

    def run(self, design: TrunkDesign, options: SceneOptions, *, strategy: Strategy[Any], seed: int) -> Trial:
        """`run_scene`, recorded.

        Raises:
            ModelError: where the strategy cannot plan for the object.
            RunError: where the simulation diverges or does not end.
        """
        plant = build_plant(design, options, strategy)

        def watch(seen: Observation, status: object) -> None:
            self.velocity.append(plant.data.qvel.copy())

        self.job = strategy.job
        self.trial = run_plant(plant, strategy, seed=seed, watch=watch)
        self.arm_position = list_arm_positions(plant)
        return self.trial


def list_arm_positions(plant: SimPlant) -> list[np.ndarray]:
    """Joint positions of the arm that each command since the reset leads to, shape (n_arm,) each [rad].

    A command takes effect after the delay of the scene, so that its positions come later in the trace by as much. Those
    of the last commands, which have not taken effect, are what inverse kinematics makes of them from there on.
    """
    ahead = plant.predict_arm()
    return [*(sample.arm_command for sample in plant.trace[1 + len(ahead) :]), *ahead]


def build_episode(
    trial: Trial, recorder: Recorder, name: str, recording: RecordingOptions, extra: Mapping[str, Any]
) -> Episode:
    """The episode of a trial, its pictures rendered.

    Args:
        trial: a trial that has run, with one command or more.
        recorder: what ran it.
        name: name of the object.
        recording: what is recorded.
        extra: further provenance, ready for JSON.

    Raises:
        DesignError: for actions that set joints of an arm without known limits.
        MissingPackage: where there is no OpenGL for pictures, or no encoder.
    """
    positions = [sample.qpos for sample in trial.plant.trace]
    moving = np.stack([np.zeros_like(recorder.velocity[0]), *recorder.velocity])
    log, led = trial.log, recorder.arm_position
    times = np.array([sample.time for sample in trial.plant.trace])
    return Episode(
        about={**_describe(trial, name, recording), **extra},
        **stack_observations(log.observations),
        **stack_commands(log.commands),
        command_arm_position=np.stack(led),
        frames=encode_frames(
            log.observations, log.commands, led, mode=parse_control_mode(recording.mode), stride=recording.stride
        ),
        phase=np.array([PHASE_NAMES.index(each.phase) for each in log.statuses], np.int8),
        milestone=_number_milestones(log),
        action=np.array([each.action for each in log.statuses]),
        state=np.column_stack([times, np.stack(positions), moving]),
        scene=format_scene(trial.plant.design, trial.options),
        videos=record_videos(trial.plant, positions, recording),
    )


def _describe(trial: Trial, name: str, recording: RecordingOptions) -> dict[str, Any]:
    """Provenance of a trial, ready for JSON."""
    result, options = compute_result(trial, name), trial.options
    return {
        "schema": SCHEMA,
        **{key: result[key] for key in ("strategy", "object", "seed", "success", "reason", "cause")},
        "verdict": {key: value for key, value in result.items() if key not in _UNTOLD},
        "world": result["world"] | {"support": options.support, "orientation": options.orientation},
        "versions": result["versions"],
        "design": format_design(trial.plant.design),
        "task": describe_task(trial.plant.task),
        "phases": list(PHASE_NAMES),
        "milestones": list(MILESTONE_NAMES),
        "recording": recording.settings(),
    }


def _number_milestones(log: RunLog) -> np.ndarray:
    names = ["none" if each.milestone is None else each.milestone.value for each in log.statuses]
    return np.array([MILESTONE_NAMES.index(name) for name in names], np.int8)
