"""Recordings held against a model: figures, pictures and a page, all of them or none."""

from __future__ import annotations

import csv
import io
import json
import math
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, final

import numpy as np

import spiraltrunk
from spiraltrunk.design.toml import write_design
from spiraltrunk.errors import TakeError
from spiraltrunk.files.atomic import write_folder
from spiraltrunk.mocap.protocol.protocol import Protocol
from spiraltrunk.mocap.session.session import RunShapes, Session, SessionSettings, Tell, build_session, register
from spiraltrunk.mocap.session.shapes_json import write_shapes
from spiraltrunk.mocap.signal.deviation import PAPER, Deviation, compute_deviation
from spiraltrunk.mocap.signal.registration import KINDS as ALIGNMENTS
from spiraltrunk.mocap.signal.registration import Alignment
from spiraltrunk.report.page import Block, Grid, Heading, Picture, Words, write_page
from spiraltrunk.report.shape.box_plots import write_boxes
from spiraltrunk.report.shape.comparison import Judged
from spiraltrunk.report.shape.overlay import write_overlay

_TITLE = "Recordings against the model"
_MADE_UP = ("rehearsal", "virtual", "simulat")
"""Words in a take's name by which it says that no trunk was recorded."""


@final
@dataclass(frozen=True, kw_only=True)
class Judgement:
    """What recordings say of a model."""

    protocol: Protocol
    """What was done."""
    settings: SessionSettings
    """How recordings were read, and the model."""
    session: Session
    """Their shapes."""
    deviations: tuple[Deviation, ...]
    """Distances from the model, run by run."""


def judge(
    protocol: Protocol, takes: dict[str, list[str]], settings: SessionSettings, tell: Tell | None = None
) -> Judgement:
    """Read recordings and hold them against the model.

    Args:
        protocol: what was done.
        takes: files by the name of their run.
        settings: trunk, axes, model and registration.
        tell: called as the work goes on.

    Raises:
        TakeError: for recordings that cannot be read or do not hold what the protocol says.
        ModelError: for a model that does not know the trunk.
    """
    session = build_session(protocol, takes, settings, tell)
    return Judgement(
        protocol=protocol, settings=settings, session=session, deviations=tuple(map(_deviate, session.runs))
    )


def _deviate(run: RunShapes) -> Deviation:
    return compute_deviation(run.points, run.predicted.points, run.rotation, run.predicted.rotation)


def compute_result(judgement: Judgement, files: Sequence[str] = ()) -> dict[str, Any]:
    """Everything in plain values, ready for JSON."""
    settings, runs = judgement.settings, judgement.session.runs
    pairs = list(zip(runs, judgement.deviations, strict=True))
    return {
        "model": settings.model,
        "friction": _tell_friction(settings),
        "design": settings.design.name,
        "protocol": judgement.protocol.name,
        "axes": settings.axes or judgement.protocol.axes,
        "alignment": str(judgement.session.alignment),
        "is_made_up": bool(_find_made_up(runs)),
        "runs": {run.plan.run.name: _tell_run(run, deviation) for run, deviation in pairs},
        "mean_rmse_by_alignment_m": {
            str(alignment): _compare_alignment(judgement, alignment) for alignment in _list_alignments(judgement)
        },
        "paper": PAPER,
        "notes": [*_warn(runs), *(note for run in runs for note in run.notes)],
        "versions": {
            "spiraltrunk": spiraltrunk.__version__, "python": platform.python_version(), "numpy": version("numpy")
        },
        "files": list(files),
    }  # fmt: skip


def _find_made_up(runs: Sequence[RunShapes]) -> list[str]:
    """Recordings that say of themselves that no trunk was recorded."""
    takes = [take.take for run in runs for take in run.takes]
    return [take.source for take in takes if any(word in take.name.lower() for word in _MADE_UP)]


def _warn(runs: Sequence[RunShapes]) -> list[str]:
    """Say of recordings that were made up that they measure nothing."""
    made = _find_made_up(runs)
    return [f"not a measurement: {len(made)} recordings are made up, such as {made[0]}"] if made else []


