"""Artifacts of a validation: figures, plots, shapes and a page, written all or none."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from spiraltrunk.design.toml import format_design
from spiraltrunk.files.atomic import write_text
from spiraltrunk.files.output_folder import OutputFolder, open_output
from spiraltrunk.files.results import format_json
from spiraltrunk.mocap.protocol.protocol import Run
from spiraltrunk.mocap.session.session import RunShapes
from spiraltrunk.mocap.session.shapes_json import write_shapes
from spiraltrunk.report.page import write_page
from spiraltrunk.report.shape.comparison import ShapeComparison, build_boxes_figure, build_overlay_figure
from spiraltrunk.report.style import write_figure
from spiraltrunk.workflows.validate.comparison import Comparison, compute_result, compute_tilt_deg
from spiraltrunk.workflows.validate.page import build_page

WRITER = "validate"
"""Name of the command in output folders."""

_DATA = ("deviations.csv", "report.html", "result.json", "shapes.json", "trunk.toml")

_PLOTS = ("overlay", "boxes")
"""Kinds of plots."""

_STEP_LABELS = {"bend-dorsal": "Cable 1 in by", "bend-ventral": "Cable 1 out by", "twist": "Cable 2 in by"}


def list_files(runs: Sequence[Run]) -> list[str]:
    """Names of all artifacts of a comparison of these runs."""
    return sorted([*(f"{kind}-{name}.png" for name in _name_plots(runs) for kind in _PLOTS), *_DATA])


def _name_plots(runs: Sequence[Run]) -> list[str]:
    """Names of the pairs of plots: one for rest at all tilts, one for each other run."""
    return list(dict.fromkeys("rest" if run.kind == "rest" else run.name for run in runs))


def write_comparison(comparison: Comparison, folder: str | Path | OutputFolder) -> dict[str, Any]:
    """Write all artifacts into a folder, all or none, and return the result.

    Raises:
        OutputError: where a file cannot be written or must not be replaced.
    """
    plots = _list_plots(comparison)
    names = sorted([*plots, *_DATA])
    result = compute_result(comparison, names)
    with open_output(folder, WRITER, names) as output, output.draft() as draft:
        for name, data in plots.items():
            build = build_overlay_figure if name.startswith("overlay") else build_boxes_figure
            write_figure(build(data), draft / name)
        write_text(draft / "deviations.csv", _format_deviations(comparison))
        write_shapes(comparison.session.shapes, draft / "shapes.json")
        write_text(draft / "trunk.toml", format_design(comparison.settings.design))
        titles = {draft / name: data.title for name, data in plots.items()}
        write_page(draft / "report.html", "Recordings against the model", build_page(result, titles))
        write_text(draft / "result.json", format_json(result) + "\n")
    return result


def _format_deviations(comparison: Comparison) -> str:
    """All distances as CSV: run, shape, section, distance and turn."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["run", "shape", "section", "distance_m", "turn_deg"])
    for run, deviation in zip(comparison.session.runs, comparison.deviations, strict=True):
        for shape, section in np.argwhere(np.isfinite(deviation.distance)):
            turn, distance = deviation.turn[shape, section], f"{deviation.distance[shape, section]:.7f}"
            turn_deg = f"{math.degrees(turn):.4f}" if np.isfinite(turn) else ""
            writer.writerow([run.schedule.run.name, shape + 1, section + 1, distance, turn_deg])
    return text.getvalue()


def _list_plots(comparison: Comparison) -> dict[str, ShapeComparison]:
    """Data of the plots by file name: one pair of plots for rest at all tilts, one for each other run."""
    runs, model = comparison.session.runs, comparison.settings.model
    rests = [run for run in runs if run.schedule.run.kind == "rest"]
    data = {"rest": _join_rests(rests, model)} if rests else {}
    data |= {run.schedule.run.name: _build_run_data(run, model) for run in runs if run.schedule.run.kind != "rest"}
    return {f"{kind}-{name}.png": each for name, each in data.items() for kind in _PLOTS}


def _name_recordings(runs: Sequence[RunShapes]) -> str:
    is_synthetic = any(take.take.is_synthetic for run in runs for take in run.takes)
    return "synthetic recordings" if is_synthetic else "recordings"


def _join_rests(runs: Sequence[RunShapes], model: str) -> ShapeComparison:
    return ShapeComparison(
        title=f"Rest under gravity: {_name_recordings(runs)} and the model {model}", label="Tilt from hanging [deg]",
        labels=tuple(f"{compute_tilt_deg(run):g}" for run in runs), measured=np.concatenate([r.points for r in runs]),
        predicted=np.concatenate([run.predicted.points for run in runs]),
    )  # fmt: skip


def _build_run_data(run: RunShapes, model: str) -> ShapeComparison:
    return ShapeComparison(
        title=f"{run.schedule.run.name}: {_name_recordings([run])} and the model {model}",
        label=f"{_STEP_LABELS[run.schedule.run.kind]} [mm]",
        labels=tuple(f"{1e3 * amount:g}" for amount in run.schedule.amount), measured=run.points,
        predicted=run.predicted.points,
    )  # fmt: skip
