"""Recorded trials that take no time, in a module that processes can import; they depend on the seed alone."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from spiraltrunk.control.encoding import parse_control_mode
from spiraltrunk.control.messages import CameraObservation, Command, Observation, Task
from spiraltrunk.design import presets
from spiraltrunk.design.toml import format_design
from spiraltrunk.processes.pool import Outcome
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.scene.build import build_task
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.workflows.demos.options import RecordingOptions
from spiraltrunk.workflows.demos.recording.episode import (
    MILESTONE_NAMES,
    PHASE_NAMES,
    Episode,
    describe_task,
    stack_commands,
    stack_observations,
)
from spiraltrunk.workflows.demos.recording.episode_file import name_episode, write_episode
from spiraltrunk.workflows.demos.recording.frames import choose_steps, encode_frames
from spiraltrunk.workflows.demos.recording.pictures import encode_lossless
from spiraltrunk.workflows.survey.plan import Entry
from spiraltrunk.workflows.survey.row import build_empty_row

N_ARM, N_STATE = 7, 20
"""Joints of the arm, and numbers of the simulator's state."""


def run_inline(work: Callable[[Any], Any], jobs: Iterable[Any], workers: int) -> Iterator[Outcome[Any, Any]]:
    """An engine without processes, which take seconds to start."""
    for job in jobs:
        yield Outcome(job=job, result=work(job))


@cache
def build_fake_task(name: str) -> Task:
    return build_task(presets.PAPER, SceneOptions(shape=parse_object(name), support="ground", orientation="upright"))


def draw_messages(seed: int, count: int, name: str = "cylinder-60") -> tuple[list[Observation], list[Command]]:
    """Observations and commands of an arm that wanders slowly; the camera sees from the second on."""
    rng, task = np.random.default_rng(seed), build_fake_task(name)
    T = np.eye(4)
    T[:3, 3] = task.target.position + np.array([0.0, 0.0, 0.5])
    T[:3, :3] = [[0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]]
    seen, commands = [], []
    for k in range(count + 1):
        camera = CameraObservation(time=0.02 * (k // 10), position=rng.normal(size=3), axis=np.array([0.0, 0.0, 1.0]))
        seen.append(
            Observation(
                time=0.02 * k, task=task, T_world_base=T, arm_position=rng.uniform(-1, 1, N_ARM),
                arm_velocity=rng.uniform(-1, 1, N_ARM), cable_pull=rng.uniform(0, 0.05, 3),
                cable_tension=rng.uniform(0, 5, 3), base_force=rng.normal(size=3), base_torque=rng.normal(size=3),
                camera=camera if k else None,
            )
        )  # fmt: skip
        T = T.copy()
        T[:3, 3] += rng.uniform(-0.004, 0.004, 3)
        T[:3, :3] = Rotation.from_rotvec(rng.uniform(-0.01, 0.01, 3)).as_matrix() @ T[:3, :3]
        pull = None if k < count // 2 else np.array([0.01, 0.02, np.inf])
        command = Command(
            T_world_base=T, cable_tension=rng.uniform(0, 10, 3), cable_pull=pull, gripper=float(rng.uniform(-1, 1))
        )
        commands.append(command)
    return seen, commands[:count]


def build_episode(
    seed: int = 5,
    *,
    count: int = 23,
    success: bool = True,
    recording: RecordingOptions | None = None,
    strategy: str = "wrap-vertical",
    index: int = 0,
    name: str = "cylinder-60",
) -> Episode:
    recording = RecordingOptions() if recording is None else recording
    rng = np.random.default_rng(seed)
    seen, commands = draw_messages(seed, count, name)
    led = [rng.uniform(-1, 1, N_ARM) for _ in commands]
    shown = len(choose_steps(count, recording.stride))
    about = {
        "schema": 3, "strategy": strategy, "object": name, "seed": seed, "success": success,
        "job": "kick" if strategy == "kick" else "grasp",
        "reason": "success" if success else "lifted 2 cm", "cause": None, "index": index,
        "world": {"support": "ground", "orientation": "upright", "friction": 0.8}, "versions": {"mujoco": "4"},
        "verdict": {"lift_m": 0.2, "timestep_s": 0.002}, "design": format_design(presets.PAPER),
        "task": describe_task(seen[0].task),
        "recording": recording.settings(), "phases": list(PHASE_NAMES), "milestones": list(MILESTONE_NAMES),
    }  # fmt: skip
    return Episode(
        about=about,
        **stack_observations(seen),
        **stack_commands(commands),
        command_arm_position=np.stack(led),
        phase=rng.integers(len(PHASE_NAMES), size=count).astype(np.int8),
        milestone=rng.integers(len(MILESTONE_NAMES), size=count).astype(np.int8),
        action=np.array([("lift", "hold it")[k % 2] for k in range(count)]),
        state=rng.normal(size=(count + 1, N_STATE)),
        frames=encode_frames(seen, commands, led, mode=parse_control_mode(recording.mode), stride=recording.stride),
        scene="<mujoco/>",
        videos={name: encode_lossless(draw_pictures(seed, shown, recording.size), 10) for name in recording.cameras},
    )  # fmt: skip


def draw_pictures(seed: int, count: int, size: int) -> list[np.ndarray]:
    """Pictures of one colour each, darker from one to the next, with a mark that tells the seed."""
    pictures = [np.full((size, size, 3), (200 - 5 * k, 40 + 5 * k, 90), np.uint8) for k in range(count)]
    for picture in pictures:
        picture[: size // 2, : size // 2] = seed % 251
    return pictures


def work(entry: Entry, folder: Path, recording: RecordingOptions = RecordingOptions()) -> dict[str, Any]:  # noqa: B008
    """One trial of three fails."""
    is_success = entry.seed % 3 != 0
    row = build_empty_row(entry, "success" if is_success else "lifted 2 cm")
    row |= {"success": is_success, "cause": None if is_success else "slipped", "simulated_s": 30.0, "wall_s": 1.0}
    if is_success or recording.keeps_failures:
        episode = build_episode(
            entry.seed, count=20 + entry.seed % 7, success=is_success, recording=recording, strategy=entry.strategy,
            index=entry.index, name=entry.object,
        )  # fmt: skip
        write_episode(episode, folder / name_episode(entry.strategy, entry.index))
    return row


def work_slowly(entry: Entry, folder: Path) -> dict[str, Any]:
    time.sleep(0.15)
    return work(entry, folder)


def hang_after_third(entry: Entry, folder: Path) -> dict[str, Any]:
    if entry.index >= 3:
        time.sleep(60)
    return work(replace(entry, seed=1), folder) | {"seed": entry.seed}


def fail(entry: Entry, folder: Path) -> dict[str, Any]:
    return build_empty_row(entry, "lifted 2 cm") | {"simulated_s": 3.0}
