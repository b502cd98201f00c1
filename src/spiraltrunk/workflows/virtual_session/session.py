"""A whole virtual session: every run of a protocol, all its takes, as files or as shapes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np

from spiraltrunk.calibration.predict_states import place_markers
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.files.atomic import atomic_file
from spiraltrunk.files.results import Progress, ignore_progress
from spiraltrunk.mocap.protocol.protocol import Protocol, Run
from spiraltrunk.mocap.protocol.schedule import build_plan
from spiraltrunk.mocap.recordings.motive_write import write_motive
from spiraltrunk.model.kinematics.measured_shapes import MeasuredShapes, compute_marker_offset
from spiraltrunk.workflows.virtual_session.cameras import PAPERS, FilmOptions, film
from spiraltrunk.workflows.virtual_session.play import Played, play_by_model, play_simulated
from spiraltrunk.workflows.virtual_session.printed_trunk import World


@final
@dataclass(frozen=True, kw_only=True)
class MeasureOptions:
    """How well held shapes are measured."""

    noise: float = 5e-4
    """Standard deviation of each coordinate of each point of a held shape [m]: many frames' mean is better."""
    turn: float = 2e-3
    """Of the registration's rotation about each axis, take by take [rad]."""
    shift: float = 3e-4
    """Of the registration's shift along each axis, take by take [m]."""
    sections: tuple[int, ...] = PAPERS
    """Sections with markers, from 1."""


def play_session(
    design: TrunkDesign,
    world: World,
    protocol: Protocol,
    *,
    is_simulated: bool = True,
    progress: Progress = ignore_progress,
) -> list[Played]:
    """Every run of a protocol, played once: repeats differ by what the cameras see alone."""
    played = []
    for done, run in enumerate(protocol.runs):
        progress(f"playing {run.name}", done, len(protocol.runs))
        plan = build_plan(design, protocol, run)
        played.append(play_simulated(world, plan) if is_simulated else play_by_model(world, plan))
    return played


def write_session(
    design: TrunkDesign, played: Sequence[Played], seed: int, folder: str | Path, options: FilmOptions | None = None
) -> list[Path]:
    """Takes as Motive CSV 1.23, named ``RUN_1.csv``, ``RUN_2.csv`` and so on, y up, and the protocol to read them with.

    Its steps are timed: a first step that the slack swallows moves nothing, so that motion alone would not tell it.

    Raises:
        OSError: where a file cannot be written.
    """
    target = Path(folder)
    target.mkdir(parents=True, exist_ok=True)
    files = []
    for number, run in enumerate(played):
        for take in range(max(run.plan.run.takes, 2)):
            path = target / f"{run.plan.run.name}_{take + 1}.csv"
            files.append(write_motive(film(design, run, 1000 * seed + 10 * number + take, options), path))
    period = (FilmOptions() if options is None else options).period
    with atomic_file(target / "protocol.toml") as draft:
        draft.write_text(format_protocol([run.plan.run for run in played], period))
    return [*files, target / "protocol.toml"]


def format_protocol(runs: Sequence[Run], period: float) -> str:
    """Runs as the text of a protocol whose steps come every ``period`` [s]."""
    text = '# Written with a virtual capture.\nschema = 1\nname = "virtual"\naxes = "y-up"\nalignment = "base"\n'
    for run in runs:
        text += f'\n[[run]]\nname = "{run.name}"\nkind = "{run.kind}"\ntheta0_deg = {math.degrees(run.theta_0):.9g}\n'
        text += f"takes = {max(run.takes, 2)}\n"
        if run.steps:
            text += f"steps = {run.steps}\nstep_mm = {1e3 * run.step:.9g}\nbegin_s = 0.0\nperiod_s = {period:.9g}\n"
        if run.first:
            text += f"first_mm = {1e3 * run.first:.9g}\n"
    return text


def measure(
    design: TrunkDesign, played: Sequence[Played], seed: int, options: MeasureOptions | None = None
) -> MeasuredShapes:
    """What a reader would make of two takes of each run, without the way through files.

    Args:
        design: the trunk as believed.
        played: the runs.
        seed: what noise and registration are drawn from.
        options: how well it is measured.
    """
    options = MeasureOptions() if options is None else options
    draw = np.random.default_rng([10, seed])
    offset = compute_marker_offset(design)
    seen = np.isin(np.arange(1, design.n_section + 1), options.sections)
    parts: dict[str, list[object]] = {name: [] for name in ("kind", "take", "theta_0", "pull", "follows", "points")}
    for take in (1, 2):
        for run in played:
            first, count = len(parts["kind"]), len(run.ends)
            points = place_markers(design, run.ends, offset) + draw.normal(0.0, options.noise, run.ends.shape)
            turn = draw.normal(0.0, options.turn, 3)
            points = points + np.cross(turn, points) + draw.normal(0.0, options.shift, 3)
            parts["kind"] += [run.plan.run.kind] * count
            parts["take"] += [f"{run.plan.run.name}_{take}"] * count
            parts["theta_0"] += [run.plan.run.theta_0] * count
            parts["pull"] += list(run.plan.pull)
            parts["follows"] += [-1, *range(first, first + count - 1)]
            parts["points"] += list(np.where(seen[:, None], points, np.nan))
    arrays = {name: np.array(parts[name]) for name in ("theta_0", "pull", "follows", "points")}
    return MeasuredShapes(
        kind=tuple(map(str, parts["kind"])), take=tuple(map(str, parts["take"])), marker_offset=offset,
        rotation=np.full((*arrays["points"].shape, 3), np.nan), **arrays,
    )  # fmt: skip
