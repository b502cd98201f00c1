"""A survey: trials in processes, logged as they end, summarised at the end or at an interruption."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

from spiraltrunk.checks import check_count
from spiraltrunk.files.output_folder import OutputFolder, open_output
from spiraltrunk.files.results import read_versions
from spiraltrunk.processes.pool import run_jobs
from spiraltrunk.report.style import write_figure
from spiraltrunk.report.survey import Outcomes, build_causes_figure, build_heatmap_figure, build_rates_figure
from spiraltrunk.workflows.survey.code_version import compute_source
from spiraltrunk.workflows.survey.plan import Entry, SurveyPlan
from spiraltrunk.workflows.survey.resume_log import FILES, WRITER, open_log, write_tables
from spiraltrunk.workflows.survey.row import Row, build_empty_row
from spiraltrunk.workflows.survey.run_entry import compute_row
from spiraltrunk.workflows.survey.summary import summarize
from spiraltrunk.workflows.survey.tables import format_markdown

MOST_WORKERS = 64
"""Largest number of processes."""

Watch = Callable[[Sequence[Row]], None]
"""Called with all rows so far, before the first trial and after each."""


def run_survey(
    plan: SurveyPlan,
    *,
    workers: int = 1,
    folder: str | Path | OutputFolder | None = None,
    work: Callable[[Entry], Row] | None = None,
    watch: Watch | None = None,
) -> dict[str, Any]:
    """Run all trials of a plan and count them; the result is independent of workers and interruptions.

    Args:
        plan: the trials.
        workers: processes that share them.
        folder: where to log them; trials that are logged already are not run again.
        work: function that runs a trial, importable in processes; None runs it in simulation.
        watch: called as the work goes on.

    Returns:
        Settings, counts of each strategy and whether the survey is complete, ready for JSON.

    Raises:
        DesignError: for a number of workers out of range.
        SurveyError: where the folder holds another survey.
        RunError: where processes cannot be started.
        OutputError: where the folder cannot be written, another process writes to it, or a file in it is not the
            survey's own.
        ImportError: where the trials need a package that is missing.
    """
    check_count("survey.workers", workers, least=1, most=MOST_WORKERS)
    watch = watch or (lambda rows: None)
    work = work or partial(compute_row, design=plan.design, timestep=plan.timestep)
    if folder is None:
        rows: list[Row] = []
        _run_entries(plan, rows, rows.append, workers=workers, work=work, watch=watch)
        return _compute_result(plan, rows)
    with open_output(folder, WRITER, FILES) as output, open_log(output, _compute_settings(plan)) as log:
        _write(output, plan, log.rows)
        try:
            _run_entries(plan, log.rows, log.add, workers=workers, work=work, watch=watch)
        finally:
            result = _write(output, plan, log.rows)
        with output.draft(is_partial=True) as draft:
            write_pictures(result, sort_rows(plan, log.rows), draft / "rates.png", draft / "heatmap.png")
            write_figure(build_causes_figure(result["strategies"], result["classes"]), draft / "causes.png")
    return result


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


def _run_entries(
    plan: SurveyPlan,
    rows: Sequence[Row],
    keep: Callable[[Row], None],
    *,
    workers: int,
    work: Callable[[Entry], Row],
    watch: Watch,
) -> None:
    """Run the trials without a row; ``keep`` adds new rows to ``rows``."""
    done = {(row["strategy"], row["index"]) for row in rows}
    left = [entry for entry in plan.entries() if (entry.strategy, entry.index) not in done]
    watch(rows)
    with closing(run_jobs(work, left, workers)) as outcomes:
        for outcome in outcomes:
            if isinstance(outcome.error, ImportError):
                raise outcome.error
            keep(build_empty_row(outcome.job, outcome.fault or "") if outcome.result is None else outcome.result)
            watch(rows)


def _compute_settings(plan: SurveyPlan) -> dict[str, Any]:
    versions = read_versions("mujoco", "mink", "numpy", "scipy")
    del versions["python"]  # Surveys of different Python versions are equal.
    return {**plan.settings(), "versions": versions, "source": compute_source()}


def _compute_result(plan: SurveyPlan, rows: Sequence[Row]) -> dict[str, Any]:
    return {**summarize(plan, rows), "settings": _compute_settings(plan), "files": []}


def _write(output: OutputFolder, plan: SurveyPlan, rows: Sequence[Row]) -> dict[str, Any]:
    result = _compute_result(plan, rows)
    result["files"] = list(FILES if result["complete"] else FILES[:3])
    write_tables(output, result, sort_rows(plan, rows), format_markdown(result))
    return result
