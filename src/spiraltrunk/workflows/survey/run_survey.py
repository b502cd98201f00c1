"""A whole survey: trials in processes, kept as they end, counted at the end or where it is cut off."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from importlib.metadata import version
from pathlib import Path
from typing import Any

import spiraltrunk
from spiraltrunk.report.style import write_figure
from spiraltrunk.report.survey.heatmap import Outcomes, build_heatmap_figure
from spiraltrunk.report.survey.rates import build_rates_figure
from spiraltrunk.workflows.survey.code_version import compute_source
from spiraltrunk.workflows.survey.plan import Entry, Plan
from spiraltrunk.workflows.survey.process_pool import run_jobs
from spiraltrunk.workflows.survey.resume_log import FILES, Log, open_log, write_tables
from spiraltrunk.workflows.survey.row import Row, build_empty_row
from spiraltrunk.workflows.survey.run_entry import compute_row
from spiraltrunk.workflows.survey.summary import summarize
from spiraltrunk.workflows.survey.tables import format_markdown

Watch = Callable[[Sequence[Row]], None]
"""Called with all rows so far, before the first trial and after each."""


def run_survey(
    plan: Plan,
    *,
    workers: int = 1,
    folder: Path | None = None,
    work: Callable[[Entry], Row] = compute_row,
    watch: Watch | None = None,
) -> dict[str, Any]:
    """Run all trials of a plan and count them; the result does not depend on workers or on having been cut off.

    Args:
        plan: which trials.
        workers: processes that share them.
        folder: where to keep them; trials that are there already are not run again.
        work: what runs a trial, a function that processes can import.
        watch: called as the work goes on.

    Returns:
        Settings, counts of each strategy and whether the survey is complete, ready for JSON.

    Raises:
        SurveyError: where the folder holds another survey.
        RunError: where processes cannot be started.
        OSError: where the folder cannot be written.
    """
    watch = watch or _tell_nobody
    if folder is None:
        rows: list[Row] = []
        _run_entries(plan, rows, rows.append, workers=workers, work=work, watch=watch)
        return _compute_result(plan, rows)
    with open_log(folder, _compute_settings(plan)) as log:
        _write(folder, plan, log)
        try:
            _run_entries(plan, log.rows, log.add, workers=workers, work=work, watch=watch)
        finally:
            result = _write(folder, plan, log)
        write_pictures(result, sort_rows(plan, log.rows), folder / "rates.png", folder / "heatmap.png")
    return result


def sort_rows(plan: Plan, rows: Sequence[Row]) -> list[Row]:
    """Rows by strategy, as the plan has them, and index."""
    place = {name: i for i, name in enumerate(plan.objects)}
    return sorted(rows, key=lambda row: (place[row["strategy"]], row["index"]))


def write_pictures(result: dict[str, Any], rows: Sequence[Row], rates: Path, heatmap: Path) -> None:
    """Write a survey's rates with their intervals, and its success by the objects' size and mass.

    Raises:
        OSError: where a file cannot be written.
    """
    write_figure(build_rates_figure(result["strategies"]), rates)
    outcomes = [
        Outcomes(
            name=name,
            width=[row["width_m"] for row in own],
            mass=[row["mass_kg"] for row in own],
            success=[row["success"] for row in own],
        )
        for name in result["strategies"]
        for own in [[row for row in rows if row["strategy"] == name and row["width_m"] is not None]]
    ]
    write_figure(build_heatmap_figure(outcomes), heatmap)


def _run_entries(
    plan: Plan,
    rows: Sequence[Row],
    keep: Callable[[Row], None],
    *,
    workers: int,
    work: Callable[[Entry], Row],
    watch: Watch,
) -> None:
    """Run what has no row yet; ``keep`` puts new rows with the others."""
    done = {(row["strategy"], row["index"]) for row in rows}
    left = [entry for entry in plan.entries() if (entry.strategy, entry.index) not in done]
    watch(rows)
    with closing(run_jobs(work, left, workers)) as outcomes:
        for outcome in outcomes:
            keep(build_empty_row(outcome.job, outcome.fault or "") if outcome.result is None else outcome.result)
            watch(rows)


def _compute_settings(plan: Plan) -> dict[str, Any]:
    versions = {name: version(name) for name in ("mujoco", "mink", "numpy", "scipy")}
    versions |= {"spiraltrunk": spiraltrunk.__version__}
    return {**plan.settings(), "versions": versions, "source": compute_source()}


def _compute_result(plan: Plan, rows: Sequence[Row], files: Sequence[str] = ()) -> dict[str, Any]:
    return {**summarize(plan, rows), "settings": _compute_settings(plan), "files": list(files)}


def _write(folder: Path, plan: Plan, log: Log) -> dict[str, Any]:
    result = _compute_result(plan, log.rows)
    result["files"] = list(FILES if result["complete"] else FILES[:3])
    write_tables(folder, result, sort_rows(plan, log.rows), format_markdown(result))
    return result


def _tell_nobody(rows: Sequence[Row]) -> None:
    """Say nothing."""
