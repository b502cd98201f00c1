"""How the twin is wired: as a robot file says, as far as motors of the twin's family can be."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.hardware.motors.load_cell import LoadCellSettings
from spiraltrunk.hardware.setup.cable_setup import CableSetup
from spiraltrunk.hardware.setup.robot_file import MotorSetup, RobotFile
from spiraltrunk.hardware.setup.robot_limits import build_winders, choose_period
from spiraltrunk.hardware.winder.winder import Winder

_BUS = "virtual:twin"


@final
@dataclass(frozen=True, kw_only=True)
class TwinWiring:
    """Motors, winders and cables of a twin; the twin's motors are GM6020."""

    motors: MotorSetup
    """Ids, directions and periods."""
    cables: CableSetup
    """Limits and slack."""
    load_cells: LoadCellSettings | None
    """Load cells; None without any."""
    winders: list[Winder]
    """One per cable, with the lowered limits."""
    period: float
    """Period of control [s]."""
    feedback_period: float
    """Time between two frames of a motor [s]."""


def build_wiring(design: TrunkDesign, file: RobotFile | None, *, period: float, feedback_period: float) -> TwinWiring:
    """The wiring of a file; without one, ids from 1 and the design's own limits.

    Of a file for servos its directions, cables and load cells are taken, not its ids and periods. What is at the other
    end of its bus, its watchdog, its arm and its gripper's pulses are the twin's own.

    Args:
        design: the robot.
        file: its robot file; None for none.
        period: period of control where the file has none [s].
        feedback_period: the same of the feedback [s].

    Raises:
        DesignError: where the file does not fit the design.
    """
    plain = MotorSetup(family="gm6020", ids=tuple(range(1, design.n_cable + 1)), period=period)
    if file is None:
        file = RobotFile(name="twin", bus=_BUS, motors=plain)
    else:
        build_winders(design, file)
        own = file.motors if file.motors.family == "gm6020" else replace(plain, directions=file.motors.directions)
        motors = replace(own, period=period) if own.period is None else own
        file = replace(file, bus=_BUS, watchdog="none", servo=None, motors=motors)
    return TwinWiring(
        motors=file.motors, cables=file.cables,
        load_cells=None if file.load_cells is None else file.load_cells.build_settings(design.n_cable),
        winders=build_winders(design, file),
        period=choose_period(file.motors), feedback_period=file.motors.feedback_period or feedback_period,
    )  # fmt: skip
