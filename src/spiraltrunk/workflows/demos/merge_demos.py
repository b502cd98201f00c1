"""Merge of the shards of demonstrations into the data set that one machine would have made."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from spiraltrunk.errors import DesignError, OutputError, SurveyError, describe_reason
from spiraltrunk.files.atomic import write_file
from spiraltrunk.files.output_folder import OutputFolder, open_output
from spiraltrunk.files.results import Progress, ignore_progress
from spiraltrunk.workflows.demos.dataset.formats import get_format
from spiraltrunk.workflows.demos.options import RecordingOptions
from spiraltrunk.workflows.demos.recording.episode_file import FOLDER, name_episode
from spiraltrunk.workflows.demos.recording.run_entry import is_kept
from spiraltrunk.workflows.demos.run_demos import (
    RESULT,
    TRIALS,
    WRITER,
    DemosPlan,
    begin_demos,
    list_files,
    write_demos,
)
from spiraltrunk.workflows.survey.merge import load_shards, write_survey
from spiraltrunk.workflows.survey.plan import build_plan
from spiraltrunk.workflows.survey.resume_log import FILES
from spiraltrunk.workflows.survey.stored_survey import StoredSurvey

_OPTION = "--merge"

_ALLOWED = "allowed: complete folders of demos --shard I/N"


def read_plan(folders: Sequence[str | Path]) -> DemosPlan:
    """The whole plan whose shards these folders hold.

    Raises:
        SurveyError: where a folder holds no demonstrations, they are not complete, or two folders hold shards of
            different ones.
    """
    return _build_plan(_read_whole(folders), folders[0])


def _read_whole(folders: Sequence[str | Path]) -> dict[str, Any]:
    """Settings of the whole demonstrations whose shards these folders hold.

    Raises:
        SurveyError: where a folder holds no demonstrations, they are not complete, or two folders hold shards of
            different ones.
    """
    found = [_read_settings(Path(folder)) for folder in folders]
    for folder, settings in zip(folders, found, strict=True):
        if settings.get("shard") is None:
            raise SurveyError(f"{_OPTION}: {str(folder)!r} holds whole demonstrations, not a shard; {_ALLOWED}")
    whole = [{**settings, "shard": None} for settings in found]
    for folder, settings in zip(folders, whole, strict=True):
        differing = [key for key in whole[0].keys() | settings.keys() if whole[0].get(key) != settings.get(key)]
        if differing:
            raise SurveyError(
                f"{_OPTION}: {str(folders[0])!r} and {str(folder)!r} are of different demonstrations: they differ in "
                f"{', '.join(sorted(differing))}; allowed: shards of one command"
            )
    return whole[0]


def _build_plan(settings: Mapping[str, Any], folder: str | Path) -> DemosPlan:
    """The plan with the settings that a folder holds.

    Raises:
        SurveyError: for settings of no demonstrations.
    """
    try:
        recording = {**settings["recording"], "cameras": tuple(settings["recording"]["cameras"])}
        return DemosPlan(
            survey=build_plan(settings), recording=RecordingOptions(**recording), format=settings["format"]
        )
    except (DesignError, KeyError, TypeError, AttributeError) as error:
        reason = f"{str(folder)!r} holds settings of no demonstrations ({error})"
        raise SurveyError(f"{_OPTION}: {reason}; {_ALLOWED}") from None


def merge_demos(
    folders: Sequence[str | Path], out: str | Path | OutputFolder, *, progress: Progress = ignore_progress
) -> dict[str, Any]:
    """Merge the shards of demonstrations, all of them and each complete, and write the data set of all episodes.

    The data set equals the one that a command without shards makes. Nothing is run, so that the machines of the shards
    may have another version than this one. A merge that was interrupted goes on.

    Returns:
        Settings, counts and the episodes, as of `run_demos`.

    Raises:
        SurveyError: where a folder holds no shard, a shard is there twice, missing or half done, an episode is missing,
            the shards are of different demonstrations, or ``out`` holds others.
        OutputError: where an episode cannot be read, or ``out`` not be written.
        ImportError: where the format needs a package that is missing.
    """
    settings = _read_whole(folders)
    plan = _build_plan(settings, folders[0])
    get_format(plan.format).check_packages()
    survey = load_shards([Path(folder) / TRIALS for folder in folders])
    episodes = [path for each in survey.shards for path in _list_episodes(each, plan.recording)]
    with open_output(out, WRITER, list_files(plan.format)) as output:
        held = begin_demos(output, plan, settings)
        if held is not None:
            return held
        with open_output(output.path / TRIALS, WRITER, FILES) as trials:
            write_survey(survey, trials)
        for i, path in enumerate(episodes):
            progress("episodes copied", i, len(episodes))
            _copy(path, output.path / FOLDER / path.name)
        return write_demos(output, plan, settings, survey.rows, progress)


def _list_episodes(shard: StoredSurvey, recording: RecordingOptions) -> list[Path]:
    """Files of a shard's episodes, in the order of their names.

    Raises:
        SurveyError: with the first that is missing.
    """
    folder = shard.folder.parent / FOLDER
    files = sorted(
        folder / name_episode(row["strategy"], row["index"]) for row in shard.rows if is_kept(row, recording)
    )
    missing = [path for path in files if not path.exists()]
    if missing:
        reason = f"{str(missing[0])!r} is missing, though its trial was recorded"
        raise SurveyError(f"{_OPTION}: {reason}; {_ALLOWED} with all their episodes")
    return files


def _read_settings(folder: Path) -> Mapping[str, Any]:
    """Settings of a folder of demonstrations.

    Raises:
        SurveyError: where it holds none, or they are not complete.
    """
    try:
        result = json.loads((folder / RESULT).read_text())
        settings, is_complete = result["settings"], result["complete"]
        told = f"{result['trials']} of {result['asked']}"
        if not isinstance(settings, dict):
            raise TypeError("settings")
    except OSError as error:
        place = str(folder / RESULT if folder.is_dir() else folder)
        raise SurveyError(f"{_OPTION}: {place!r} cannot be read: {describe_reason(error)}; {_ALLOWED}") from None
    except (ValueError, TypeError, KeyError, RecursionError):
        raise SurveyError(f"{_OPTION}: {str(folder / RESULT)!r} is of no demonstrations; {_ALLOWED}") from None
    if not is_complete:
        goes_on = f"{_ALLOWED}; the command that began it goes on with the rest"
        raise SurveyError(f"{_OPTION}: {str(folder)!r} has {told} trials; {goes_on}")
    return settings


def _copy(source: Path, target: Path) -> None:
    try:
        content = source.read_bytes()
        if not target.exists() or target.read_bytes() != content:
            write_file(target, content)
    except OSError as error:
        raise OutputError(f"{str(source)!r} cannot be copied to {str(target)!r}: {describe_reason(error)}") from None
