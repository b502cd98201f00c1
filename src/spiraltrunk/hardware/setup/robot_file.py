"""Robot files: one TOML file describes the wiring of a robot, whose design is a file of its own.

It names ports, but opens none. It can lower limits of the design and of the motors' data sheet, and raises none: see
`robot_limits`. Nothing of it was tried on a real robot.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from pathlib import Path
from typing import Any, final

from spiraltrunk.checks import check_number, check_text, check_type
from spiraltrunk.design.schema import MILLI, MOST_BYTES, Key, Kind, convert_error, parse_toml, read_table
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, DriveError, Unquoted
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.files.text_lines import check_regular
from spiraltrunk.hardware.bus.bus_address import BusKind, check_port, parse_bus_address
from spiraltrunk.hardware.motors.gm6020 import GM6020, check_motor_ids
from spiraltrunk.hardware.motors.motor_port import MotorDataSheet
from spiraltrunk.hardware.motors.pwm_servo import ServoCalibration
from spiraltrunk.hardware.motors.sts.codec import ID_MAX
from spiraltrunk.hardware.motors.sts.models import MODELS
from spiraltrunk.hardware.setup.cable_setup import CableSetup
from spiraltrunk.hardware.setup.load_cell_setup import LoadCellSetup

FAMILIES = ("gm6020", "sts")
"""Motor families."""

ARMS = ("panda", "franky")
"""Drivers of arms: panda-python and franky."""

ADAPTERS = ("socketcan", "gs_usb", "slcan")
"""CAN adapters, whose bus has motors and no board; the other buses of python-can carry twins."""

_KILO = Decimal("1e3")

STS_PERIOD_MOST = 0.020
"""Longest period of control with sts servos [s] (ours): feedback after one lost answer is younger than
`SafetyLimits.feedback_age`. The twin homes at it; at 26 ms the watch of exchanged feedback trips, which compares the
reported torques with those commanded in the period before."""

_RELAY = "relay:/dev/ttyUSB1, a relay on a serial port"


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class MotorSetup:
    """The motors, in the order of the design's cables."""

    family: str
    """gm6020 or sts."""
    ids: tuple[int, ...]
    """Id of each cable's motor; 1 to 7 for gm6020, 0 to 252 for sts, no two alike."""
    directions: tuple[int, ...] | None = None
    """1 where the motor's positive sense winds the cable in, -1 where it pays it out; 1 for all by default."""
    model: str = "sts3215-12v"
    """Model of sts servos."""
    period: float | None = None
    """Period of control [s]; None for 2 ms with gm6020 and the data sheet's 10 ms with sts."""

    feedback_period: float | None = None
    """Longest time between two frames of a motor that reach the computer, where a board thins them out [s]; None for
    the data sheet's. The watch of lost frames expects as many, and hears of an outage later."""

    def __post_init__(self) -> None:
        _check_choice("motors.family", self.family, FAMILIES)
        _check_choice("motors.model", self.model, tuple(MODELS))
        check_type("motors.ids", self.ids, tuple)
        if self.family == "gm6020":
            try:
                check_motor_ids(self.ids)
            except DriveError:
                raise _refuse_ids(self.ids, 7, least=1) from None
        elif not self.ids or len(set(self.ids)) < len(self.ids) or not all(0 <= i <= ID_MAX for i in self.ids):
            raise _refuse_ids(self.ids, ID_MAX, least=0)
        if self.directions is not None and (
            len(self.directions) != len(self.ids) or not set(self.directions) <= {-1, 1}
        ):
            got = Unquoted(str(list(self.directions)))
            raise DesignError("motors.directions", got=got, allowed=f"{len(self.ids)} numbers, each 1 or -1")
        if self.period is not None:
            most = math.inf if self.family == "gm6020" else STS_PERIOD_MOST  # Rotor and cable limit that of gm6020.
            check_number("motors.period", self.period, least=self.data_sheet.period, most=most, below=math.inf)
        if self.feedback_period is not None:
            if (least := self.data_sheet.feedback_period) is None:
                allowed = f"none: motors of the family {self.family} are asked for their feedback"
                raise DesignError("motors.feedback_period", got=self.feedback_period, allowed=allowed)
            check_number("motors.feedback_period", self.feedback_period, least=least, most=0.01)

    @property
    def data_sheet(self) -> MotorDataSheet:
        """Limits of the motors that nothing raises."""
        return GM6020 if self.family == "gm6020" else MODELS[self.model].data_sheet

    @property
    def voltage_range(self) -> tuple[float, float] | None:
        """Least and largest supply [V]; None for motors that do not measure it."""
        return None if self.family == "gm6020" else MODELS[self.model].voltage_range

    @property
    def signs(self) -> tuple[int, ...]:
        """Direction of each motor."""
        return (1,) * len(self.ids) if self.directions is None else self.directions


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class RobotFile:
    """How one robot is wired."""

    name: str
    """Name of the robot."""
    bus: str
    """Bus of the motors, such as socketcan:can0, board:/dev/ttyACM0 or sts:/dev/ttyUSB0; opened by --bus robot."""
    motors: MotorSetup
    """The motors."""
    watchdog: str = "none"
    """What ends the torque when the computer dies: board, relay:PORT or none. Without one the robot is not armed."""
    arm: str = "none"
    """The arm: none, panda:HOST or franky:HOST."""
    cables: CableSetup = field(default_factory=CableSetup)
    """The cables."""
    load_cells: LoadCellSetup | None = None
    """Load cells at the cables; None for what the motors tell of the tension."""
    servo: ServoCalibration | None = None
    """Pulses of the gripper's servo, measured; None without a gripper."""

    def __post_init__(self) -> None:
        check_text("name", self.name)
        kind = _read_bus(self.bus)
        if (kind is BusKind.STS) != (self.motors.family == "sts"):
            allowed = "sts:PORT" if self.motors.family == "sts" else "a CAN adapter or board:PORT"
            raise DesignError("bus", got=self.bus, allowed=f"{allowed} for motors of the family {self.motors.family}")
        self._check_watchdog(kind)
        check_arm(self.arm)
        if self.servo is not None and kind is not BusKind.BOARD:
            raise DesignError("servo", got=Unquoted(f"there with bus {self.bus}"), allowed="only with board:PORT")
        self._check_load_cells()
        if self.cables.slack and len(self.cables.slack) != len(self.motors.ids):
            got = Unquoted(f"{len(self.cables.slack)} numbers")
            raise DesignError("cables.slack", got=got, allowed=f"{len(self.motors.ids)}, one for each motor")

    def _check_load_cells(self) -> None:
        cells = self.load_cells
        if cells is None:
            return
        if max(cells.cables) > len(self.motors.ids):
            got = Unquoted(str(list(cells.cables)))
            raise DesignError("load_cells.cables", got=got, allowed=f"1 to {len(self.motors.ids)}, the motors' cables")
        if cells.port in (self.relay, parse_bus_address(self.bus).port):
            allowed = "a port of its own, neither the bus's nor the relay's"
            raise DesignError("load_cells.port", got=cells.port, allowed=allowed)

    def _check_watchdog(self, kind: BusKind) -> None:
        if self.watchdog == "board" and kind is BusKind.STS:
            allowed = "relay:PORT or none: no board stands between computer and STS servos"
            raise DesignError("watchdog", got=self.watchdog, allowed=allowed)
        if self.watchdog == "board" and kind is BusKind.CAN and self.bus.partition(":")[0] in ADAPTERS:
            allowed = f"relay:PORT or none with bus {self.bus}: no board stands behind an adapter"
            raise DesignError("watchdog", got=self.watchdog, allowed=allowed)
        if self.relay is None and self.watchdog not in ("board", "none"):
            raise DesignError("watchdog", got=self.watchdog, allowed=f"board, none, or {_RELAY}")

    @property
    def relay(self) -> str | None:
        """Serial port of the relay; None without one."""
        name, colon, port = self.watchdog.partition(":")
        if name != "relay" or not colon:
            return None
        try:
            return check_port(self.watchdog, port, _RELAY)
        except DriveError:
            raise DesignError("watchdog", got=self.watchdog, allowed=_RELAY) from None


