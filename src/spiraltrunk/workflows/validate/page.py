"""The page of a validation: tables and pictures in one HTML file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from spiraltrunk.mocap.signal.deviation import PAPER
from spiraltrunk.report.page import Block, Grid, Heading, Picture, Words
from spiraltrunk.report.shape.comparison import ShapeComparison
from spiraltrunk.workflows.validate.comparison import Judgement


def _build_blocks(
    judgement: Judgement, result: dict[str, Any], pictures: Sequence[tuple[str, ShapeComparison]], folder: Path
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
