"""What a driver measures, written to a log while it runs."""

from __future__ import annotations

from typing import final

from spiraltrunk.hardware.driver.threaded_driver import Driver
from spiraltrunk.hardware.log.recording import log_arm, log_fault, log_state, log_warning
from spiraltrunk.hardware.log.writer import LogWriter

REACTION = "torque ramped to the floor of tension and switched off, arm held"
"""What a driver does on every fault."""


@final
class Recorder:
    """Writes motors, arm, and each new mode, fault and warning; call it as often as the robot is watched."""

    def __init__(self, log: LogWriter) -> None:
        self._log = log
        self._mode = ""
        self._faults: set[tuple[str, int | None, float]] = set()
        self._warnings: set[str] = set()

    def __call__(self, driver: Driver) -> None:
        """Write what is new."""
        log, snapshot = self._log, driver.snapshot()
        cables = snapshot.cables
        log.write(
            "/motors", snapshot.time,
            {
                "feedback_time": [snapshot.time - cable.feedback_age for cable in cables],
                "angle": [cable.angle for cable in cables],
                "speed": [cable.motor_speed for cable in cables],
                "torque": [cable.torque for cable in cables],
                "torque_sent": [cable.torque_sent for cable in cables],
                "temperature": [cable.temperature for cable in cables],
                "voltage": [cable.voltage for cable in cables],
                "pull": [cable.pull for cable in cables],
                "tension": [cable.tension for cable in cables],
                "felt": [cable.felt for cable in cables],
                "target": [cable.tension_target for cable in cables],
            },
        )  # fmt: skip
        if snapshot.arm is not None:
            log_arm(log, snapshot.arm)
        for fault in snapshot.faults:
            if (key := (fault.kind.value, fault.cable, fault.time)) not in self._faults:
                self._faults.add(key)
                log_fault(log, fault, REACTION)
        if snapshot.mode.value != self._mode:
            self._mode = snapshot.mode.value
            log_state(log, snapshot.time, self._mode, snapshot.faults[0].kind.value if snapshot.faults else None)
        for warning in snapshot.warnings:
            if warning not in self._warnings:
                self._warnings.add(warning)
                log_warning(log, snapshot.time, warning)