_COUNTS, _NUMBERS, _TEXT = Kind.COUNTS, Kind.NUMBERS, Kind.TEXT

TABLES: dict[str, tuple[Key, ...]] = {
    "": tuple(Key(name, RobotFile, name, kind=_TEXT) for name in ("name", "bus", "watchdog", "arm")),
    "motors": (
        Key("family", MotorSetup, "family", kind=_TEXT),
        Key("ids", MotorSetup, "ids", kind=_COUNTS),
        Key("directions", MotorSetup, "directions", kind=_COUNTS),
        Key("model", MotorSetup, "model", kind=_TEXT),
        Key("period_ms", MotorSetup, "period", MILLI),
        Key("feedback_ms", MotorSetup, "feedback_period", MILLI),
    ),
    "cables": (
        Key("tension_floor_n", CableSetup, "tension_floor"),
        Key("tension_max_n", CableSetup, "tension_max"),
        Key("speed_max_mm_s", CableSetup, "speed_max", MILLI),
        Key("stiffness_n_mm", CableSetup, "stiffness", _KILO),
        Key("slack_mm", CableSetup, "slack", MILLI, _NUMBERS),
    ),
    "load_cells": (
        Key("port", LoadCellSetup, "port", kind=_TEXT),
        Key("cables", LoadCellSetup, "cables", kind=_COUNTS),
        Key("offsets_n", LoadCellSetup, "offsets", kind=_NUMBERS),
        Key("scales", LoadCellSetup, "scales", kind=_NUMBERS),
    ),
    "servo": tuple(
        Key(name, ServoCalibration, name) for name in ("least_us", "most_us", "open_us", "slack_us", "closed_us")
    ),
}
"""Every key of a robot file by table."""

