"""The robot that a command drives, with what a person sees of it meanwhile."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.output import UsageError, quote
from spiraltrunk.cli.verbs.drive.live import show_robot
from spiraltrunk.errors import DriveError

if TYPE_CHECKING:
    from spiraltrunk.design.trunk import TrunkDesign
    from spiraltrunk.hardware.driver.snapshot import Snapshot
    from spiraltrunk.hardware.setup.robot_file import RobotFile
    from spiraltrunk.workflows.drive.robot import Robot


@contextmanager
def open_robot(arguments: argparse.Namespace, *, is_real_time: bool = False) -> Iterator[Robot]:
    """The robot on the bus of the arguments, shown while it runs; it lets go at the end, and on Ctrl-C.

    Its arm is left alone: only `run` uses it.

    Args:
        arguments: the arguments.
        is_real_time: whether the twin follows the computer's clock, even where the arguments do not say so.

    Raises:
        UsageError: for a bus that is none.
        DesignError: for a robot file that does not fit.
        DriveError: where a port cannot be opened.
    """
    from spiraltrunk.design import load_design

    design = load_design(arguments.design)
    with _build_robot(arguments, design, is_real_time=is_real_time) as robot, show_robot(robot, sys.stderr):
        yield robot


def _build_robot(arguments: argparse.Namespace, design: TrunkDesign, *, is_real_time: bool) -> Robot:
    file = read_robot_file(arguments, design)
    if file is None:
        from spiraltrunk.workflows.drive.twin.twin_robot import TwinOptions, TwinRobot

        is_real_time, wired = is_real_time or arguments.real_time, load_wiring(arguments, design)
        return TwinRobot(design, options=TwinOptions(seed=arguments.seed, is_real_time=is_real_time, file=wired))
    from spiraltrunk.workflows.drive.hardware_robot import HardwareRobot

    return HardwareRobot(design, replace(file, arm="none"), without_watchdog=arguments.without_watchdog)


def load_wiring(arguments: argparse.Namespace, design: TrunkDesign) -> RobotFile | None:
    """The robot file of the arguments; None without one. Nothing is opened.

    Raises:
        DesignError: where it cannot be read, or does not fit the design.
    """
    from spiraltrunk.hardware.setup.robot_limits import load_fitting_file

    return None if arguments.robot is None else load_fitting_file(arguments.robot, design)


def read_robot_file(arguments: argparse.Namespace, design: TrunkDesign) -> RobotFile | None:
    """How the robot on the bus of the arguments is wired; None for the twin. Nothing is opened.

    Without a robot file the motors of a bus are the design's, with ids from 1, and there is no watchdog.

    Raises:
        UsageError: for a bus that is none.
        DesignError: for a robot file that cannot be read, or does not fit the design.
    """
    from spiraltrunk.hardware.bus.bus_address import ALLOWED, BusKind, parse_bus_address
    from spiraltrunk.hardware.setup.robot_file import MotorSetup, RobotFile

    bus, file = arguments.bus, load_wiring(arguments, design)
    if bus == "virtual":
        return None
    if arguments.real_time:
        raise UsageError(f"--real-time given with --bus {quote(bus)}; allowed: with --bus virtual, the twin")
    if bus == "robot":
        if file is None:
            raise UsageError("--bus robot given without --robot; allowed: --robot FILE, whose bus it opens")
        return file
    try:
        address = parse_bus_address(bus)
    except DriveError:
        raise UsageError(f"--bus is {quote(bus)}; allowed: virtual; robot, the bus of --robot; {ALLOWED}") from None
    if file is None:
        family = "sts" if address.kind is BusKind.STS else "gm6020"
        ids = tuple(range(1, design.n_cable + 1))
        file = RobotFile(name="no file", bus=bus, motors=MotorSetup(family=family, ids=ids))
    return replace(file, bus=bus)


def check_twin(arguments: argparse.Namespace) -> None:
    """Refuse a bus for what only the twin does."""
    if arguments.bus != "virtual":
        raise UsageError(f"--bus is {quote(arguments.bus)}; allowed: virtual, the twin")


def compute_state(snapshot: Snapshot) -> dict[str, Any]:
    """State of the robot, ready for JSON."""
    return {
        "mode": snapshot.mode.value,
        "is_homed": snapshot.is_homed,
        "is_watched": snapshot.is_watched,
        "watchdog_absence": snapshot.absence,
        "time_s": snapshot.time,
        "cables": [
            {
                "pull_mm": 1e3 * cable.pull + 0.0,  # No -0.
                "tension_n": cable.tension,
                "load_cell_n": cable.felt,
                "load_cell_age_ms": None if cable.cell_age is None else 1e3 * cable.cell_age,
                "tension_target_n": cable.tension_target,
                "torque_nm": cable.torque,
                "torque_sent_nm": cable.torque_sent,
                "temperature_degc": cable.temperature,
                "voltage_v": cable.voltage,
                "feedback_age_ms": 1e3 * cable.feedback_age,
            }
            for cable in snapshot.cables
        ],
        "faults": [
            {
                "kind": fault.kind.value, "cable": None if fault.cable is None else fault.cable + 1,
                "time_s": fault.time, "text": fault.text,
            }
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
