"""Winders of a robot file: limits of design, drum and the motor's data sheet, lowered where the file says so."""

from __future__ import annotations

from dataclasses import replace

from spiraltrunk.design.drum import size_drum
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, Unquoted, describe
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.setup.cable_setup import CableSetup
from spiraltrunk.hardware.setup.robot_file import (
    MotorSetup,
    RobotFile,
    check_arm,
    check_motor_count,
    load_robot_file,
)
from spiraltrunk.hardware.winder.drum import DrumGeometry
from spiraltrunk.hardware.winder.gains import CABLE_STIFFNESS
from spiraltrunk.hardware.winder.limits import WinderLimits
from spiraltrunk.hardware.winder.winder import Winder, build_winder

PERIOD = 0.002
"""Period of control of motors that allow it [s]: 500 Hz."""

_KEYS = {"winder.period": "motors.period_ms", "winder.tension_floor": "cables.tension_floor_n"}
"""Keys of a robot file, by the fields of a winder that they set."""

DRIVEN_ARMS = {"panda": "panda", "franky": "fr3"}
"""The ``arm.model`` that each driver of arms drives: the libfranka of panda-python's wheel speaks to a Panda, that of
franky-control's to an FR3."""


def choose_period(motors: MotorSetup) -> float:
    """Period of control [s]: that of the file, else `PERIOD`, or the data sheet's where it is longer."""
    return max(PERIOD, motors.data_sheet.period) if motors.period is None else motors.period


def choose_stiffness(cables: CableSetup) -> float:
    """Stiffness of a cable with its winder [N/m]: that of the file, else `CABLE_STIFFNESS`."""
    return CABLE_STIFFNESS if cables.stiffness is None else cables.stiffness


def fit_watches(limits: SafetyLimits, cables: CableSetup, motors: MotorSetup | None = None) -> SafetyLimits:
    """The watches' limits for cables of that stiffness, and for the supply of motors that measure it."""
    if motors is not None and motors.voltage_range is not None:
        least, most = motors.voltage_range
        limits = replace(limits, voltage_least=least, voltage_most=most)
    return limits if cables.stiffness is None else replace(limits, compliance=1.0 / cables.stiffness)


def build_winders(design: TrunkDesign, file: RobotFile) -> list[Winder]:
    """One winder per cable of the design.

    Raises:
        DesignError: where the file has another number of motors than the design has cables, or a limit that is none.
    """
    check_motor_count(file.motors.ids, design)
    drum = DrumGeometry(design=size_drum(design))
    try:
        winder = build_winder(
            design, file.motors.data_sheet, drum, choose_period(file.motors),
            stiffness=choose_stiffness(file.cables), tension_floor=file.cables.tension_floor,
        )  # fmt: skip
    except DesignError as error:
        raise DesignError(_KEYS.get(error.name, error.name), got=error.got, allowed=error.allowed) from None
    return [replace(winder, limits=lower_limits(winder.limits, file.cables))] * design.n_cable


def load_fitting_file(path: str, design: TrunkDesign) -> RobotFile:
    """A robot file that fits the design; nothing is opened.

    Raises:
        DesignError: where it cannot be read, or does not fit.
    """
    file = load_robot_file(path, design)
    try:
        build_winders(design, file)
    except DesignError as error:
        raise DesignError(error.name, got=error.got, allowed=error.allowed, file=path) from None
    return file


def check_arm_model(file: RobotFile, design: TrunkDesign) -> None:
    """Refuse a driver of another arm than the design's, whose limits it would be checked against.

    An arm of a user's MJCF file has no driver: the file tells no speed limits, and no driver says whose arm it is.

    Raises:
        DesignError: with the arm of both, and what is allowed.
    """
    named = check_arm(file.arm)
    if named is None or DRIVEN_ARMS[named[0]] == design.arm.model:
        return
    fitting = [f"{name}:HOST" for name, model in DRIVEN_ARMS.items() if model == design.arm.model]
    pairs = ", ".join(f'{name} drives a "{model}"' for name, model in DRIVEN_ARMS.items())
    allowed = (
        f"{' or '.join([*fitting, 'none'])}, as the design's arm.model is {describe(design.arm.model)} ({pairs}): "
        "correct the one that does not name the arm that is connected"
    )
    raise DesignError("arm", got=file.arm, allowed=allowed)


def lower_limits(limits: WinderLimits, cables: CableSetup) -> WinderLimits:
    """The limits with those of a file, none of which may be above them.

    Raises:
        DesignError: for a limit of the file that is higher, or a largest tension below twice the floor.
    """
    ceiling, speed = limits.tension_ceiling, limits.speed_max
    if cables.tension_max is not None:
        least = 2 * limits.tension_floor
        _check("cables.tension_max_n", cables.tension_max, least, ceiling, 1.0)
        ceiling = cables.tension_max
    if cables.speed_max is not None:
        _check("cables.speed_max_mm_s", cables.speed_max, 1e-3, speed, 1e3)
        speed = cables.speed_max
    return replace(limits, tension_ceiling=ceiling, speed_max=speed)


def _check(name: str, value: float, least: float, most: float, scale: float) -> None:
    if not least <= value <= most:
        allowed = (
            f"{scale * least:g} to {scale * most:.4g}, the limit of design, drum and motor: it can only be lowered"
        )
        raise DesignError(name, got=Unquoted(f"{scale * value:g}"), allowed=allowed)
