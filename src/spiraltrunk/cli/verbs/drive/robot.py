"""The robot that a command drives, with what a person sees of it meanwhile."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.output import UsageError, quote
from spiraltrunk.cli.verbs.drive.live import show_robot

if TYPE_CHECKING:
    from spiraltrunk.hardware.driver_snapshot import Snapshot
    from spiraltrunk.workflows.drive.robot import Robot


@contextmanager
def open_robot(arguments: argparse.Namespace) -> Iterator[Robot]:
    """The robot on the bus of the arguments, shown while it runs; it lets go at the end, and on Ctrl-C.

    Raises:
        UsageError: for a bus that is none.
    """
    from spiraltrunk.design import load_design
    from spiraltrunk.workflows.drive.twin_robot import TwinOptions, TwinRobot

    check_bus(arguments.bus)
    design = load_design(arguments.design)
    with TwinRobot(design, options=TwinOptions(seed=arguments.seed)) as robot, show_robot(robot, sys.stderr):
        yield robot


def check_bus(bus: str) -> None:
    """Refuse a bus that is not there."""
    if bus != "virtual":
        raise UsageError(f"--bus is {quote(bus)}; allowed: virtual")


def compute_state(snapshot: Snapshot) -> dict[str, Any]:
    """State of the robot, ready for JSON."""
    return {
        "mode": snapshot.mode.value,
        "is_homed": snapshot.is_homed,
        "is_watched": snapshot.is_watched,
        "time_s": snapshot.time,
        "cables": [
            {
                "pull_mm": 1e3 * cable.pull,
                "tension_n": cable.tension,
                "tension_target_n": cable.tension_target,
                "torque_nm": cable.torque,
                "temperature_degc": cable.temperature,
                "voltage_v": cable.voltage,
                "feedback_age_ms": 1e3 * cable.feedback_age,
            }
            for cable in snapshot.cables
        ],
        "faults": [
            {"kind": fault.kind.value, "cable": None if fault.cable is None else fault.cable + 1, "time_s": fault.time, "text": fault.text}
            for fault in snapshot.faults
        ],
        "warnings": list(snapshot.warnings),
        "n_refused": snapshot.n_refused,
        "loss": snapshot.loss,
        "lateness_ms": {
            "p50": 1e3 * snapshot.lateness.p50, "p99": 1e3 * snapshot.lateness.p99,
            "p999": 1e3 * snapshot.lateness.p999, "n_period": snapshot.lateness.n_period,
        },
    }  # fmt: skip
