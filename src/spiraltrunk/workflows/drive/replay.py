"""A log read back: what happened, and the figure of what the robot measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import numpy as np

from spiraltrunk.errors import DriveError, describe
from spiraltrunk.files.results import to_json
from spiraltrunk.files.text_lines import check_regular
from spiraltrunk.hardware.log import Log, load_log
from spiraltrunk.hardware.log.channels import FaultLog, MotorLog, ObservationLog, StateLog, StatusLog, WarningLog
from spiraltrunk.report.drive_plot import Measured, write_drive_plot
from spiraltrunk.strategies.moves import PHASES

PLOT = "drive.png"
"""Name of the figure."""


@final
@dataclass(frozen=True, kw_only=True)
class Replay:
    """Content of a log."""

    result: dict[str, Any]
    """Figures, ready for JSON."""
    measured: Measured
    """Quantities over time, from the first message on the motors."""


def read_replay(path: str | Path, *, intact: bool = False) -> Replay:
    """Read a log, whole or cut off.

    Args:
        path: the log.
        intact: whether of a log that is damaged the part before the damage is read.

    Raises:
        DriveError: where it is no log, holds nothing of the motors, or is damaged and not ``intact``; it says up to
            which time it is intact.
    """
    try:
        log = load_log(path)
    except DriveError as error:
        if _has_frame(Path(path)):
            found = "is damaged in its head, before the first message: nothing could be read"
            raise DriveError(f"log {describe(str(path))} {found}; allowed: a log whose head is intact") from error
        raise
    motors = log[MotorLog].time
    if log.damage is not None and not intact:
        read = f"{motors.size} messages on the motors were read"
        span = f"damaged after {motors[-1] - motors[0]:.2f} s" if motors.size else "damaged before the first message"
        advice = "allowed: a whole or a cut-off log, or --intact for what stands before the damage"
        raise DriveError(f"log {describe(str(path))} is {span} ({log.damage}); {read}; {advice}")
    if motors.size < 2:
        cut = "" if log.is_complete else ", being cut off at its start"
        what = "messages on the motors"
        raise DriveError(f"log {describe(str(path))} holds {motors.size} {what}{cut}; allowed: 2 or more")
    return Replay(result=_compute_result(log), measured=_build_measured(log, Path(path).name))


def write_replay(replay: Replay, folder: Path) -> None:
    """Draw the figure.

    Raises:
        OSError: where the folder cannot be written.
    """
    write_drive_plot(replay.measured, folder / PLOT)


def summarise_replay(replay: Replay, files: Sequence[str] = ()) -> list[tuple[str, str]]:
    """Name and value of each figure, with its unit; the files that were written come last."""
    result = replay.result
    twin = f", the twin of seed {result['seed']}" if result["is_twin"] else ""
    rows = [
        ("bus", f"{result['bus']}{twin}"),
        ("log", "whole" if result["is_complete"] else "cut off" if result["damage"] is None else "damaged behind this"),
        ("duration", f"{result['duration_s']:.2f} s, {result['n_observation']} observations"),
        ("largest tension", _join(result["tension_most_n"], "{:.1f}", "N")),
        ("largest speed", _join(result["speed_most_mm_s"], "{:.0f}", "mm/s")),
    ]
    if (hottest := result["hottest"]) is not None:
        rows.append(("hottest motor", f"{hottest['temperature_degc']:.0f} degC, of cable {hottest['cable']}"))
    rows += [("state", f"{entry['time_s']:.2f} s: {entry['mode']}") for entry in result["modes"]]
    for fault in result["faults"]:
        where = "" if fault["cable"] is None else f" of cable {fault['cable']}"
        rows.append(("fault", f"{fault['time_s']:.2f} s: {fault['kind']}{where}, {fault['text']}"))
    rows += [] if result["faults"] else [("fault", "none")]
    rows += [("warning", str(text)) for text in result["warnings"]]
    return rows + [("file", name) for name in files]


def _join(values: Sequence[float | None], form: str, unit: str) -> str:
    """One value a cable, in order."""
    shown = (form.format(value) if value is not None else "-" for value in values)
    return ", ".join(f"cable {number}: {one} {unit}" for number, one in enumerate(shown, start=1))


def _has_frame(path: Path) -> bool:
    """Whether a file begins or ends as MCAP does."""
    magic = b"\x89MCAP0\r\n"
    try:
        check_regular(path)
        with path.open("rb") as file:
            head = file.read(len(magic))
            file.seek(max(0, path.stat().st_size - len(magic)))
            return magic in (head, file.read(len(magic)))
    except (OSError, ValueError):
        return False


def _compute_speed_most(motors: MotorLog) -> np.ndarray:
    """Largest speed of each cable, the difference quotient of its pull between two messages, shape (n_cable,) [m/s]."""
    step = np.diff(motors.time)[:, None]
    with np.errstate(invalid="ignore", divide="ignore"):
        speed = np.abs(np.diff(motors.pull, axis=0)) / np.where(step > 0.0, step, np.nan)
    return _find_most(speed)


def _find_most(values: np.ndarray) -> np.ndarray:
    """Largest value of each column; NaN of a column without any."""
    filled = np.where(np.isfinite(values), values, -np.inf).max(axis=0)
    return np.where(np.isfinite(filled), filled, np.nan)


def _find_hottest(motors: MotorLog) -> dict[str, Any] | None:
    """The motor with the highest temperature, by its cable; None where none was measured."""
    most = _find_most(motors.temperature)
    if np.isnan(most).all():
        return None
    cable = int(np.nanargmax(most))
    return {"cable": cable + 1, "temperature_degc": float(most[cable])}


def _compute_result(log: Log) -> dict[str, Any]:
    motors, faults, states, began = log[MotorLog], log[FaultLog], log[StateLog], log[MotorLog].time[0]
    result = {
        "bus": log.metadata.bus,
        "is_twin": log.metadata.is_twin,
        "seed": log.metadata.seed,
        "is_complete": log.is_complete,
        "damage": log.damage,
        "duration_s": float(motors.time[-1] - began),
        "tension_most_n": _find_most(motors.tension).tolist(),
        "speed_most_mm_s": (1e3 * _compute_speed_most(motors)).tolist(),
        "temperature_most_degc": _find_most(motors.temperature).tolist(),
        "hottest": _find_hottest(motors),
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
    """Name, start and end of each phase [-, s, s], each lasting until the next begins."""
    status = log[StatusLog]
    begins: dict[str, float] = {}
    for time, phase in zip(status.time, status.phase, strict=True):
        if phase in PHASES:
            begins.setdefault(phase, float(time - began))
    if not begins:
        return ()
    ends = [*list(begins.values())[1:], float(status.time[-1] - began)]
    return tuple((phase, begin, end) for (phase, begin), end in zip(begins.items(), ends, strict=True) if end > begin)
