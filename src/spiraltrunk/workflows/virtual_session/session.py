"""A virtual session: every run of a protocol with all its takes, as files or as measured shapes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np

from spiraltrunk.calibration.predict_states import place_markers
from spiraltrunk.design import presets
from spiraltrunk.design.schema import MILLI, Key, Kind, format_value
from spiraltrunk.design.toml import write_design
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.files.atomic import write_text
from spiraltrunk.files.output_folder import OutputFolder, open_output
from spiraltrunk.files.results import Progress, ignore_progress
from spiraltrunk.mocap.protocol.protocol import Protocol, Run
from spiraltrunk.mocap.protocol.schedule import build_schedule
from spiraltrunk.mocap.recordings.motive_write import write_motive
from spiraltrunk.model.kinematics.measured_shapes import MeasuredShapes, compute_marker_offset
from spiraltrunk.workflows.virtual_session.cameras import CAMERAS, PAPERS, record_run
from spiraltrunk.workflows.virtual_session.printed_trunk import PrintedTrunk
from spiraltrunk.workflows.virtual_session.simulate import SimulatedRun, simulate_run, solve_run
from spiraltrunk.workflows.virtual_session.synthetic_take import CameraOptions

WRITER = "calibrate --virtual"
"""Name of the command in output folders."""

_DESIGN = "trunk.toml"
"""File of a design that is no preset."""

_SLACK = Key("slack_mm", Protocol, "slack", MILLI, Kind.NUMBERS)


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class MeasurementOptions:
    """Errors of measured shapes."""

    noise: float = 5e-4
    """Standard deviation of each coordinate of each point of a held shape [m]: the mean of many frames is better."""
    turn: float = 2e-3
    """Standard deviation of the registration's rotation about each axis, take by take [rad]."""
    shift: float = 3e-4
    """Standard deviation of the registration's shift along each axis, take by take [m]."""
    sections: tuple[int, ...] = PAPERS
    """Sections with markers, from 1."""


def simulate_session(
    design: TrunkDesign, trunk: PrintedTrunk, protocol: Protocol, *, is_simulated: bool = True,
    progress: Progress = ignore_progress,
) -> list[SimulatedRun]:  # fmt: skip
    """Every run of a protocol once; its takes differ in the cameras' errors alone.

    Args:
        design: the trunk as designed, which the schedule is computed for.
        trunk: the trunk as printed.
        protocol: the session.
        is_simulated: whether MuJoCo moves the trunk, or the equilibrium model solves its shapes.
        progress: called as the work goes on.
    """
    runs: list[SimulatedRun] = []
    for run in protocol.runs:
        progress(f"simulating {run.name}", len(runs), len(protocol.runs))
        runs.append((simulate_run if is_simulated else solve_run)(trunk, build_schedule(design, protocol, run)))
    return runs


def list_files(design: TrunkDesign, runs: Sequence[Run]) -> list[str]:
    """Names of the files of a session with these runs."""
    takes = [_name_take(run, take) for run in runs for take in range(max(run.takes, 2))]
    return [*takes, "protocol.toml", *([] if presets.find_name(design) else [_DESIGN])]


def _name_take(run: Run, take: int) -> str:
    return f"{run.name}_{take + 1}.csv"


def write_session(
    design: TrunkDesign, runs: Sequence[SimulatedRun], seed: int, folder: str | Path | OutputFolder,
    options: CameraOptions = CAMERAS,
) -> list[Path]:  # fmt: skip
    """Write takes as Motive CSV 1.23, named ``RUN_1.csv``, ``RUN_2.csv`` and so on, y up, with a protocol to read them.

    Its steps are timed: while a winder takes in slack, nothing moves, so that motion does not show the step. It names
    the design; one that is no preset is written beside it as ``trunk.toml``.

    Raises:
        OutputError: where a file cannot be written or must not be replaced.
    """
    planned = [run.schedule.run for run in runs]
    names = list_files(design, planned)
    with open_output(folder, WRITER, names) as output, output.draft() as draft:
        for number, run in enumerate(runs):
            for take in range(max(run.schedule.run.takes, 2)):
                recorded = record_run(design, run, _seed_take(seed, number, take), options)
                write_motive(recorded, draft / _name_take(run.schedule.run, take))
        write_text(draft / "protocol.toml", _format_protocol(design, runs, options.period))
        if presets.find_name(design) is None:
            write_design(design, draft / _DESIGN, ["The trunk as designed; the simulated one deviates from it."])
    return [output.path / name for name in names]


def _seed_take(seed: int, number: int, take: int) -> int | tuple[int, ...]:
    """Seed of one take; the short form, which published figures rely on, wherever it is unique."""
    return 1000 * seed + 10 * number + take if number < 100 and take < 10 else (seed, number, take)


def _format_protocol(design: TrunkDesign, runs: Sequence[SimulatedRun], period: float) -> str:
    """Runs of one protocol as the text of a protocol with a step every ``period`` [s]."""
    text = '# Written with a virtual session.\nschema = 1\nname = "virtual"\naxes = "y-up"\nalignment = "base"\n'
    text += f'design = "{presets.find_name(design) or _DESIGN}"\n'
    if runs:
        text += f"slack_mm = {format_value(runs[0].schedule.slack, _SLACK)}\n"
    for run in (simulated.schedule.run for simulated in runs):
        text += f'\n[[run]]\nname = "{run.name}"\nkind = "{run.kind}"\ntheta0_deg = {math.degrees(run.theta_0):.9g}\n'
        text += f"takes = {max(run.takes, 2)}\n"
        if run.steps:
            text += f"steps = {run.steps}\nstep_mm = {1e3 * run.step:.9g}\nbegin_s = 0.0\nperiod_s = {period:.9g}\n"
        if run.first:
            text += f"first_mm = {1e3 * run.first:.9g}\n"
    return text


def measure_session(
    design: TrunkDesign, runs: Sequence[SimulatedRun], seed: int, options: MeasurementOptions | None = None
) -> MeasuredShapes:
    """Measured shapes of two takes of each run, without the way through files.

    Args:
        design: the trunk as designed.
        runs: the runs.
        seed: seed of noise and registration.
        options: errors of the measurement.
    """
    options = MeasurementOptions() if options is None else options
    draw = np.random.default_rng([10, seed])
    offset = compute_marker_offset(design)
    is_seen = np.isin(np.arange(1, design.n_section + 1), options.sections)
    kind: list[str] = []
    take, theta_0, pull, follows, points = [], [], [], [], []
    for number in (1, 2):
        for simulated in runs:
            run, count = simulated.schedule.run, len(simulated.ends)
            placed = place_markers(design, simulated.ends, offset) + draw.normal(
                0.0, options.noise, simulated.ends.shape
            )
            turn = draw.normal(0.0, options.turn, 3)
            placed = placed + np.cross(turn, placed) + draw.normal(0.0, options.shift, 3)
            follows += [-1, *range(len(kind), len(kind) + count - 1)]
            kind += [run.kind] * count
            take += [f"{run.name}_{number}"] * count
            theta_0 += [run.theta_0] * count
            pull += list(simulated.schedule.pull)
            points += list(np.where(is_seen[:, None], placed, np.nan))
    return MeasuredShapes(
        kind=tuple(kind), take=tuple(take), theta_0=np.array(theta_0), pull=np.array(pull), follows=np.array(follows),
        marker_offset=offset, points=np.array(points), rotation=np.full((*np.shape(points), 3), np.nan),
    )  # fmt: skip
