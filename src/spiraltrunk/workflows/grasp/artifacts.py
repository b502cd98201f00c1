"""Artifacts of a trial: result, design, plots, film strip and video."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, final

import numpy as np

from spiraltrunk.control.loop import RunLog
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.design.toml import format_design
from spiraltrunk.errors import MissingPackage
from spiraltrunk.files.atomic import write_text
from spiraltrunk.files.results import Progress, format_json, ignore_progress, read_versions, to_json
from spiraltrunk.model.kinematics.curl_front import compute_propagation
from spiraltrunk.report import Series, write_plots
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.strategies.moves import PHASES
from spiraltrunk.workflows.grasp.choice.candidates import Candidate
from spiraltrunk.workflows.grasp.choice.last_try import is_refused, list_attempts, list_candidates
from spiraltrunk.workflows.grasp.choice.other_grounds import rank_over_grounds
from spiraltrunk.workflows.grasp.pictures import write_failure, write_film, write_strip
from spiraltrunk.workflows.grasp.trial import Trial
from spiraltrunk.workflows.grasp.verdict.grasp_verdict import Verdict

_FILES = (
    "result.json", "trunk.toml", "overview.png", "cables.png", "joints.png", "curvature.png", "object.png", "force.png",
)  # fmt: skip
"""Files that a trial can leave, without its pictures."""

_OF_MOTION = (
    "front", "lift_m", "carry_m", "hold_s", "place_error_m", "upright", "tilt_deg", "max_penetration_m",
    "max_joint_deg", "real_time_factor",
)  # fmt: skip
"""Figures of a motion: null where nothing moved."""

_PICTURES = ("grasp.mp4", "filmstrip.png", "failure.png")
"""Pictures that a trial can leave; that of a failure, a failed one."""


@final
@dataclass(frozen=True, kw_only=True)
class Artifacts:
    """Result of a trial, and whether its pictures could be drawn."""

    result: dict[str, Any]
    """Verdict and figures, ready for JSON."""
    missing: str | None = None
    """Why there is no film strip or video, where they were asked for."""


def list_files(*, video: bool = True) -> tuple[str, ...]:
    """All files that a trial can leave; ``video`` says whether film strip and video are asked for."""
    return (*_FILES, *_PICTURES) if video else _FILES


def compute_result(trial: Trial, name: str, files: tuple[str, ...] = ()) -> dict[str, Any]:
    """Verdict and figures of a trial with the object called ``name``, ready for JSON."""
    spans = compute_phase_spans(trial.log)
    figures = {
        "strategy": trial.strategy,
        "object": name,
        "seed": trial.seed,
        **_describe_outcome(trial.verdict),
        "phases": [{"name": phase, "start_s": begin, "end_s": end} for phase, begin, end in spans],
        "front": _compute_front_figures(trial),
        **_describe_motion(trial.verdict),
        "real_time_factor": trial.real_time_factor,
        "world": _describe_world(trial.options),
        "timestep_s": trial.options.timestep,
        "versions": read_versions("mujoco", "mink", "numpy"),
        "files": list(files),
    }
    candidates = list_candidates(trial.log)
    if candidates is not None:
        figures |= _compute_choice(candidates, trial)
    if is_refused(trial.log):
        figures |= {"phases": [], **dict.fromkeys(_OF_MOTION)}
    return {key: to_json(value) for key, value in figures.items()}


def _describe_outcome(verdict: Verdict) -> dict[str, Any]:
    failure = verdict.failure
    return {
        "success": verdict.success,
        "reason": verdict.reason,
        "cause": None if failure is None else failure.cause.value,
        "cause_time_s": None if failure is None else failure.time,
    }


def _describe_motion(verdict: Verdict) -> dict[str, Any]:
    return {
        "lift_m": verdict.lift,
        "carry_m": verdict.carry,
        "hold_s": verdict.hold,
        "held": verdict.is_held,
        "place_error_m": verdict.place_error,
        "upright": verdict.is_upright,
        "tilt_deg": None if verdict.tilt is None else math.degrees(verdict.tilt),
        "max_penetration_m": verdict.penetration,
        "max_joint_deg": math.degrees(verdict.bend),
        "limits_judged": not verdict.unjudged,
        "limits_not_judged": list(verdict.unjudged),
    }


def _describe_world(options: SceneOptions) -> dict[str, Any]:
    return {
        "ground_m": options.ground if options.support == "ground" else None,
        "offset_m": list(options.offset),
        "friction": options.shape.friction,
        "stiffness_factor": options.trunk.stiffness_factor,
        "width_m": options.shape.width,
        "mass_kg": options.shape.mass,
        "yaw_deg": math.degrees(options.yaw),
        "yaw_error_deg": math.degrees(options.yaw_error),
    }


def _compute_choice(candidates: tuple[Candidate, ...], trial: Trial) -> dict[str, Any]:
    """What a run that chose its strategy ranked, over all grounds, and tried."""
    tries = (
        {
            "strategy": each.strategy, "start_s": each.began,
            "place_correction_m": list(each.told.goal.place - each.task.goal.place),
            "outcome": each.outcome or trial.verdict.reason,
        }
        for each in list_attempts(trial.log)
    )  # fmt: skip
    ranked = rank_over_grounds(trial.plant.task.design, trial.options, candidates)
    return {"candidates": [asdict(each) for each in ranked], "attempts": list(tries)}


def _compute_front_figures(trial: Trial) -> dict[str, float | bool | None]:
    """End of the curl over the trunk's length, and whether it spread from tip to base and back [-]."""
    trace, design = trial.plant.trace, trial.plant.task.design
    found = compute_propagation(
        np.array([s.time for s in trace]), np.array([s.joint_bend for s in trace]), compute_phase_spans(trial.log),
        section_length=design.section_length, joint_limit=design.joint_limit,
    )  # fmt: skip
    return {**asdict(found), "is_inward": found.is_inward, "is_outward": found.is_outward}


