"""Demonstrations: a survey whose trials are recorded, and the data set of their episodes."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, final

from spiraltrunk.checks import check_count
from spiraltrunk.design.toml import format_design
from spiraltrunk.errors import OutputError, SurveyError
from spiraltrunk.files.atomic import write_text
from spiraltrunk.files.output_folder import STATE, OutputFolder, open_output
from spiraltrunk.files.results import Progress, format_json, ignore_progress
from spiraltrunk.processes.pool import Engine, run_jobs
from spiraltrunk.workflows.demos.dataset.formats import Format, get_format
from spiraltrunk.workflows.demos.dataset.layout import Episodes, Layout
from spiraltrunk.workflows.demos.options import RecordingOptions
from spiraltrunk.workflows.demos.recording.episode_file import FOLDER, load_episode, name_episode
from spiraltrunk.workflows.demos.recording.run_entry import is_kept, record_entry
from spiraltrunk.workflows.survey.plan import Entry, SurveyPlan
from spiraltrunk.workflows.survey.results import sort_rows
from spiraltrunk.workflows.survey.resume_log import FILES
from spiraltrunk.workflows.survey.row import Row
from spiraltrunk.workflows.survey.run_survey import MOST_WORKERS, Watch, run_survey

WRITER = "demos"
"""Name of the command in output folders."""

RESULT = "result.json"
"""File with settings and counts."""

SETTINGS = "settings.json"
"""File with the settings alone: it is written before the first episode and stays, whereas `RESULT` is removed while a
data set moves in, and a kill can come then."""

TRIALS = "trials"
"""Name of the folder of the survey's log and tables."""

GROWTH = 2
"""How many times as many episodes there are before the data set is written anew [-] (ours): all writing then costs at
most twice that of the last data set, and after a kill half of the episodes or more are in it."""

_ALLOWED = "allowed: the folder of demonstrations with the same settings, or a new one"

Work = Callable[[Entry], Row]
"""Runs a trial and writes its episode."""


@final
@dataclass(frozen=True, kw_only=True)
class DemosPlan:
    """Trials to record, and the data set to write from them."""

    survey: SurveyPlan
    """The trials, those of the survey with the same plan."""
    recording: RecordingOptions
    """What is recorded of each."""
    format: str
    """Format of the data set, a name in `spiraltrunk.workflows.demos.dataset.formats`."""

    def __post_init__(self) -> None:
        get_format(self.format)


def list_files(name: str) -> tuple[str, ...]:
    """Files that demonstrations in the format called ``name`` always write.

    Raises:
        UnknownName: lists the formats.
    """
    return (RESULT, SETTINGS, "trunk.toml", *get_format(name).files)


def run_demos(
    plan: DemosPlan,
    *,
    folder: str | Path | OutputFolder,
    workers: int = 1,
    work: Work | None = None,
    engine: Engine | None = None,
    watch: Watch | None = None,
    progress: Progress = ignore_progress,
) -> dict[str, Any]:
    """Run and record all trials of a plan, and write their data set; trials that are recorded are not run again.

    The episodes are files of their own in ``episodes``, each written as its trial ends. The data set is made of them
    whenever there are `GROWTH` times as many as before, at an interruption and at the end. It is independent of workers
    and interruptions.

    Args:
        plan: the trials, and what to make of them.
        folder: where to write.
        workers: processes that share the trials.
        work: function that runs and records a trial, importable in processes; None does it in simulation.
        engine: what runs the trials, as in `run_survey`; its machines must see the folder at the same path.
        watch: called with all rows as the work goes on.
        progress: called as data sets are written.

    Returns:
        Settings, counts and the episodes, ready for JSON.

    Raises:
        DesignError: for a number of workers out of range.
        SurveyError: where the folder holds other demonstrations, or other things.
        RunError: where processes cannot be started.
        OutputError: where the folder cannot be written, another process writes to it, or a file in it is not the
            command's own.
        ImportError: where the trials or the format need a package that is missing.
    """
    check_count("survey.workers", workers, least=1, most=MOST_WORKERS)
    get_format(plan.format).check_packages()
    with open_output(folder, WRITER, list_files(plan.format)) as output:
        settings = _compute_settings(plan)
        held = begin_demos(output, plan, settings)
        if held is not None:
            return held
        run = _Run(output, plan, settings, work=work, engine=engine or run_jobs, progress=progress)
        try:
            with open_output(output.path / TRIALS, WRITER, FILES) as trials:
                run_survey(
                    plan.survey, workers=workers, folder=trials, work=run.work, engine=engine, watch=run.follow(watch)
                )
        except KeyboardInterrupt:
            run.write_dataset()
            raise
        run.record_missing(workers)
        return run.write_dataset()