EXAMPLE = """\
schema = 1
name = "bench"
bus = "board:/dev/ttyACM0"      # opened only by --bus robot
watchdog = "board"              # board, relay:PORT or none
arm = "panda:192.168.1.2"       # none, panda:HOST or franky:HOST

[motors]
family = "gm6020"               # gm6020 or sts
ids = [1, 2, 3]
directions = [1, 1, -1]         # -1: the motor's positive sense pays the cable out

[cables]
tension_max_n = 30.0            # lower than the design's
speed_max_mm_s = 100.0
slack_mm = [2.0, 1.5, 1.5]      # of the fully wrapped trunk

[load_cells]                    # where the motors tell too little of the tension
port = "/dev/ttyACM1"           # opened only by --bus robot
cables = [1, 2, 3]              # of each cell, in the order of the board's frame
offsets_n = [0.4, -0.1, 0.0]    # read with slack cables
scales = [1.0, 1.0, -1.0]       # -1: mounted the other way round

[servo]                         # measured with its cables on
least_us = 900.0
most_us = 2100.0
open_us = 1000.0
slack_us = 1500.0
closed_us = 2000.0
"""
"""A robot file with every table, to begin with."""


def load_robot_file(path: str | Path, design: TrunkDesign | None = None) -> RobotFile:
    """The robot of that TOML file; where its ``design`` is given, with one motor for each of its cables.

    Raises:
        DesignError: for a file that cannot be read, is not TOML, or says what cannot be; it names the key.
    """
    check_type("robot", path, (str, Path))
    place = Path(path)
    try:
        check_regular(place)
        with place.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
        return parse_robot_file(data, source=str(path), design=design)
    except DesignError:
        raise
    except (OSError, ValueError) as error:
        reason = " ".join(str(getattr(error, "strerror", None) or error).split())[:200]
        raise DesignError("robot", got=str(path), allowed=f"a robot file in TOML; {reason}") from error


def parse_robot_file(data: bytes, *, source: str, design: TrunkDesign | None = None) -> RobotFile:
    """`load_robot_file` from bytes, which errors call ``source``.

    Raises:
        ValueError: where they are no TOML.
        DesignError: where they say what cannot be.
    """
    document = parse_toml(data)
    try:
        return _assemble(document, design)
    except DesignError as error:
        raise _as_typed(error, source) from None


def _assemble(document: dict[str, Any], design: TrunkDesign | None) -> RobotFile:
    parts = [table for table in TABLES if table]
    top = {name: value for name, value in document.items() if name not in parts}
    values = read_table("", top, TABLES[""], ["schema", *(f"[{part}]" for part in parts)])
    if "motors" not in document:
        raise DesignError("motors", got=Unquoted("missing"), allowed="a table with family and ids")
    for part in parts:
        if part in document:
            keys = TABLES[part]
            fields = read_table(part, document[part], keys)
            if part == "motors" and design is not None:  # First: other arrays are as long as that of the ids.
                check_motor_count(fields["ids"], design)
            values[part] = keys[0].owner(**fields)
    return RobotFile(**values)


def _as_typed(error: DesignError, source: str) -> DesignError:
    """The error with the file, and in its key and unit where it is about a field in SI."""
    name, bracket, index = error.name.partition("[")
    for table, keys in TABLES.items():
        for key in keys:
            if table and name == f"{table}.{key.field}":
                got = error.got
                if isinstance(got, (float, int)):
                    got = Unquoted(f"{float(got) / float(key.unit):g}")
                error = convert_error(error, f"{table}.{key.name}{bracket}{index}", key.unit, got)
    return DesignError(error.name, got=error.got, allowed=error.allowed, file=source)


def check_motor_count(ids: Sequence[int], design: TrunkDesign) -> None:
    """Refuse another number of motors than the design has cables.

    Raises:
        DesignError: with both numbers.
    """
    if len(ids) != design.n_cable:
        allowed = f"{design.n_cable}, one for each cable of {design.name}"
        raise DesignError("motors.ids", got=Unquoted(f"{len(ids)} ids"), allowed=allowed)


def check_arm(arm: str) -> tuple[str, str] | None:
    """Driver and host of an arm; None without one. Nothing is opened.

    Raises:
        DesignError: with what is allowed.
    """
    name, _, host = arm.partition(":")
    if arm == "none":
        return None
    is_host = 0 < len(host) <= 253 and host.isascii() and not any(sign.isspace() or sign in "/@" for sign in host)
    if name not in ARMS or not (is_host and host.isprintable()):
        raise DesignError("arm", got=arm, allowed="none, panda:HOST or franky:HOST, such as panda:192.168.1.2")
    return name, host


def _read_bus(text: str) -> BusKind:
    try:
        return parse_bus_address(text).kind
    except DriveError as error:
        raise DesignError("bus", got=text, allowed=str(error).partition("allowed: ")[2]) from None


def _check_choice(name: str, value: str, choices: tuple[str, ...]) -> None:
    if value not in choices:
        raise DesignError(name, got=value, allowed=" or ".join(choices))


def _refuse_ids(ids: tuple[int, ...], most: int, *, least: int) -> DesignError:
    allowed = f"one whole number from {least} to {most} for each cable, no two alike"
    return DesignError("motors.ids", got=Unquoted(str(list(ids))[:80]), allowed=allowed)
