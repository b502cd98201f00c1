"""Recording of a trial for viewers: what is seen, and where all of it is, thirty times a second."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.control.strategy import Status
from spiraltrunk.sim.body_meshes import BodyPoses, ModelMeshes, build_meshes
from spiraltrunk.sim.ground_truth import Sample
from spiraltrunk.sim.machine import SimMachine
from spiraltrunk.workflows.grasp.trial import Trial

RATE = 30
"""Frames per second of simulated time [1/s]."""

START = "start"
"""Action of the frames before the strategy's first step."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Frames:
    """Successive frames of a trial, n of them, `RATE` in a second."""

    time: np.ndarray
    """Simulated time, shape (n,) [s]."""
    pose: np.ndarray
    """Position and quaternion (w first) of each body, shape (n, n_body, 7), float32 [m, -]."""
    string: np.ndarray
    """Both ends of each string, shape (n, n_string, 2, 3), float32 [m]."""
    tension: np.ndarray
    """Tension of each cable, shape (n, n_cable) [N]."""
    height: np.ndarray
    """Height of the object's centre, shape (n,) [m]."""
    grip_force: np.ndarray
    """Sum of the normal forces between trunk and object, shape (n,) [N]."""
    phase: tuple[str, ...]
    """Phase of each frame."""
    action: tuple[str, ...]
    """Action of each frame, in the strategy's words."""

    def __len__(self) -> int:
        return len(self.time)

    def spans(self) -> tuple[tuple[str, float, float], ...]:
        """Name, start and end of each stretch of one phase [-, s, s]."""
        first = [i for i, phase in enumerate(self.phase) if i == 0 or phase != self.phase[i - 1]]
        ends = [*first[1:], len(self) - 1]
        return tuple(
            (self.phase[i], float(self.time[i]), float(self.time[end])) for i, end in zip(first, ends, strict=True)
        )


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Recording:
    """Everything that a viewer needs to show a trial."""

    title: str
    """What it shows, in a line."""
    meshes: ModelMeshes
    """Surfaces of the bodies."""
    frames: Frames
    """Poses of the bodies, and figures, over time."""


@final
class Recorder:
    """Takes frames from a machine while a strategy runs on it: `watch` is for `control.loop.run`.

    A frame between two samples of the trace is interpolated between them.
    """

    def __init__(self, machine: SimMachine) -> None:
        self._machine = machine
        self._poses = BodyPoses(machine.model)
        self._before: tuple[Sample, np.ndarray, np.ndarray] | None = None
        self._taken: list[tuple[float, np.ndarray, np.ndarray, np.ndarray, float, float, str, str]] = []
        self._count = 0

    def watch(self, observation: object, status: Status) -> None:
        """Take the frames up to the last sample of the machine's trace."""
        if self._before is None:
            self.add(self._machine.trace[0], Status(phase=status.phase, action=START))
        self.add(self._machine.trace[-1], status)

    def add(self, sample: Sample, status: Status) -> None:
        """Take the frames up to a sample; the first sample is the first frame."""
        pose, string = self._poses.compute(sample.qpos)
        if self._before is None:
            self._before = sample, pose, string
        while self._count / RATE <= sample.time + 1e-9:
            self._taken.append(self._interpolate(sample, pose, string, status))
            self._count += 1
        self._before = sample, pose, string

    def take(self) -> Frames | None:
        """The frames since the last call; None where there are none."""
        taken, self._taken = self._taken, []
        if not taken:
            return None
        time, pose, string, tension, height, force, phase, action = zip(*taken, strict=True)
        return Frames(
            time=np.array(time), pose=np.array(pose, np.float32), string=np.array(string, np.float32),
            tension=np.array(tension), height=np.array(height), grip_force=np.array(force), phase=phase, action=action,
        )  # fmt: skip

    def _interpolate(
        self, after: Sample, pose: np.ndarray, string: np.ndarray, status: Status
    ) -> tuple[float, np.ndarray, np.ndarray, np.ndarray, float, float, str, str]:
        assert self._before is not None
        before, old_pose, old_string = self._before
        time, step = self._count / RATE, after.time - before.time
        part = min(max((time - before.time) / step, 0.0), 1.0) if step > 0.0 else 1.0

        def between(old: np.ndarray, new: np.ndarray) -> np.ndarray:
            return np.asarray((1 - part) * np.asarray(old) + part * np.asarray(new))

        return (
            time, interpolate_poses(old_pose, pose, part), between(old_string, string),
            between(before.cable_tension, after.cable_tension),
            float(between(before.object_position[2], after.object_position[2])),
            float(between(np.array(before.grip_force), np.array(after.grip_force))), status.phase, status.action,
        )  # fmt: skip


def record(trial: Trial, title: str = "") -> Recording:
    """Recording of a trial that has run."""
    recorder, statuses = Recorder(trial.plant), trial.log.statuses
    first = statuses[0].phase if statuses else "reach"
    before = Status(phase=first, action=START)
    for sample, status in zip(trial.plant.trace, (before, *statuses), strict=False):
        recorder.add(sample, status)
    frames = recorder.take()
    assert frames is not None  # The first sample is a frame.
    shown = title or f"{trial.strategy}, seed {trial.seed}: {trial.verdict.reason}"
    return Recording(title=shown, meshes=build_meshes(trial.plant.model), frames=frames)


def join_frames(parts: Sequence[Frames]) -> Frames:
    """Frames one after the other."""
    arrays = ("time", "pose", "string", "tension", "height", "grip_force")
    return Frames(
        **{name: np.concatenate([getattr(part, name) for part in parts]) for name in arrays},
        phase=tuple(phase for part in parts for phase in part.phase),
        action=tuple(action for part in parts for action in part.action),
    )


def interpolate_poses(before: np.ndarray, after: np.ndarray, part: float) -> np.ndarray:
    """Poses at ``part`` of the way between two, shape (n_body, 7) [m, -].

    Positions are interpolated linearly, quaternions linearly with the nearer sign and then normalised, which differs
    from spherical interpolation by less than 1e-4 rad for turns below 0.1 rad.
    """
    mixed = (1 - part) * before
    sign = np.where((before[:, 3:] * after[:, 3:]).sum(axis=1, keepdims=True) < 0, -1.0, 1.0)
    mixed[:, :3] += part * after[:, :3]
    mixed[:, 3:] += part * sign * after[:, 3:]
    mixed[:, 3:] /= np.linalg.norm(mixed[:, 3:], axis=1, keepdims=True)
    return mixed
