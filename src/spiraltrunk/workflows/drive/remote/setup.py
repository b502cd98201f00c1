"""What robot a process drives."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

from spiraltrunk.checks import check_number
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.setup.robot_file import RobotFile
from spiraltrunk.workflows.drive.hardware_robot import HardwareRobot
from spiraltrunk.workflows.drive.remote.service import PATIENCE
from spiraltrunk.workflows.drive.robot import Robot
from spiraltrunk.workflows.drive.twin.twin_robot import TwinOptions, TwinRobot


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class RobotSetup:
    """A robot for a process of its own."""

    design: TrunkDesign
    """Its design."""
    file: RobotFile | None = None
    """How it is wired; None for the twin. Its arm is left alone."""
    without_watchdog: bool = False
    """Whether it may be armed although nothing ends the torque when the computer dies."""
    seed: int = 0
    """Seed of the twin."""
    patience: float = PATIENCE
    """Time after which a page that does not answer counts as gone [s]."""
    pace: float = 1.0
    """Simulated time of the twin over the computer's, as far as the computer is fast enough [-]."""

    def __post_init__(self) -> None:
        check_number("patience", self.patience, least=0.1, most=60.0)
        check_number("pace", self.pace, least=0.01, most=100.0)

    @property
    def name(self) -> str:
        """What people call it."""
        return "twin" if self.file is None else f"{self.file.name} on {self.file.bus}"

    @property
    def has_board(self) -> bool:
        """Whether a board's watchdog is between bus and motors."""
        return self.file is None or (self.file.watchdog == "board" and not self.without_watchdog)

    def build(self) -> Robot:
        """Build it, and open its ports.

        Raises:
            DesignError: where the file does not fit the design.
            DriveError: where a port cannot be opened.
        """
        if self.file is None:
            return TwinRobot(self.design, options=TwinOptions(seed=self.seed))
        return HardwareRobot(self.design, replace(self.file, arm="none"), without_watchdog=self.without_watchdog)
