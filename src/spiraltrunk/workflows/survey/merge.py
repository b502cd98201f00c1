"""Merge of a survey's shards into the survey that one machine would have run.

The merged table equals the unsharded one bit for bit. So do all columns of its trials but `WALL_COLUMNS`, which are
times that the machine took.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

from spiraltrunk.errors import DesignError, SurveyError
from spiraltrunk.files.output_folder import OutputFolder, open_output
from spiraltrunk.workflows.survey.plan import Shard, SurveyPlan, build_plan, parse_shard
from spiraltrunk.workflows.survey.results import sort_rows, write_all_pictures, write_result
from spiraltrunk.workflows.survey.resume_log import FILES, WRITER, open_log
from spiraltrunk.workflows.survey.row import Row
from spiraltrunk.workflows.survey.stored_survey import StoredSurvey, load_survey

WALL_COLUMNS = ("wall_s", "planning_wall_s", "real_time_factor")
"""Columns of a trial that depend on the machine; all others are equal wherever it runs."""

_OPTION = "--merge"


@final
@dataclass(frozen=True, kw_only=True)
class ShardedSurvey:
    """All shards of a survey, each once and complete."""

    shards: tuple[StoredSurvey, ...]
    """The shards."""
    settings: Mapping[str, Any]
    """Settings of the whole survey, with the versions and the code of the machines that ran it."""
    plan: SurveyPlan
    """Plan of the whole survey."""

    @property
    def rows(self) -> list[Row]:
        """All trials, by strategy and index."""
        return sort_rows(self.plan, [row for shard in self.shards for row in shard.rows])


def load_shards(folders: Sequence[str | Path]) -> ShardedSurvey:
    """Read the shards of a survey.

    Raises:
        SurveyError: where a folder holds no shard, a shard is there twice, missing or half done, or the shards are of
            different surveys.
    """
    shards = tuple(load_survey(folder, _OPTION) for folder in folders)
    settings = _check_same(shards)
    _check_all(shards)
    return ShardedSurvey(shards=shards, settings=settings, plan=_build_plan(settings, shards[0].folder))


def merge_surveys(folders: Sequence[str | Path], out: str | Path | OutputFolder) -> dict[str, Any]:
    """Merge the shards of a survey, all of them and each complete, and write the survey.

    Returns:
        The survey's result, as of `run_survey`.

    Raises:
        SurveyError: as `load_shards`, or where ``out`` holds another survey.
        OutputError: where ``out`` cannot be written.
    """
    return write_survey(load_shards(folders), out)


def write_survey(survey: ShardedSurvey, out: str | Path | OutputFolder) -> dict[str, Any]:
    """Write a survey of which all shards were read, and return its result.

    Raises:
        SurveyError: where ``out`` holds another survey.
        OutputError: where ``out`` cannot be written.
    """
    plan, settings = survey.plan, survey.settings
    with open_output(out, WRITER, FILES) as output, open_log(output, settings) as log:
        write_result(output, plan, settings, log.rows)
        there = {(row["strategy"], row["index"]) for row in log.rows}
        for row in survey.rows:
            if (row["strategy"], row["index"]) not in there:
                log.add(row)
        result = write_result(output, plan, settings, log.rows)
        write_all_pictures(output, plan, result, log.rows)
    return result


def _check_same(shards: Sequence[StoredSurvey]) -> dict[str, Any]:
    """Refuse shards of different surveys; returns the settings of the whole survey.

    Raises:
        SurveyError: for shards of different surveys.
    """
    first = shards[0]
    whole = {**first.settings, "shard": None}
    for other in shards[1:]:
        theirs = {**other.settings, "shard": None}
        differing = [key for key in whole.keys() | theirs.keys() if whole.get(key) != theirs.get(key)]
        if differing:
            raise SurveyError(
                f"{_OPTION}: {str(first.folder)!r} and {str(other.folder)!r} are of different surveys: they differ in "
                f"{', '.join(sorted(differing))}; allowed: shards of one survey"
            )
    return whole


def _check_all(shards: Sequence[StoredSurvey]) -> None:
    """Refuse shards that are not all of them, each once and complete.

    Raises:
        SurveyError: with the first that is missing, there twice or half done.
    """
    found: dict[int, StoredSurvey] = {}
    count = _read_shard(shards[0]).count
    for each in shards:
        shard = _read_shard(each)
        if shard.count != count:
            allowed = f"allowed: shards of {count}"
            raise SurveyError(f"{_OPTION}: {str(each.folder)!r} holds shard {shard}, others one of {count}; {allowed}")
        if shard.number in found:
            both = f"{str(found[shard.number].folder)!r} and {str(each.folder)!r}"
            raise SurveyError(f"{_OPTION}: shard {shard} is in {both}; allowed: each shard once")
        found[shard.number] = each
    missing = [f"{number}/{count}" for number in range(1, count + 1) if number not in found]
    if missing:
        told = ", ".join(missing[:8]) + (f" and {len(missing) - 8} more" if len(missing) > 8 else "")
        raise SurveyError(f"{_OPTION}: of {count} shards, {told} missing; allowed: all of them")
    for each in shards:
        asked = sum(_build_plan(each.settings, each.folder).count_trials().values())
        if len(each.rows) < asked:
            raise SurveyError(
                f"{_OPTION}: shard {_read_shard(each)} in {str(each.folder)!r} has {len(each.rows)} of {asked} trials; "
                "allowed: complete shards; the command that began it goes on with the rest"
            )


def _read_shard(survey: StoredSurvey) -> Shard:
    shard = survey.settings["shard"]
    if shard is None:
        allowed = "allowed: folders of survey --shard I/N"
        raise SurveyError(f"{_OPTION}: {str(survey.folder)!r} holds a whole survey, not a shard; {allowed}")
    try:
        return parse_shard(shard)
    except DesignError as error:
        raise _refuse(survey.folder, error) from None


def _build_plan(settings: Mapping[str, Any], folder: Path) -> SurveyPlan:
    try:
        return build_plan(settings)
    except (DesignError, KeyError, TypeError, AttributeError) as error:
        raise _refuse(folder, error) from None


def _refuse(folder: Path, error: Exception) -> SurveyError:
    return SurveyError(f"{_OPTION}: {str(folder)!r} holds settings of no survey ({error}); allowed: shards")
