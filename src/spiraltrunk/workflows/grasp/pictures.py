"""Pictures of a trial: film strip, moment of a failure, video."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from spiraltrunk.files.results import Progress
from spiraltrunk.report import write_filmstrip, write_video
from spiraltrunk.sim.framing import choose_size, frame_view
from spiraltrunk.sim.render import View, render_frames
from spiraltrunk.workflows.grasp.film_moments import Moment, find_moments
from spiraltrunk.workflows.grasp.trial import Trial

FPS = 10
"""Frames per second of the video, which plays in real time."""

VIEW = View(fovy=20.0)
"""Direction and size of all pictures; a narrow field, as a near camera distorts."""

AROUND = 0.5
"""Time before and after a failure of its further pictures [s] (ours)."""


def write_strip(trial: Trial, path: Path, *, title: str = "") -> None:
    """Write a sheet of the trial's moments, each with its phase and time, as near as trunk and object allow.

    Raises:
        MissingPackage: where there is no OpenGL.
        OSError: where the file cannot be written.
    """
    moments, model = find_moments(trial), trial.plant.model
    frames = list(render_frames(model, [moment.sample.qpos for moment in moments], frame_moments(trial, moments)))
    width, height = frames[0].shape[1::-1]
    write_filmstrip(
        path, frames, [moment.caption for moment in moments], columns=4 if 5 * width > 3 * height else 8,
        title=title, marked=[i for i, moment in enumerate(moments) if moment.is_failure],
    )  # fmt: skip


def frame_moments(trial: Trial, moments: Sequence[Moment]) -> list[View]:
    """A view for each moment: one for those of a push together, and one for each other moment."""
    push = [moment.sample.qpos for moment in moments if moment.is_push]
    groups = [push if moment.is_push else [moment.sample.qpos] for moment in moments]
    size = choose_size(trial.plant.model, groups, VIEW)
    return [frame_view(trial.plant.model, group, size) for group in groups]


def write_failure(trial: Trial, path: Path, *, title: str = "") -> None:
    """Write the moment at which a trial failed, marked, with what was AROUND before and after it; none of a success.

    Raises:
        MissingPackage: where there is no OpenGL.
        OSError: where the file cannot be written.
    """
    failure, trace, model = trial.verdict.failure, trial.plant.trace, trial.plant.model
    if failure is None:
        return
    times = [failure.time - AROUND, failure.time, failure.time + AROUND]
    samples = [min(trace, key=lambda sample: abs(sample.time - time)) for time in times]
    shown = [sample.qpos for sample in samples]
    view = frame_view(model, shown, choose_size(model, [shown], replace(VIEW, width=800, height=600)))
    captions = [f"{sample.time:.1f} s" for sample in samples]
    captions[1] = f"{failure.cause.value}, {captions[1]}"
    write_filmstrip(path, list(render_frames(model, shown, view)), captions, columns=3, title=title, marked=[1])


def write_film(trial: Trial, path: Path, workers: int, progress: Progress) -> None:
    """Write the trial as a video, from one camera that is as near as all of it allows.

    Raises:
        MissingPackage: where there is no OpenGL, or no encoder.
        OSError: where the file cannot be written.
    """
    step = max(1, round(1 / (FPS * trial.plant.control_period)))
    shown, model = [sample.qpos for sample in trial.plant.trace[::step]], trial.plant.model
    view = replace(frame_view(model, shown[::5], VIEW), has_shadows=False)

    def frames() -> Iterator[np.ndarray]:
        for i, frame in enumerate(render_frames(model, shown, view, workers=workers)):
            progress("video", i, len(shown))
            yield frame

    write_video(path, frames(), FPS)
