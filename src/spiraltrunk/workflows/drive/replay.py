"""A log read back: what happened, and the figure of what the robot measured."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import numpy as np

from spiraltrunk.errors import DriveError
from spiraltrunk.files.results import to_json
from spiraltrunk.hardware.log import Log, load_log
from spiraltrunk.hardware.log.channels import FaultLog, MotorLog, ObservationLog, StateLog, StatusLog, WarningLog
from spiraltrunk.report.drive_plot import Measured, write_drive_plot
from spiraltrunk.strategies.moves import PHASES

PLOT = "drive.png"
"""Name of the figure."""


@final
@dataclass(frozen=True, kw_only=True)
class Replay:
    """What a log tells."""

    result: dict[str, Any]
    """Figures, ready for JSON."""
    measured: Measured
    """Quantities over time, from the first message on the motors."""


def read_replay(path: str | Path) -> Replay:
    """Read a log, whole or cut off.

    Raises:
        DriveError: where it is no log, or holds nothing of the motors.
        OSError: where it cannot be read.
    """
    log = load_log(path)
    if log[MotorLog].time.size < 2:
        raise DriveError(f"{str(path)!r} holds {log[MotorLog].time.size} messages on the motors; allowed: 2 or more")
    return Replay(result=_compute_result(log), measured=_build_measured(log, Path(path).name))


def write_replay(replay: Replay, folder: Path) -> None:
    """Draw the figure.

    Raises:
        OSError: where the folder cannot be written.
    """
    write_drive_plot(replay.measured, folder / PLOT)


def _compute_result(log: Log) -> dict[str, Any]:
    motors, faults, states, began = log[MotorLog], log[FaultLog], log[StateLog], log[MotorLog].time[0]
    result = {
        "bus": log.metadata.bus,
        "is_twin": log.metadata.is_twin,
        "seed": log.metadata.seed,
        "is_complete": log.is_complete,
        "damage": log.damage,
        "duration_s": float(motors.time[-1] - began),
        "tension_most_n": np.nanmax(motors.tension, axis=0).tolist(),
        "temperature_most_degc": np.nanmax(motors.temperature, axis=0).tolist(),
        "modes": [
            {"time_s": float(time - began), "mode": mode} for time, mode in zip(states.time, states.mode, strict=True)
        ],
        "faults": [
            {"time_s": float(time - began), "kind": kind, "cable": None if np.isnan(cable) else int(cable) + 1,
             "text": text, "reaction": reaction}
            for time, kind, cable, text, reaction in zip(
                faults.time, faults.kind, faults.cable, faults.text, faults.reaction, strict=True
            )
        ],
        "warnings": list(log[WarningLog].text),
        "n_observation": int(log[ObservationLog].time.size),
    }  # fmt: skip
    return {key: to_json(value) for key, value in result.items()}


def _build_measured(log: Log, title: str) -> Measured:
    motors, faults, began = log[MotorLog], log[FaultLog], log[MotorLog].time[0]
    return Measured(
        time=motors.time - began, phase_spans=_find_phases(log, began), pull=motors.pull, tension=motors.tension,
        target=motors.target, temperature=motors.temperature,
        faults=tuple((float(time - began), kind or "") for time, kind in zip(faults.time, faults.kind, strict=True)),
        title=title,
    )  # fmt: skip


def _find_phases(log: Log, began: float) -> tuple[tuple[str, float, float], ...]:
    """Name, begin and end of each phase [-, s, s], each lasting until the next begins."""
    status = log[StatusLog]
    begins: dict[str, float] = {}
    for time, phase in zip(status.time, status.phase, strict=True):
        if phase in PHASES:
            begins.setdefault(phase, float(time - began))
    if not begins:
        return ()
    ends = [*list(begins.values())[1:], float(status.time[-1] - began)]
    return tuple((phase, begin, end) for (phase, begin), end in zip(begins.items(), ends, strict=True) if end > begin)
