"""What a trial leaves behind: result, design, plots, film strip and video, all of them or none."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, final

import numpy as np

from spiraltrunk.control.loop import RunLog
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.design.toml import write_design
from spiraltrunk.errors import MissingPackage
from spiraltrunk.files.atomic import atomic_folder
from spiraltrunk.files.results import Progress, format_json, ignore_progress, read_versions, to_json
from spiraltrunk.model.kinematics.curl_front import compute_propagation
from spiraltrunk.report import Series, write_filmstrip, write_plots, write_video
from spiraltrunk.sim.ground_truth import Sample
from spiraltrunk.sim.render import View, render_frames
from spiraltrunk.strategies.moves import PHASES
from spiraltrunk.workflows.grasp.trial import Trial

FPS = 10
"""Frames per second of the video, which plays in real time."""

FILES = (
    "result.json", "trunk.toml", "grasp.mp4", "filmstrip.png", "overview.png", "cables.png", "joints.png",
    "curvature.png", "object.png", "force.png",
)  # fmt: skip
"""Everything that a trial can leave behind."""

_HOW_FAR = {Milestone.HELD: 0.5}
"""Where in the steps of a milestone its picture is taken, 0 to 1 [-]; 1, where it is reached, for the others."""

_UNSHOWN = (Milestone.CARRIED,)
"""Milestones without a picture of their own: the object is where it is held afterwards."""

_PARTS = (("prehension", 0.55), ("prehension", 1.0), ("reach", 0.5))
"""Pictures between milestones: phase, and how far into it [-]; those first in the list come first."""

_VIEWS = {
    "hung": View(lookat=(0.32, 0.20, 1.14), distance=1.70),
    "ground": View(lookat=(0.40, 0.10, 1.08), distance=2.15),
}
"""Where the camera stands: the arm's raised wrist and the trunk are both in the picture."""


@final
@dataclass(frozen=True, kw_only=True)
class Record:
    """What came of a trial and of writing it down."""

    result: dict[str, Any]
    """Verdict and figures, ready for JSON."""
    missing: str | None = None
    """Why there is no film strip or video, where they were asked for."""


def compute_result(trial: Trial, name: str, files: tuple[str, ...] = ()) -> dict[str, Any]:
    """Verdict and figures of a trial with the object that was called ``name``, ready for JSON."""
    verdict, options = trial.verdict, trial.options
    figures = {
        "strategy": trial.strategy,
        "object": name,
        "seed": trial.seed,
        "success": verdict.success,
        "reason": verdict.reason,
        "phases": [
            {"name": phase, "start_s": begin, "end_s": end} for phase, begin, end in compute_phase_spans(trial.log)
        ],
        "front": compute_front_figures(trial),
        "lift_m": verdict.lift,
        "carry_m": verdict.carry,
        "hold_s": verdict.hold,
        "place_error_m": verdict.place_error,
        "max_penetration_m": verdict.penetration,
        "max_joint_deg": math.degrees(verdict.bend),
        "limits_judged": not verdict.unjudged,
        "limits_not_judged": list(verdict.unjudged),
        "real_time_factor": trial.real_time_factor,
        "world": {
            "offset_m": list(options.offset),
            "friction": options.shape.friction,
            "stiffness_factor": options.trunk.stiffness_factor,
            "width_m": options.shape.width,
            "mass_kg": options.shape.mass,
            "yaw_deg": math.degrees(options.yaw),
            "yaw_error_deg": math.degrees(options.yaw_error),
        },
        "versions": read_versions("mujoco", "mink", "numpy"),
        "files": list(files),
    }
    return {key: to_json(value) for key, value in figures.items()}


def compute_front_figures(trial: Trial) -> dict[str, float | bool | None]:
    """Where the curl ended, over the trunk's length, and whether it spread from tip to base and back [-]."""
    trace, design = trial.plant.trace, trial.plant.task.design
    found = compute_propagation(
        np.array([s.time for s in trace]), np.array([s.joint_bend for s in trace]), compute_phase_spans(trial.log),
        section_length=design.section_length, joint_limit=design.joint_limit,
    )  # fmt: skip
    return {**asdict(found), "is_inward": found.is_inward, "is_outward": found.is_outward}


def compute_phase_spans(log: RunLog) -> tuple[tuple[str, float, float], ...]:
    """Name, begin and end of each phase that came, each lasting until the next begins [-, s, s]."""
    spans = [(phase, log.span(phase)) for phase in PHASES]
    come = [(phase, span) for phase, span in spans if span is not None]
    ends = [span[0] for _, span in come[1:]] + [log.observations[-1].time] * bool(come)
    return tuple((phase, span[0], end) for (phase, span), end in zip(come, ends, strict=True))


@contextmanager
def open_record(folder: str | Path) -> Iterator[Path]:
    """A draft folder to write to; at the end of the block its files move to ``folder``, which is made where missing.

    Files of an earlier trial go then; where the block raises, everything is as it was.

    Raises:
        OSError: where the folder cannot be made or written.
    """
    with atomic_folder(folder, FILES) as draft:
        yield draft


