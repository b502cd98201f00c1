"""The page of a validation: tables and plots in one HTML file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from spiraltrunk.mocap.signal.deviation import PAPER
from spiraltrunk.report.page import build_heading, build_list, build_paragraphs, build_picture, build_table


def build_page(result: dict[str, Any], plots: Mapping[Path, str]) -> list[str]:
    """Blocks of the page: the figures of a result, and its plots with their titles."""
    friction = "" if result["friction"] is None else f" with friction {result['friction']:g}"
    intro = (
        f"Trunk {result['design']}, protocol {result['protocol']}, model {result['model']}{friction}. Alignment: "
        f"{result['alignment']}. RMSE of a shape is the root mean square, over the sections that were seen, of the "
        "distance between the measured point of a section and the model's; the mean RMSE of a run is the mean over its "
        "shapes."
    )
    warnings = tuple(note for note in result["notes"] if note.startswith("not a measurement"))
    blocks = [build_paragraphs([*warnings, intro]), build_heading("RMSE by run")]
    blocks += [_build_runs(result), _build_paper(result)]
    blocks += [build_heading("Effect of the alignment"), _build_alignments(result)]
    for path, title in plots.items():
        kind = path.name.partition("-")[0]
        blocks += [build_heading(title)] if kind == "overlay" else []
        blocks.append(build_picture(path, f"{title}, {kind}"))
    if len(result["notes"]) > len(warnings):
        blocks += [build_heading("Notes"), build_list(result["notes"][len(warnings) :])]
    return blocks


def format_run(run: Mapping[str, Any]) -> tuple[str, ...]:
    """Counts of a run's shapes, takes and sections, then mean RMSE, largest RMSE, largest distance and spread [mm]."""
    counts = (run["shapes"], len(run["takes"]), len(run["sections"]))
    keys = ("mean_rmse_m", "max_rmse_m", "max_deviation_m", "spread_of_takes_m")
    return (*map(str, counts), *(_mm(run[key]) for key in keys))


def _build_runs(result: dict[str, Any]) -> str:
    names = ("mean RMSE [mm]", "max RMSE [mm]", "largest [mm]", "takes differ [mm]")
    return build_table(
        header=("run", "shapes", "takes", "sections", *names),
        rows=tuple((name, *format_run(run)) for name, run in result["runs"].items()),
        caption="largest: the largest distance of one section; takes differ: RMS distance of the takes from their mean",
    )  # fmt: skip


def _build_paper(result: dict[str, Any]) -> str:
    ours = "synthetic recordings [mm]" if result["is_made_up"] else "recordings [mm]"
    return build_table(
        header=("figure", ours, "the paper [mm]"), rows=tuple(pair_with_paper(result)),
        caption=f"The paper's column is {PAPER['what']} ({PAPER['source']}); it says nothing about this robot",
    )  # fmt: skip


def pair_with_paper(result: dict[str, Any]) -> list[tuple[str, str, str]]:
    """The paper's figures, each beside the same figure of the recordings, if there is one [mm]."""
    runs = {(run["kind"], run["tilt_deg"]): run for run in reversed(result["runs"].values())}
    bend, paper = runs.get(("bend-dorsal", 0), {}), PAPER["bend_dorsal"]
    rows = [
        ("bending, hanging: mean RMSE", _mm(bend.get("mean_rmse_m")), _mm(paper["mean_rmse_m"])),
        ("bending, hanging: largest deviation", _mm(bend.get("max_deviation_m")), _mm(paper["max_deviation_m"])),
    ]
    for tilt, figure in PAPER["rest"].items():
        ours = _mm(runs.get(("rest", float(tilt)), {}).get("mean_rmse_m"))
        rows.append((f"rest, tilt {tilt} deg: RMSE", ours, _mm(figure["rmse_m"])))
    return rows


def _build_alignments(result: dict[str, Any]) -> str:
    by_kind = result["mean_rmse_by_alignment_m"]
    return build_table(
        header=("mean RMSE [mm]", *(f"alignment {kind}" for kind in by_kind)),
        rows=tuple((name, *(_mm(of_runs[name]) for of_runs in by_kind.values())) for name in result["runs"]),
        caption="base: by the rigid body at the base; run: one motion a take; shape: one for each shape",
    )  # fmt: skip


def _mm(value: float | None) -> str:
    return "-" if value is None else f"{1e3 * value:.2f}"