def begin_demos(output: OutputFolder, plan: DemosPlan, settings: Mapping[str, Any]) -> dict[str, Any] | None:
    """Prepare a folder for demonstrations with these settings, and return their result where they are complete.

    Raises:
        SurveyError: where the folder holds other demonstrations, or other things.
        OutputError: where the folder cannot be written.
    """
    held = _read_result(output.path, settings)
    if held is not None and held["complete"] and all((output.path / name).exists() for name in held["files"]):
        return held
    _Run(output, plan, settings).write_result()
    return None


def write_demos(
    output: OutputFolder, plan: DemosPlan, settings: Mapping[str, Any], rows: Sequence[Row], progress: Progress
) -> dict[str, Any]:
    """Write the data set of trials that have been run, whose episodes are in the folder, and return the result.

    Raises:
        OutputError: where an episode is missing or damaged, or the folder cannot be written.
    """
    run = _Run(output, plan, settings, progress=progress)
    run.follow(None)(rows)
    return run.write_dataset()


@final
class _Run:
    """Demonstrations under way: the rows so far, and the data set of their episodes."""

    def __init__(
        self, output: OutputFolder, plan: DemosPlan, settings: Mapping[str, Any], *, work: Work | None = None,
        engine: Engine = run_jobs, progress: Progress = ignore_progress,
    ) -> None:  # fmt: skip
        self._output, self._plan, self._engine, self._progress = output, plan, engine, progress
        self._settings = settings
        self._folder = (output.path / FOLDER).resolve()
        self._format: Format = get_format(plan.format)
        self._rows: Sequence[Row] | None = None
        """Rows so far, to which each call adds; None before any is known."""
        self._n_kept = 0
        """Number of those whose trials have episodes."""
        self._written: tuple[tuple[Path, ...], int, dict[str, Any]] = ((), -1, {})
        """Episodes of the last data set, the number of rows then, and the result."""
        survey = plan.survey
        self.work = work or partial(
            record_entry, design=survey.design, timestep=survey.timestep, recording=plan.recording, folder=self._folder
        )

    def follow(self, watch: Watch | None) -> Watch:
        """A callback for all rows so far, which writes the data set from time to time."""

        def note(rows: Sequence[Row]) -> None:
            if self._rows is not None and rows:
                self._check_seen(rows[-1])
            self._n_kept += sum(is_kept(row, self._plan.recording) for row in rows[len(self._rows or ()) :])
            self._rows = list(rows)
            if watch is not None:
                watch(rows)
            if self._n_kept >= max(1, GROWTH * len(self._written[0])):
                self.write_dataset()

        return note

    def _check_seen(self, row: Row) -> None:
        """Refuse episodes that another machine has written elsewhere."""
        path = self._find_episode(row)
        if is_kept(row, self._plan.recording) and not path.exists():
            allowed = "allowed: a folder that all machines see at the same path"
            raise OutputError(f"{str(path)!r} is not there, though its trial has ended; {allowed}")

    def record_missing(self, workers: int) -> None:
        """Record anew the trials whose episodes were removed."""
        missing = [row for row in self._list_kept() if not self._find_episode(row).exists()]
        wanted = {(row["strategy"], row["index"]) for row in missing}
        entries = [each for each in self._plan.survey.entries() if (each.strategy, each.index) in wanted]
        with closing(self._engine(self.work, entries, workers)) as outcomes:
            for i, outcome in enumerate(outcomes):
                self._progress("recording removed episodes again", i, len(entries))
                outcome.unwrap()

    def write_dataset(self) -> dict[str, Any]:
        """Write the data set of the episodes so far, and the result."""
        files = tuple(path for row in self._list_kept() if (path := self._find_episode(row)).exists())
        if not files:
            return self.write_result()
        if self._written[:2] == (files, len(self._rows or ())):
            return self._written[2]
        self._progress(f"data set of {len(files)} demonstrations", 0, 1)
        episodes = Episodes(files)
        with self._output.draft() as draft:
            self._format.write(episodes, Layout.from_episode(load_episode(files[0])), draft)
            result = self._compute_result(files, _list_names(draft))
            self._write_about(draft, result)
        self._written = (files, len(self._rows or ()), result)
        return result

    def write_result(self) -> dict[str, Any]:
        """Write the result where there is no episode yet; a data set of an earlier run stays."""
        result = self._compute_result((), [])
        with self._output.draft(is_partial=True) as draft:
            self._write_about(draft, result)
        return result

    def _write_about(self, draft: Path, result: dict[str, Any]) -> None:
        write_text(draft / "trunk.toml", format_design(self._plan.survey.design))
        write_text(draft / SETTINGS, format_json(self._settings) + "\n")
        write_text(draft / RESULT, format_json(result) + "\n")

    def _compute_result(self, files: Sequence[Path], names: Sequence[str]) -> dict[str, Any]:
        plan, rows = self._plan, sort_rows(self._plan.survey, self._rows or ())
        asked = sum(plan.survey.count_trials().values())
        written = set(files)
        episodes = [row for row in rows if self._find_episode(row) in written]
        keys = ("strategy", "object", "index", "seed", "success", "reason", "simulated_s")
        return {
            "format": plan.format,
            "demonstrations": len(files),
            "trials": len(rows),
            "asked": asked,
            "complete": len(rows) == asked and len(files) == len(self._list_kept()),
            "strategies": {name: _count(name, rows, episodes) for name in plan.survey.objects},
            "episodes": [{key: row[key] for key in keys} for row in episodes],
            "settings": dict(self._settings),
            "files": sorted({*names, RESULT, SETTINGS, "trunk.toml"}),
        }

    def _list_kept(self) -> list[Row]:
        """Rows of the trials that have episodes, in the order of the data set."""
        return [row for row in sort_rows(self._plan.survey, self._rows or ()) if is_kept(row, self._plan.recording)]

    def _find_episode(self, row: Row) -> Path:
        return self._folder / name_episode(row["strategy"], row["index"])


