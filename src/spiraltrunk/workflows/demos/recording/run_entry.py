"""One trial of a survey, recorded."""

from __future__ import annotations

from pathlib import Path

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.scene.options import TIMESTEP
from spiraltrunk.workflows.demos.options import RecordingOptions
from spiraltrunk.workflows.demos.recording.episode_file import name_episode, write_episode
from spiraltrunk.workflows.demos.recording.record import Recorder, build_episode
from spiraltrunk.workflows.survey.code_version import compute_source
from spiraltrunk.workflows.survey.plan import Entry
from spiraltrunk.workflows.survey.row import Row
from spiraltrunk.workflows.survey.run_entry import compute_row


def record_entry(
    entry: Entry, *, design: TrunkDesign, timestep: float = TIMESTEP, recording: RecordingOptions, folder: Path
) -> Row:
    """Run a trial, write its episode where `is_kept`, and return its row.

    Raises:
        ImportError: where a package is missing, OpenGL among them.
        OutputError: where the episode cannot be written.
    """
    recorder = Recorder()
    row = compute_row(entry, design, timestep, run=recorder.run)
    if is_kept(row, recording) and recorder.trial is not None:
        extra = {"index": entry.index, "job": recorder.job, "source": compute_source()}
        episode = build_episode(recorder.trial, recorder, entry.object, recording, extra)
        write_episode(episode, folder / name_episode(entry.strategy, entry.index))
    return row


def is_kept(row: Row, recording: RecordingOptions) -> bool:
    """Whether a trial with this row has an episode; a trial in which nothing moved has none."""
    return bool(row["simulated_s"]) and (row["success"] or recording.keeps_failures)