def compute_phase_spans(log: RunLog) -> tuple[tuple[str, float, float], ...]:
    """Name, start and end of each phase that came, each lasting until the next begins [-, s, s]."""
    begins = [(phase, span[0]) for phase in PHASES if (span := log.span(phase)) is not None]
    ends = [*(begin for _, begin in begins[1:]), log.observations[-1].time]
    return tuple((phase, begin, end) for (phase, begin), end in zip(begins, ends, strict=False))


def write_artifacts(
    trial: Trial, name: str, folder: Path, *, video: bool = True, workers: int = 1, progress: Progress = ignore_progress
) -> Artifacts:
    """Write everything about a trial into a folder; without OpenGL, everything but film strip and video.

    Of a choice that found no strategy there is the result alone: nothing moved.

    Args:
        trial: a trial that has run.
        name: name of the object.
        folder: an existing folder.
        video: whether to draw film strip and video.
        workers: processes that draw the video.
        progress: called as the work goes on.

    Raises:
        OSError: where a file cannot be written.
    """
    missing = None if is_refused(trial.log) else _write_course(trial, name, folder, workers if video else 0, progress)
    files = tuple(sorted({*(path.name for path in folder.iterdir()), "result.json"}))
    result = compute_result(trial, name, files)
    write_text(folder / "result.json", format_json(result) + "\n")
    return Artifacts(result=result, missing=missing)


def _write_course(trial: Trial, name: str, folder: Path, workers: int, progress: Progress) -> str | None:
    """Write design, plots and, with ``workers``, pictures; why there are none, where they were asked for."""
    series = compute_series(trial, name)
    write_text(folder / "trunk.toml", format_design(trial.plant.design))
    progress("plots", 0, 1)
    write_plots(series, folder)
    if workers:
        try:
            write_strip(trial, folder / "filmstrip.png", title=series.title)
            write_failure(trial, folder / "failure.png", title=series.title)
            write_film(trial, folder / "grasp.mp4", workers, progress)
        except MissingPackage as error:
            return str(error)
    return None


def compute_series(trial: Trial, name: str) -> Series:
    """True quantities of the trial over time, for plots."""
    trace, task = trial.plant.trace, trial.plant.task
    columns = ("time", "cable_pull", "cable_tension", "joint_bend", "grip_force", "string_tension")
    height = np.array([s.object_position[2] for s in trace])
    lifting, lift = trial.log.milestone_span(Milestone.LIFTED), None
    if lifting is not None:
        start = next(float(h) for s, h in zip(trace, height, strict=True) if s.time > lifting[0] - 1e-9)
        lift = start, start + task.goal.lift
    shown = name if len(name) <= 40 else trial.options.shape.kind
    return Series(
        **{column: np.array([getattr(s, column) for s in trace]) for column in columns},
        phase_spans=compute_phase_spans(trial.log), joint_limit=task.design.joint_limit,
        section_length=task.design.section_length, object_height=height, lift=lift,
        title=f"{trial.strategy}, {shown}, seed {trial.seed}: {trial.verdict.reason}",
    )  # fmt: skip