def _count(name: str, rows: Sequence[Row], episodes: Sequence[Row]) -> dict[str, int]:
    own = [row for row in rows if row["strategy"] == name]
    recorded = sum(row["strategy"] == name for row in episodes)
    return {"trials": len(own), "successes": sum(row["success"] for row in own), "demonstrations": recorded}


def _list_names(folder: Path) -> list[str]:
    return [str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()]


def _compute_settings(plan: DemosPlan) -> dict[str, Any]:
    """Settings that are equal for equal demonstrations, ready for JSON."""
    return {**plan.survey.settings(), "recording": plan.recording.settings(), "format": plan.format}


def _read_result(folder: Path, settings: Mapping[str, Any]) -> dict[str, Any] | None:
    """The result of an earlier run with these settings; None where there is none, or a kill came while it was replaced.

    Raises:
        SurveyError: where the folder holds other demonstrations, or episodes or trials without settings.
    """
    held = _read_object(folder / RESULT, {"settings", "complete", "files"})
    told = held["settings"] if held is not None else _read_object(folder / SETTINGS, set())
    if told is None:
        _check_empty(folder)
        return None
    if not isinstance(told, dict) or not settings.keys() - {"files"} <= told.keys():
        raise _refuse_file(folder / (RESULT if held is not None else SETTINGS))
    differing = [key for key in settings if settings[key] != told.get(key)]
    if differing:
        what = _describe_difference(differing[0], told.get(differing[0]), settings[differing[0]])
        raise SurveyError(f"--out: {str(folder)!r} holds demonstrations with {what}; {_ALLOWED}")
    return held


def _read_object(path: Path, keys: set[str]) -> dict[str, Any] | None:
    """The JSON object of a file, which has the keys; None where there is no file.

    Raises:
        SurveyError: where it is of no demonstrations.
    """
    try:
        held = json.loads(path.read_text())
    except FileNotFoundError:
        return None
    except (ValueError, RecursionError):
        raise _refuse_file(path) from None
    if not isinstance(held, dict) or not keys <= held.keys():
        raise _refuse_file(path)
    return held


def _refuse_file(path: Path) -> SurveyError:
    return SurveyError(f"--out: {str(path)!r} is of no demonstrations; {_ALLOWED}")


def _describe_difference(name: str, there: Any, asked: Any) -> str:
    """Which setting differs, and how; of the recording's settings the first that does."""
    if name == "design":
        return "another design"
    if isinstance(there, dict) and isinstance(asked, dict):
        differing = [key for key in asked if asked[key] != there.get(key)]
        if differing:
            return _describe_difference(differing[0], there.get(differing[0]), asked[differing[0]])
    return f"{name} {json.dumps(there)}, not {json.dumps(asked)}"


def _check_empty(folder: Path) -> None:
    """Refuse a folder that has episodes or trials and no settings."""
    with suppress(FileNotFoundError, NotADirectoryError):
        for path in (folder / FOLDER).iterdir():
            raise SurveyError(f"--out: {str(path)!r} is there, but no {SETTINGS} of demonstrations; {_ALLOWED}")
    if (folder / FOLDER).exists() and not (folder / FOLDER).is_dir():
        raise SurveyError(f"--out: {str(folder / FOLDER)!r} is no folder; {_ALLOWED}")
    if (folder / TRIALS).exists() and not (folder / TRIALS / STATE).exists():
        raise _refuse_file(folder / TRIALS)
