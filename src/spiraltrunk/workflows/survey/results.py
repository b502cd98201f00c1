"""Results of a survey: its counts, tables and pictures, written to its folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from spiraltrunk.files.output_folder import OutputFolder
from spiraltrunk.report.style import write_figure
from spiraltrunk.report.survey import Outcomes, build_causes_figure, build_heatmap_figure, build_rates_figure
from spiraltrunk.workflows.survey.plan import SurveyPlan
from spiraltrunk.workflows.survey.resume_log import FILES, write_tables
from spiraltrunk.workflows.survey.row import Row
from spiraltrunk.workflows.survey.summary import summarize
from spiraltrunk.workflows.survey.tables import format_markdown


def sort_rows(plan: SurveyPlan, rows: Sequence[Row]) -> list[Row]:
    """Rows by strategy, in the plan's order, and index."""
    place = {name: i for i, name in enumerate(plan.objects)}
    return sorted(rows, key=lambda row: (place[row["strategy"]], row["index"]))


def write_pictures(result: dict[str, Any], rows: Sequence[Row], rates: Path, heatmap: Path) -> None:
    """Plot success rates with their intervals, and success by the objects' width and mass.

    Raises:
        OSError: where a file cannot be written.
    """
    write_figure(build_rates_figure(result["strategies"]), rates)
    known = {
        name: [row for row in rows if row["strategy"] == name and row["width_m"] is not None]
        for name in result["strategies"]
    }
    columns = {"width": "width_m", "mass": "mass_kg", "success": "success"}
    outcomes = [
        Outcomes(name=name, **{field: [row[key] for row in own] for field, key in columns.items()})
        for name, own in known.items()
    ]
    write_figure(build_heatmap_figure(outcomes), heatmap)


def compute_result(plan: SurveyPlan, settings: Mapping[str, Any], rows: Sequence[Row]) -> dict[str, Any]:
    """Settings, counts of each strategy and whether the survey is complete, ready for JSON."""
    return {**summarize(plan, rows), "settings": dict(settings), "files": []}


def write_result(
    output: OutputFolder, plan: SurveyPlan, settings: Mapping[str, Any], rows: Sequence[Row]
) -> dict[str, Any]:
    """Write ``survey.json`` and ``table.md``; the result without the rows.

    Raises:
        OutputError: where a file cannot be written or must not be replaced.
    """
    result = compute_result(plan, settings, rows)
    result["files"] = list(FILES if result["complete"] else FILES[:3])
    write_tables(output, result, sort_rows(plan, rows), format_markdown(result))
    return result


def write_all_pictures(output: OutputFolder, plan: SurveyPlan, result: dict[str, Any], rows: Sequence[Row]) -> None:
    """Write the plots of a complete survey.

    Raises:
        OutputError: where a file cannot be written or must not be replaced.
    """
    with output.draft(is_partial=True) as draft:
        write_pictures(result, sort_rows(plan, rows), draft / "rates.png", draft / "heatmap.png")
        write_figure(build_causes_figure(result["strategies"], result["classes"]), draft / "causes.png")
