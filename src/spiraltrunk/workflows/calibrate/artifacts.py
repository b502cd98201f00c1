"""What a calibration leaves behind: result, fitted design, plots and provenance, all or none."""

from __future__ import annotations

import json
import math
import platform
from collections.abc import Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

import spiraltrunk
from spiraltrunk.calibration.calibrate import Calibration, Errors, Settings
from spiraltrunk.calibration.identifiability import advise, find_tied, find_untold
from spiraltrunk.design.toml import write_design
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.files.atomic import atomic_folder
from spiraltrunk.mocap.session.shapes_json import write_shapes
from spiraltrunk.model.kinematics.measured_shapes import MeasuredShapes
from spiraltrunk.report.calibration_plot import CalibrationBars, build_calibration_figure
from spiraltrunk.report.style import write_figure
from spiraltrunk.workflows.calibrate.joint_bench import Bench, tell_bench, write_bench_plot
from spiraltrunk.workflows.calibrate.recordings import _MODELS, Recordings, _is_virtual, _list, _mean

FILES = ("trunk.toml", "calibration.png", "shapes.json", "result.json")
"""What a calibration leaves behind."""


BENCH_FILE = "bench.png"
"""What it leaves behind besides, where there were bench records."""


def compute_result(
    recordings: Recordings,
    known: tuple[Settings, Bench | None],
    found: Calibration,
    shapes: MeasuredShapes,
    odd: Sequence[str] = (),
) -> dict[str, Any]:
    """Everything in plain values, ready for JSON; SI but where a key wears its unit."""
    settings, bench = known
    untold = [parameter.name for parameter in find_untold(found)]
    return {
        "design": recordings.design.name,
        "protocol": recordings.protocol.name,
        "parameters": {
            p.name: {
                "unit": p.unit, "before": p.before, "value": p.value, "low_95": p.low, "high_95": p.high,
                "width_over_prior": p.width_ratio, "is_told": p.is_told,
            }
            for p in found.parameters
        },
        "not_told": untold,
        "told_together": [{"names": [a, b], "correlation": c} for a, b, c in find_tied(found)],
        "to_record": list(advise(found, was_weighed=settings.weighing is not None or bool(settings.bench))),
        "fitted": _tell_errors(found.fitted, shapes),
        "held_out": _tell_errors(found.held_out, shapes),
        "bench": None if bench is None else tell_bench(bench),
        "noise_m": found.fit.scatter.noise,
        "discrepancy_at_tip_m": found.fit.scatter.discrepancy,
        "points_that_count_less": found.fit.far,
        "is_settled": found.fit.is_settled,
        "shapes_not_solved": found.unsolved,
        "takes": {"fitted": _list(recordings.fitted), "held_out": _list(recordings.held_out)},
        "paper": {"reference_mean_rmse_m": 0.01041, "what": "the authors' model against their robot, bending"},
        "notes": _notes(recordings, found),
        "odd_in_recordings": list(odd),
        "versions": {
            "spiraltrunk": spiraltrunk.__version__, "python": platform.python_version(), "numpy": version("numpy"),
        },
        "files": [],
    }  # fmt: skip


def write_calibration_folder(
    recordings: Recordings,
    result: dict[str, Any],
    found: tuple[Calibration, MeasuredShapes, Bench | None],
    folder: str | Path,
) -> dict[str, Any]:
    """Write the new design with where it comes from, pictures, shapes and figures; the result with its files.

    Raises:
        OSError: where the folder cannot be written.
    """
    calibration, shapes, bench = found
    told = {**result, "files": [*FILES, *([] if bench is None else [BENCH_FILE])]}
    with atomic_folder(folder, (*FILES, BENCH_FILE)) as draft:
        if bench is not None:
            write_bench_plot(bench, draft / BENCH_FILE)
        named = replace(calibration.design, name=f"{calibration.design.name}, calibrated"[:200])
        write_design(named, draft / "trunk.toml", provenance(result, calibration))
        bars = _title_bars(recordings, calibration, shapes)
        write_figure(build_calibration_figure(bars), draft / "calibration.png")
        write_shapes(shapes, draft / "shapes.json")
        (draft / "result.json").write_text(json.dumps(told, indent=2, allow_nan=False) + "\n")
    return told