def _tell_friction(settings: SessionSettings) -> float | None:
    if settings.model == "reference":
        return None
    return settings.design.cable.friction if settings.friction is None else settings.friction


def _tell_run(run: RunShapes, deviation: Deviation) -> dict[str, Any]:
    sections = deviation.sections
    return {
        "kind": run.plan.run.kind,
        "tilt_deg": _tilt(run),
        "shapes": len(run.points),
        "sections": sections,
        "rmse_per_shape_m": deviation.per_shape.tolist(),
        "rmse_per_section_m": deviation.per_section[np.array(sections) - 1].tolist(),
        "mean_rmse_m": deviation.mean_rmse,
        "max_rmse_m": deviation.max_rmse,
        "max_deviation_m": deviation.max_deviation,
        "mean_turn_deg": _number(math.degrees(deviation.mean_turn)),
        "spread_of_takes_m": _number(run.spread),
        "takes": [
            {
                "file": take.take.source,
                "name": take.take.name,
                "recorded": take.take.started,
                "times_s": [[held.still.begin, held.still.end] for held in take.held],
            }
            for take in run.takes
        ],
    }


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _tilt(run: RunShapes) -> float:
    return round(90.0 - math.degrees(run.plan.run.theta_0), 9) + 0.0


def _list_alignments(judgement: Judgement) -> list[Alignment]:
    """The plain ones, and the chosen one where it is on chosen sections."""
    plain, chosen = [Alignment(kind=kind) for kind in ALIGNMENTS], judgement.session.alignment
    return plain if chosen in plain else [*plain, chosen]


def _compare_alignment(judgement: Judgement, alignment: Alignment) -> dict[str, float | None]:
    """Mean RMSE of each run, had it been aligned so; None where that cannot be."""
    found: dict[str, float | None] = {}
    for run in judgement.session.runs:
        try:
            points, _ = register(run.plan, run.predicted, run.takes, alignment, [])
        except TakeError:
            found[run.plan.run.name] = None
            continue
        seen = np.isfinite(points).all(axis=-1)
        count = seen.sum(axis=0)
        mean = np.where(seen[..., None], points, 0.0).sum(axis=0) / np.where(count > 0, count, np.nan)[..., None]
        found[run.plan.run.name] = compute_deviation(mean, run.predicted.points).mean_rmse
    return found


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
    with write_folder(folder, names) as draft:
        for name, judged in pictures:
            (write_overlay if name.startswith("overlay") else write_boxes)(judged, draft / name)
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


def _plan_pictures(judgement: Judgement) -> list[tuple[str, Judged]]:
    """Names of the pictures and what is in them: rest at all tilts together, other runs by themselves."""
    pictures: list[tuple[str, Judged]] = []
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


def _join_rests(runs: Sequence[RunShapes], model: str) -> Judged:
    return Judged(
        title=f"Rest under gravity: {_name_recordings(runs)} and the model {model}", label="Tilt from hanging [deg]",
        labels=tuple(f"{_tilt(run):g}" for run in runs), measured=np.concatenate([run.points for run in runs]),
        predicted=np.concatenate([run.predicted.points for run in runs]),
    )  # fmt: skip


def _judge_run(run: RunShapes, model: str) -> Judged:
    cable = {"bend-dorsal": "Cable 1 in by", "bend-ventral": "Cable 1 out by", "twist": "Cable 2 in by"}
    return Judged(
        title=f"{run.plan.run.name}: {_name_recordings([run])} and the model {model}",
        label=f"{cable[run.plan.run.kind]} [mm]",
        labels=tuple(f"{1e3 * amount:g}" for amount in run.plan.amount), measured=run.points,
        predicted=run.predicted.points,
    )  # fmt: skip


