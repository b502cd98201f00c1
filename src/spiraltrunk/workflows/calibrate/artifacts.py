"""Artifacts of a calibration: result, calibrated design, figures and provenance, written all or none."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, final

import numpy as np

from spiraltrunk.calibration.calibrate import Calibration, Errors, Settings, calibrate
from spiraltrunk.calibration.identifiability import advise, list_correlated, list_misfitted, list_unidentified
from spiraltrunk.calibration.map_fit import is_twist_alone
from spiraltrunk.design.toml import format_design
from spiraltrunk.files.atomic import write_text
from spiraltrunk.files.output_folder import OutputFolder, open_output
from spiraltrunk.files.results import Progress, format_json, ignore_progress, read_versions, to_json
from spiraltrunk.mocap.session.shapes_json import write_shapes
from spiraltrunk.mocap.signal.deviation import PAPER
from spiraltrunk.model.kinematics.measured_shapes import MeasuredShapes
from spiraltrunk.report.calibration_plot import CalibrationBars, build_calibration_figure
from spiraltrunk.report.style import write_figure
from spiraltrunk.workflows.calibrate.joint_bench import BENCH_PLOT, Bench, summarise_bench, write_bench_plot
from spiraltrunk.workflows.calibrate.recordings import RecordedShapes, Recordings, list_files, read_recordings

WRITER = "calibrate"
"""Name of the command in output folders."""

_FILES = ("trunk.toml", "calibration.png", "shapes.json", "result.json")
"""Files of a calibration; with joint bench records also `BENCH_PLOT`."""

MODELS = ("calibrated", "uncalibrated", "reference")
"""Models whose errors are compared."""


@final
@dataclass(frozen=True, kw_only=True)
class CalibrationRun:
    """A calibration with everything it was made from."""

    recordings: Recordings
    """Fitted and held-out recordings."""
    settings: Settings
    """Prior knowledge."""
    bench: Bench | None
    """Joint bench records, if there are any."""
    recorded: RecordedShapes
    """Shapes read from the recordings."""
    found: Calibration
    """The fit."""


def run_calibration(
    recordings: Recordings, settings: Settings, bench: Bench | None = None, *, progress: Progress = ignore_progress
) -> CalibrationRun:
    """Read the recordings and fit the trunk's parameters to them.

    Raises:
        TakeError: for recordings that cannot be read.
        ModelError: for shapes that cannot be fitted.
    """
    progress("reading", 0, 1)
    recorded = read_recordings(recordings)
    found = calibrate(recordings.design, recorded.shapes, recorded.is_fitted, settings, progress=progress)
    return CalibrationRun(recordings=recordings, settings=settings, bench=bench, recorded=recorded, found=found)


def compute_result(run: CalibrationRun) -> dict[str, Any]:
    """All figures, ready for JSON; SI unless a key names its unit."""
    recordings = run.recordings
    result = {
        "design": recordings.design.name,
        "protocol": recordings.protocol.name,
        **_describe_parameters(run),
        "fitted": _average_errors(run.found.fitted, run.recorded.shapes),
        "held_out": _average_errors(run.found.held_out, run.recorded.shapes),
        "bench": None if run.bench is None else summarise_bench(run.bench),
        **_describe_fit(run.found),
        "takes": {"fitted": list_files(recordings.fitted), "held_out": list_files(recordings.held_out)},
        "paper": {
            "reference_mean_rmse_m": PAPER["bend_dorsal"]["mean_rmse_m"],
            "what": "the authors' model against their robot, bending",
        },
        "notes": _list_warnings(run),
        "odd_in_recordings": run.recorded.notes,
        "versions": read_versions("numpy"),
        "files": [],
    }
    return dict(to_json(result))


def _describe_parameters(run: CalibrationRun) -> dict[str, Any]:
    """The parameters, which of them the recordings do not determine, and what to record for these."""
    found = run.found
    was_weighed = run.settings.weighing is not None or bool(run.settings.bench)
    return {
        "parameters": {
            p.name: {
                "unit": p.unit, "before": p.before, "value": p.value, "low_95": p.low, "high_95": p.high,
                "width_over_prior": p.width_ratio, "is_told": p.is_identified,
            }
            for p in found.parameters
        },
        "not_told": [parameter.name for parameter in list_unidentified(found)],
        "told_together": [{"names": [a, b], "correlation": c} for a, b, c in list_correlated(found)],
        "to_record": advise(found, was_weighed=was_weighed),
    }  # fmt: skip


def _describe_fit(found: Calibration) -> dict[str, Any]:
    """Misfit by run and of all, and whether the fit converged."""
    misfitted = list_misfitted(found)
    return {
        "misfit_by_run": [
            {
                "take": one.take, "kind": one.kind, "shapes": one.n_shape, "rms_m": one.rms,
                "registered_rms_m": one.registered_rms, "discrepancy_at_tip_m": one.discrepancy,
                "is_out_of_proportion": one in misfitted,
            }
            for one in found.misfits
        ],
        "noise_m": found.fit.noise,
        "discrepancy_at_tip_m": max(one.discrepancy for one in found.misfits),
        "points_that_count_less": found.fit.n_outlier,
        "is_settled": found.fit.has_converged,
        "shapes_not_solved": found.unsolved,
    }  # fmt: skip


def list_artifacts(bench: Bench | None) -> list[str]:
    """Names of the files of a calibration, with or without joint bench records."""
    return [*_FILES, *([] if bench is None else [BENCH_PLOT])]


def write_calibration_folder(run: CalibrationRun, folder: str | Path | OutputFolder) -> dict[str, Any]:
    """Write calibrated design, figures, shapes and result; return the result with its files.

    Raises:
        OutputError: where a file cannot be written or must not be replaced.
    """
    files = list_artifacts(run.bench)
    result = compute_result(run) | {"files": files}
    with open_output(folder, WRITER, files) as output, output.draft() as draft:
        if run.bench is not None:
            write_bench_plot(run.bench, draft / BENCH_PLOT)
        design = replace(run.found.design, name=f"{run.found.design.name}, calibrated"[:200])
        write_text(draft / "trunk.toml", format_design(design, _list_provenance(result, run.found)))
        write_figure(build_calibration_figure(_build_bars(run)), draft / "calibration.png")
        write_shapes(run.recorded.shapes, draft / "shapes.json")
        write_text(draft / "result.json", format_json(result) + "\n")
    return result


def _list_provenance(result: Mapping[str, Any], found: Calibration) -> list[str]:
    """Where the numbers of a calibrated design come from, as comment lines."""
    takes = [Path(name).name for name in result["takes"]["fitted"]]
    held = result["held_out"].get("all", {}).get("calibrated_mean_rmse_m")
    slack = ", ".join(f"{1e3 * value:.2f}" for value in found.winders.slack)
    notes = [f"Calibrated by spiraltrunk {result['versions']['spiraltrunk']} from the design {result['design']!r}."]
    notes += [f"Note: {note}." for note in result["notes"]]
    notes.append(f"Fitted to {len(takes)} takes: {', '.join(takes)}"[:400] + ".")
    notes.append("Held-out mean RMSE: " + ("none was held out." if held is None else f"{1e3 * held:.2f} mm."))
    notes.append(
        f"Slack of the cables, which is no part of a design: {slack} mm. For sessions still to be recorded put it into "
        "the protocol's slack_mm, never for these takes; `validate` subtracts the slack of the protocol."
    )
    notes.append(
        f"Compliance of winder and cable, which is no part of a design: {1e3 * found.winders.compliance:.3g} mm/N."
    )
    if result["not_told"]:
        notes.append(f"Not determined by the takes, close to the prior: {', '.join(result['not_told'])}.")
    return notes


def _build_bars(run: CalibrationRun) -> CalibrationBars:
    """Data of the calibration figure."""
    found, design = run.found, run.recordings.design
    joints = found.parameters[: design.n_joint]
    is_held_out = bool(len(found.held_out.index))
    errors = found.held_out if is_held_out else found.fitted
    groups = _group_shapes(errors, run.recorded.shapes)
    suffix = ", synthetic: not a measurement" if run.recorded.synthetic else ""
    return CalibrationBars(
        before=design.joint_stiffness, value=np.array([p.value for p in joints]),
        low=np.array([p.low for p in joints]), high=np.array([p.high for p in joints]), groups=tuple(groups),
        errors=np.array([[_mean(getattr(errors, model)[own]) for model in MODELS] for own in groups.values()]),
        is_held_out=is_held_out, title=f"Calibration of {design.name}{suffix}",
    )  # fmt: skip


def _group_shapes(errors: Errors, shapes: MeasuredShapes) -> dict[str, np.ndarray]:
    """Which errors belong to which kind of shape; shapes at rest are grouped by tilt."""
    tilts = {i: f" {90 - math.degrees(shapes.theta_0[i]):.0f} deg" for i in errors.index if shapes.kind[i] == "rest"}
    names = [shapes.kind[i] + tilts.get(i, "") for i in errors.index]
    return {name: np.array([other == name for other in names]) for name in dict.fromkeys(names)}


def _average_errors(errors: Errors, shapes: MeasuredShapes) -> dict[str, Any]:
    """Mean RMSE by kind of shape, and over all shapes."""
    if not len(errors.index):
        return {}
    groups = {**_group_shapes(errors, shapes), "all": np.ones(len(errors.index), bool)}
    return {
        name: {"shapes": int(own.sum())}
        | {f"{model}_mean_rmse_m": _mean(getattr(errors, model)[own]) for model in MODELS}
        for name, own in groups.items()
    }


def _mean(values: np.ndarray) -> float:
    """Mean of the finite values, not a number without any."""
    return float(np.nanmean(values)) if np.isfinite(values).any() else math.nan


def _list_warnings(run: CalibrationRun) -> list[str]:
    found, recordings = run.found, run.recordings
    n_take = len(list_files(recordings.fitted)) + len(list_files(recordings.held_out))
    synthetic = f"not a measurement: {len(run.recorded.synthetic)} of {n_take} recordings are synthetic"
    warnings = {
        synthetic: run.recorded.synthetic,
        "a twist is fitted without a bending: the parameters absorb the model's error in a twist, so that their "
        "intervals are doubled; fit a bending, too": is_twist_alone(one.kind for one in found.misfits),
        "nothing was calibrated: these takes determine no parameter": len(list_unidentified(found))
        == len(found.parameters),
        "nothing was held out: the error on unseen shapes is not known": not recordings.held_out,
        "the fit ended before the misfit converged": not found.fit.has_converged,
        f"{found.unsolved} shapes did not converge": found.unsolved,
    }
    return [text for text, applies in warnings.items() if applies] + [
        f"{one.take} is misfitted: RMS {1e3 * one.registered_rms:.2f} mm after registration, far above the other runs; "
        "the model does not express it, and it counts less in the fit"
        for one in list_misfitted(found)
    ]