def provenance(result: dict[str, Any], found: Calibration) -> list[str]:
    """Where the numbers of a calibrated design come from, as lines of comment."""
    takes = [Path(name).name for name in result["takes"]["fitted"]]
    held = result["held_out"].get("all", {}).get("calibrated_mean_rmse_m")
    slack = ", ".join(f"{1e3 * value:.2f}" for value in found.slack)
    notes = [f"Calibrated by spiraltrunk {result['versions']['spiraltrunk']} from the design {result['design']!r}."]
    notes += [f"Note: {note}." for note in result["notes"]]
    notes.append(f"Fitted to {len(takes)} takes: {', '.join(takes)}"[:400] + ".")
    notes.append("Held-out mean RMSE: " + ("none was held out." if held is None else f"{1e3 * held:.2f} mm."))
    notes.append(
        f"Slack of the cables, which is no part of a design: {slack} mm. For sessions still to be recorded put it into "
        "the protocol's slack_mm, never for these takes; `validate` takes slack as made up for."
    )
    notes.append(f"Give of winder and cable, which is no part of a design: {1e3 * found.give:.3g} mm/N.")
    if result["not_told"]:
        notes.append(f"Not told by the takes, and near what was known beforehand: {', '.join(result['not_told'])}.")
    return notes


def build_bars(design: TrunkDesign, found: Calibration, shapes: MeasuredShapes) -> CalibrationBars:
    """What the picture of a calibration shows."""
    joints = found.parameters[: design.n_joint]
    errors = found.held_out if len(found.held_out.index) else found.fitted
    groups = _group(errors, shapes)
    rows = [[_mean(getattr(errors, model)[own]) for model in _MODELS] for own in groups.values()]
    return CalibrationBars(
        before=design.joint_stiffness, value=np.array([p.value for p in joints]),
        low=np.array([p.low for p in joints]), high=np.array([p.high for p in joints]),
        groups=tuple(groups), errors=np.array([[math.nan if v is None else v for v in row] for row in rows]),
        is_held_out=bool(len(found.held_out.index)),
    )  # fmt: skip


def _title_bars(recordings: Recordings, found: Calibration, shapes: MeasuredShapes) -> CalibrationBars:
    made = any(_is_virtual(file) for file in (*_list(recordings.fitted), *_list(recordings.held_out)))
    words = f"Calibration of {recordings.design.name}" + (", virtual capture: not a measurement" if made else "")
    return replace(build_bars(recordings.design, found, shapes), title=words)


def _group(errors: Errors, shapes: MeasuredShapes) -> dict[str, np.ndarray]:
    """Which errors belong to which kind of shape, at rest by tilt."""
    names = [
        f"{shapes.kind[i]} {90 - math.degrees(shapes.theta_0[i]):.0f} deg"
        if shapes.kind[i] == "rest"
        else shapes.kind[i]
        for i in errors.index
    ]
    return {name: np.array([other == name for other in names]) for name in dict.fromkeys(names)}


def _tell_errors(errors: Errors, shapes: MeasuredShapes) -> dict[str, Any]:
    """Means of the shapes' RMSE by kind, and over all."""
    if not len(errors.index):
        return {}
    groups = {**_group(errors, shapes), "all": np.ones(len(errors.index), bool)}
    return {
        name: {"shapes": int(own.sum())}
        | {f"{model}_mean_rmse_m": _mean(getattr(errors, model)[own]) for model in _MODELS}
        for name, own in groups.items()
    }


def _notes(recordings: Recordings, found: Calibration) -> list[str]:
    notes = []
    files = [*_list(recordings.fitted), *_list(recordings.held_out)]
    made = [file for file in files if _is_virtual(file)]
    if made:
        notes.append(f"not a measurement: {len(made)} of {len(files)} recordings are made up")
    if len(find_untold(found)) == len(found.parameters):
        notes.append("nothing was calibrated: these takes tell no parameter")
    if not recordings.held_out:
        notes.append("nothing was held out: the error on unseen shapes is not known")
    if not found.fit.is_settled:
        notes.append("the search ended before the misfit had ceased to fall")
    if found.unsolved:
        notes.append(f"{found.unsolved} shapes did not converge")
    return notes
