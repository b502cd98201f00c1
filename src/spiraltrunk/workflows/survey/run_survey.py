"""A survey: trials in processes, logged as they end, summarised at the end or at an interruption."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

from spiraltrunk.checks import check_count
from spiraltrunk.errors import OutputError, SurveyError
from spiraltrunk.files.output_folder import OutputFolder, open_output
from spiraltrunk.processes.pool import Engine, run_jobs
from spiraltrunk.workflows.survey.code_version import SameCode, compute_code
from spiraltrunk.workflows.survey.plan import Entry, SurveyPlan
from spiraltrunk.workflows.survey.results import compute_result, write_all_pictures, write_result
from spiraltrunk.workflows.survey.resume_log import FILES, WRITER, open_log
from spiraltrunk.workflows.survey.row import Row, build_empty_row
from spiraltrunk.workflows.survey.run_entry import compute_row

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
    engine: Engine | None = None,
    watch: Watch | None = None,
) -> dict[str, Any]:
    """Run all trials of a plan and count them; the result is independent of workers and interruptions.

    Args:
        plan: the trials.
        workers: processes that share them.
        folder: where to log them; trials that are logged already are not run again.
        work: function that runs a trial, importable in processes; None runs it in simulation.
        engine: what runs the trials in processes, such as `processes.ray_engine.RayEngine`; None is the pool of this
            machine.
        watch: called as the work goes on.

    Returns:
        Settings, counts of each strategy and whether the survey is complete, ready for JSON.

    Raises:
        DesignError: for a number of workers out of range.
        SurveyError: where the folder holds another survey, or a machine of the engine has other code.
        RunError: where processes cannot be started.
        OutputError: where the folder cannot be written, another process writes to it, or a file in it is not the
            survey's own.
        ImportError: where the trials need a package that is missing.
    """
    check_count("survey.workers", workers, least=1, most=MOST_WORKERS)
    watch = watch or (lambda rows: None)
    work = work or partial(compute_row, design=plan.design, timestep=plan.timestep)
    settings = compute_settings(plan)
    if engine is not None:
        work = SameCode(work=work, code=compute_code())
    run = partial(_run_entries, plan, engine=engine or run_jobs, workers=workers, work=work, watch=watch)
    if folder is None:
        rows: list[Row] = []
        run(rows, rows.append)
        return compute_result(plan, settings, rows)
    with open_output(folder, WRITER, FILES) as output, open_log(output, settings) as log:
        write_result(output, plan, settings, log.rows)
        try:
            run(log.rows, log.add)
        finally:
            result = write_result(output, plan, settings, log.rows)
        write_all_pictures(output, plan, result, log.rows)
    return result


def _run_entries(
    plan: SurveyPlan,
    rows: Sequence[Row],
    keep: Callable[[Row], None],
    *,
    engine: Engine,
    workers: int,
    work: Callable[[Entry], Row],
    watch: Watch,
) -> None:
    """Run the trials without a row; ``keep`` adds new rows to ``rows``."""
    done = {(row["strategy"], row["index"]) for row in rows}
    left = [entry for entry in plan.entries() if (entry.strategy, entry.index) not in done]
    watch(rows)
    with closing(engine(work, left, workers)) as outcomes:
        for outcome in outcomes:
            if isinstance(outcome.error, (ImportError, OutputError, SurveyError)):
                raise outcome.error
            keep(build_empty_row(outcome.job, outcome.fault or "") if outcome.result is None else outcome.result)
            watch(rows)


def compute_settings(plan: SurveyPlan) -> dict[str, Any]:
    """Settings of a survey that is run now, with versions and code; ready for JSON."""
    return {**plan.settings(), **compute_code()}
