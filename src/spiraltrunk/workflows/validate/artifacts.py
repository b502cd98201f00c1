"""Recordings held against a model: figures, pictures and a page, all of them or none."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from spiraltrunk.design.toml import write_design
from spiraltrunk.files.atomic import atomic_folder
from spiraltrunk.mocap.session.session import RunShapes
from spiraltrunk.mocap.session.shapes_json import write_shapes
from spiraltrunk.report.page import write_page
from spiraltrunk.report.shape.box_plots import build_boxes_figure
from spiraltrunk.report.shape.comparison import ShapeComparison
from spiraltrunk.report.shape.overlay import build_overlay_figure
from spiraltrunk.report.style import write_figure
from spiraltrunk.workflows.validate.comparison import Judgement, _find_made_up, _tilt, compute_result
from spiraltrunk.workflows.validate.page import _build_blocks

_TITLE = "Recordings against the model"


def write_judgement(judgement: Judgement, folder: str | Path) -> dict[str, Any]:
    """Write everything into a folder, whole or not at all, and return the result.

    Raises:
        OSError: where it cannot be written.
    """
    pictures = _plan_pictures(judgement)
    names = [
        *(name for name, _ in pictures),
        "deviations.csv",
        "report.html",
        "result.json",
        "shapes.json",
        "trunk.toml",
    ]
    result = compute_result(judgement, sorted(names))
    with atomic_folder(folder, names) as draft:
        for name, judged in pictures:
            build = build_overlay_figure if name.startswith("overlay") else build_boxes_figure
            write_figure(build(judged), draft / name)
        (draft / "deviations.csv").write_text(format_deviations(judgement))
        write_shapes(judgement.session.shapes, draft / "shapes.json")
        write_design(judgement.settings.design, draft / "trunk.toml")
        write_page(draft / "report.html", _TITLE, _build_blocks(judgement, result, pictures, draft))
        (draft / "result.json").write_text(json.dumps(result, indent=2, allow_nan=False) + "\n")
    return result


def format_deviations(judgement: Judgement) -> str:
    """Every distance as CSV: run, shape, section, distance and turn."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["run", "shape", "section", "distance_m", "turn_deg"])
    for run, deviation in zip(judgement.session.runs, judgement.deviations, strict=True):
        for shape, section in np.argwhere(np.isfinite(deviation.distance)):
            turn = deviation.turn[shape, section]
            told = f"{math.degrees(turn):.4f}" if np.isfinite(turn) else ""
            distance = f"{deviation.distance[shape, section]:.7f}"
            writer.writerow([run.plan.run.name, shape + 1, section + 1, distance, told])
    return text.getvalue()


def _plan_pictures(judgement: Judgement) -> list[tuple[str, ShapeComparison]]:
    """Names of the pictures and what is in them: rest at all tilts together, other runs by themselves."""
    pictures: list[tuple[str, ShapeComparison]] = []
    rests = [run for run in judgement.session.runs if run.plan.run.kind == "rest"]
    if rests:
        judged = _join_rests(rests, judgement.settings.model)
        pictures += [("overlay-rest.png", judged), ("boxes-rest.png", judged)]
    for run in judgement.session.runs:
        if run.plan.run.kind != "rest":
            judged = _judge_run(run, judgement.settings.model)
            pictures += [(f"overlay-{run.plan.run.name}.png", judged), (f"boxes-{run.plan.run.name}.png", judged)]
    return pictures


def _name_recordings(runs: Sequence[RunShapes]) -> str:
    return "made-up recordings" if _find_made_up(runs) else "recordings"


def _join_rests(runs: Sequence[RunShapes], model: str) -> ShapeComparison:
    return ShapeComparison(
        title=f"Rest under gravity: {_name_recordings(runs)} and the model {model}", label="Tilt from hanging [deg]",
        labels=tuple(f"{_tilt(run):g}" for run in runs), measured=np.concatenate([run.points for run in runs]),
        predicted=np.concatenate([run.predicted.points for run in runs]),
    )  # fmt: skip


def _judge_run(run: RunShapes, model: str) -> ShapeComparison:
    cable = {"bend-dorsal": "Cable 1 in by", "bend-ventral": "Cable 1 out by", "twist": "Cable 2 in by"}
    return ShapeComparison(
        title=f"{run.plan.run.name}: {_name_recordings([run])} and the model {model}",
        label=f"{cable[run.plan.run.kind]} [mm]",
        labels=tuple(f"{1e3 * amount:g}" for amount in run.plan.amount), measured=run.points,
        predicted=run.predicted.points,
    )  # fmt: skip