def write_record(
    trial: Trial, name: str, folder: Path, *, video: bool = True, workers: int = 1, progress: Progress = ignore_progress
) -> Record:
    """Write everything about a trial into a folder; without OpenGL, everything but film strip and video.

    Args:
        trial: a trial that has run.
        name: what the object was called.
        folder: an existing folder.
        video: whether to draw film strip and video.
        workers: processes that draw the video; more than one need a main module that can be imported.
        progress: called as the work goes on.

    Raises:
        OSError: where a file cannot be written.
    """
    series, missing = compute_series(trial, name), None
    write_design(trial.plant.design, folder / "trunk.toml")
    progress("plots", 0, 1)
    write_plots(series, folder)
    if video:
        try:
            write_pictures(trial, folder, title=series.title, workers=workers, progress=progress)
        except MissingPackage as error:
            missing = str(error)
    files = tuple(sorted({*(path.name for path in folder.iterdir()), "result.json"}))
    result = compute_result(trial, name, files)
    (folder / "result.json").write_text(format_json(result) + "\n")
    return Record(result=result, missing=missing)


def write_pictures(
    trial: Trial, folder: Path, *, title: str = "", workers: int = 1, progress: Progress = ignore_progress
) -> None:
    """Write film strip and video.

    Raises:
        MissingPackage: where there is no OpenGL or no encoder.
        OSError: where a file cannot be written.
    """
    write_strip(trial, folder / "filmstrip.png", title=title)
    trace, period = trial.plant.trace, trial.plant.control_period
    shown = [sample.qpos for sample in trace[:: max(1, round(1 / (FPS * period)))]]

    def frames() -> Iterator[np.ndarray]:
        view = replace(_VIEWS[trial.options.stage], has_shadows=False)
        for i, frame in enumerate(render_frames(trial.plant.model, shown, view, workers=workers)):
            progress("video", i, len(shown))
            yield frame

    write_video(folder / "grasp.mp4", frames(), FPS)


def write_strip(trial: Trial, path: Path, *, title: str = "") -> None:
    """Write a sheet of eight telling moments, each with its phase and time.

    Raises:
        MissingPackage: where there is no OpenGL.
        OSError: where the file cannot be written.
    """
    moments = find_moments(trial)
    frames = list(render_frames(trial.plant.model, [sample.qpos for _, sample in moments], _VIEWS[trial.options.stage]))
    captions = [caption for caption, _ in moments]
    write_filmstrip(path, frames, captions, title=title)


def find_moments(trial: Trial, count: int = 8) -> list[tuple[str, Sample]]:
    """Captions and samples of a film strip, in order of time.

    Every milestone is shown. Up to ``count``, moments of the phases are added, then ends of further actions, evenly
    chosen; these are captioned by the action.
    """
    trace, statuses = trial.plant.trace, trial.log.statuses
    if not statuses:
        return [(f"start, {trace[0].time:.1f} s", trace[0])]
    shown = {}
    for milestone in Milestone:
        ticks = [i for i, status in enumerate(statuses) if status.milestone is milestone]
        if ticks and milestone not in _UNSHOWN:
            shown[_at(ticks, _HOW_FAR.get(milestone, 1.0))] = milestone.value
    for phase, part in _PARTS:
        ticks = [i for i, status in enumerate(statuses) if status.phase == phase]
        if ticks and len(shown) < count and statuses[_at(ticks, part)].milestone in (None, *_UNSHOWN):
            shown.setdefault(_at(ticks, part), statuses[_at(ticks, part)].action)
    told = {statuses[i].action for i in shown}
    ends = sorted({status.action: i for i, status in enumerate(statuses) if status.action not in told}.values())
    for choice in np.linspace(0, len(ends) - 1, max(0, min(len(ends), count - len(shown)))):
        shown[ends[round(choice)]] = statuses[ends[round(choice)]].action
    return [
        (f"{statuses[i].phase}: {shown[i]}, {trace[i + 1].time:.1f} s", trace[i + 1]) for i in sorted(shown)
    ]  # fmt: skip


def _at(ticks: list[int], part: float) -> int:
    return ticks[round(part * (len(ticks) - 1))]


def compute_series(trial: Trial, name: str) -> Series:
    """The trial's true quantities over time, for plots."""
    trace, task = trial.plant.trace, trial.plant.task
    shown = name if len(name) <= 40 else trial.options.shape.kind
    return Series(
        time=np.array([s.time for s in trace]),
        phase_spans=compute_phase_spans(trial.log),
        cable_pull=np.array([s.cable_pull for s in trace]),
        cable_tension=np.array([s.cable_tension for s in trace]),
        joint_bend=np.array([s.joint_bend for s in trace]),
        joint_limit=task.design.joint_limit,
        section_length=task.design.section_length,
        object_height=np.array([s.object_position[2] for s in trace]),
        lift=_find_lift(trial),
        grip_force=np.array([s.grip_force for s in trace]),
        string_tension=np.array([s.string_tension for s in trace]),
        title=f"{trial.strategy}, {shown}, seed {trial.seed}: {trial.verdict.reason}",
    )


def _find_lift(trial: Trial) -> tuple[float, float] | None:
    """Height of the object where its lift begins, and the height to which it is to be lifted [m]; None for no lift."""
    begin = trial.log.milestone_span(Milestone.LIFTED)
    if begin is None:
        return None
    start = float(next(s.object_position[2] for s in trial.plant.trace if s.time >= begin[0] - 1e-9))
    return start, start + trial.plant.task.goal.lift
