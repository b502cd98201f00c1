"""Log of a soak: whether it tells every fault with its time and reaction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np

from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.log import Log, load_log
from spiraltrunk.hardware.log.channels import FaultLog, MotorLog, StateLog, WarningLog
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.workflows.drive.recorder import REACTION
from spiraltrunk.workflows.drive.soak import FaultRecord, describe_injection

OFF_TIME = 0.1
"""Time after a fault from which the log must tell that no torque is sent [s]."""

_CLOSE = 1e-6
"""Difference of times in record and log that is none [s]: a log counts nanoseconds."""

_PERIODS = 0.05
"""Time within which the log must tell the mode that follows [s]: it is written every 20 ms."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class LogCheck:
    """What a soak's log tells of its faults."""

    n_noticed: int
    """Faults that were noticed, of which the log holds time, kind, reaction, mode and the end of all torque."""
    n_injected: int
    """Faults that were injected, of which the log holds the time."""
    n_message: int
    """Messages of the motors."""
    problems: tuple[str, ...]
    """What is wrong or missing, one line each."""


def check_log(path: Path, records: Sequence[FaultRecord]) -> LogCheck:
    """Compare a soak's log with its record of faults.

    Raises:
        DriveError: where the file is no log.
    """
    log = load_log(path, ("/motors", "/state", "/fault", "/warning"))
    noticed = [record for record in records if record.noticed is not None]
    injected = [record for record in records if record.injected is not None]
    problems = [] if log.is_complete else [f"the log is not whole: {log.damage}"]
    for record in noticed:
        problems += _check_noticed(log, record)
    for record in injected:
        problems += _check_injected(log[WarningLog], record)
    return LogCheck(
        n_noticed=len(noticed), n_injected=len(injected), n_message=log[MotorLog].time.size, problems=tuple(problems)
    )


def _check_noticed(log: Log, record: FaultRecord) -> list[str]:
    """What the log lacks of a fault that stopped the driver."""
    assert record.noticed is not None
    name, at, faults = f"{record.kind} at {record.noticed:.3f} s", record.noticed, log[FaultLog]
    rows = np.flatnonzero(np.abs(faults.time - at) < _CLOSE)
    if not any((faults.kind[row], faults.reaction[row]) == (record.kind, REACTION) for row in rows):
        return [f"{name}: not in the log with its reaction"]
    problems, states = [], log[StateLog]
    entered = np.flatnonzero((states.time > at - _CLOSE) & (states.time < at + _PERIODS))
    if not any((states.mode[row], states.cause[row]) == (Mode.FAULT.value, record.kind) for row in entered):
        problems.append(f"{name}: the log does not tell that the driver stopped")
    motors = log[MotorLog]
    after = np.flatnonzero((motors.time > at + OFF_TIME) & (motors.time < at + OFF_TIME + _PERIODS))
    sent = motors.torque_sent[after]
    if not sent.size or np.any(sent != 0.0):
        problems.append(f"{name}: the log does not tell that the torque was off {OFF_TIME:g} s later")
    return problems


def _check_injected(warnings: WarningLog, record: FaultRecord) -> list[str]:
    """What the log lacks of a fault that was injected."""
    assert record.injected is not None
    rows = np.flatnonzero(np.abs(warnings.time - record.injected) < _CLOSE)
    if any(warnings.text[row] == describe_injection(record.name) for row in rows):
        return []
    return [f"{record.name} at {record.injected:.3f} s: not in the log"]