def _build_blocks(
    judgement: Judgement, result: dict[str, Any], pictures: Sequence[tuple[str, Judged]], folder: Path
) -> list[Block]:
    """What the page says."""
    settings = judgement.settings
    friction = "" if result["friction"] is None else f" with friction {result['friction']:g}"
    intro = (
        f"Trunk {settings.design.name}, protocol {result['protocol']}, model {settings.model}{friction}. Alignment: "
        f"{result['alignment']}. RMSE of a shape is the root mean square, over the sections that were seen, of the "
        "distance between the measured point of a section and the model's; the mean RMSE of a run is the mean over its "
        "shapes."
    )
    warned = tuple(note for note in result["notes"] if note.startswith("not a measurement"))
    blocks: list[Block] = [Words(texts=(*warned, intro)), Heading(text="RMSE by run")]
    blocks += [_grid_runs(result), _grid_paper(result)]
    blocks += [Heading(text="What the alignment does"), _grid_alignments(result)]
    for name, judged in pictures:
        if name.startswith("overlay"):
            blocks.append(Heading(text=judged.title))
        blocks.append(Picture(path=folder / name, text=f"{judged.title}, {name.partition('-')[0]}"))
    if len(result["notes"]) > len(warned):
        blocks += [Heading(text="Notes"), Words(texts=tuple(result["notes"][len(warned) :]), is_list=True)]
    return blocks


def _grid_runs(result: dict[str, Any]) -> Grid:
    rows = []
    for name, run in result["runs"].items():
        figures = [run["mean_rmse_m"], run["max_rmse_m"], run["max_deviation_m"], run["spread_of_takes_m"]]
        takes = str(len(run["takes"]))
        rows.append((name, str(run["shapes"]), takes, str(len(run["sections"])), *map(_mm, figures)))
    header = (
        "run",
        "shapes",
        "takes",
        "sections",
        "mean RMSE [mm]",
        "max RMSE [mm]",
        "largest [mm]",
        "takes differ [mm]",
    )
    return Grid(
        header=header, rows=tuple(rows),
        caption="largest: the largest distance of one section; takes differ: how far takes are from their mean",
    )  # fmt: skip


def _grid_paper(result: dict[str, Any]) -> Grid:
    ours = "made-up recordings [mm]" if result["is_made_up"] else "recordings [mm]"
    return Grid(
        header=("figure", ours, "the paper [mm]"), rows=tuple(pair_with_paper(result)),
        caption=f"The paper's column is {PAPER['what']} ({PAPER['source']}); it says nothing about this robot",
    )  # fmt: skip


def pair_with_paper(result: dict[str, Any]) -> list[tuple[str, str, str]]:
    """The paper's figures in mm, each beside that of the recordings of the same kind, where there is one."""
    runs = list(result["runs"].values())
    bends = [run for run in runs if run["kind"] == "bend-dorsal" and run["tilt_deg"] == 0]
    paper = PAPER["bend_dorsal"]
    ours = (_mm(bends[0]["mean_rmse_m"]), _mm(bends[0]["max_deviation_m"])) if bends else ("-", "-")
    rows = [
        ("bending, hanging: mean RMSE", ours[0], _mm(paper["mean_rmse_m"])),
        ("bending, hanging: largest deviation", ours[1], _mm(paper["max_deviation_m"])),
    ]
    for tilt, figure in PAPER["rest"].items():
        found = [run for run in runs if run["kind"] == "rest" and run["tilt_deg"] == float(tilt)]
        rows.append(
            (f"rest, tilt {tilt} deg: RMSE", _mm(found[0]["mean_rmse_m"]) if found else "-", _mm(figure["rmse_m"]))
        )
    return rows


def _grid_alignments(result: dict[str, Any]) -> Grid:
    by_kind = result["mean_rmse_by_alignment_m"]
    rows = [(name, *(_mm(of_runs[name]) for of_runs in by_kind.values())) for name in result["runs"]]
    return Grid(
        header=("mean RMSE [mm]", *(f"alignment {kind}" for kind in by_kind)), rows=tuple(rows),
        caption="base: by the rigid body at the base; run: one motion a take; shape: one for each shape",
    )  # fmt: skip


def _mm(value: float | None) -> str:
    return "-" if value is None else f"{1e3 * value:.2f}"
