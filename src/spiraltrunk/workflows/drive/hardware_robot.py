"""The real robot: motors, gripper and arm of a robot file behind the driver. Never tried on a real device."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack, nullcontext
from dataclasses import replace
from typing import final

from spiraltrunk.control.messages import CameraObservation, Task
from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import RunError
from spiraltrunk.hardware.arm.arm_port import ArmPort
from spiraltrunk.hardware.arm.checks import ArmSettings
from spiraltrunk.hardware.arm.trunk_load import trunk_load
from spiraltrunk.hardware.bus.board import open_board
from spiraltrunk.hardware.bus.bus_address import BusKind, parse_bus_address
from spiraltrunk.hardware.bus.can_bus import open_can_bus
from spiraltrunk.hardware.bus.frame_bus import FrameBus
from spiraltrunk.hardware.clock import Clock, SystemClock
from spiraltrunk.hardware.driver.options import DriverOptions
from spiraltrunk.hardware.driver.relay_feeder import RelayFeeder
from spiraltrunk.hardware.driver.threaded_driver import SharedArm, ThreadedDriver
from spiraltrunk.hardware.driver.trunk_driver import TrunkDriver
from spiraltrunk.hardware.motors.gm6020 import compute_feedback_id
from spiraltrunk.hardware.motors.gm6020_motors import GM6020Motors
from spiraltrunk.hardware.motors.load_cell import LoadCells
from spiraltrunk.hardware.motors.motor_port import MotorPort
from spiraltrunk.hardware.motors.pwm_servo import PwmServo
from spiraltrunk.hardware.motors.servo_port import ServoPort
from spiraltrunk.hardware.motors.sts.servos import StsServos, StsSettings
from spiraltrunk.hardware.plant import HardwarePlant, Reach
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.safety.watchdog import (
    ANSWER_ID,
    BoardWatchdog,
    NoWatchdog,
    RelayWatchdog,
    Watchdog,
    WatchedBus,
)
from spiraltrunk.hardware.setup.relay import open_relay
from spiraltrunk.hardware.setup.robot_file import RobotFile, check_arm
from spiraltrunk.hardware.setup.robot_limits import build_winders, check_arm_model, choose_period, fit_watches
from spiraltrunk.sim.robot.arm import arm_limits, arm_payload
from spiraltrunk.workflows.drive.robot import Robot

ARMING_TIME = 10.0
"""Time after arming for which the floor of tension is held while a strategy plans [s] (ours)."""

BOOT_TIME = 1.0
"""Time for which a relay is fed before its motors are asked anything [s] (ours)."""


@final
class HardwareRobot(Robot):
    """Motors, gripper and arm on the ports that a robot file names; they are opened here, and nowhere else.

    Arm and load cells are opened first, and the arm is told its load. Then a relay closes the motors' supply, and is
    fed until the driver's loop does so.

    Args:
        design: the robot's design.
        file: how it is wired.
        without_watchdog: whether it may be armed without a watchdog.
        clock: time; the computer's by default, with the loop in a thread. With another one, such as a `TwinClock`, the
            caller's thread runs the loop.
        arm: used instead of the file's arm, such as a simulated one.

    Raises:
        DesignError: where the file does not fit the design, or its arm is another one; nothing is opened then.
        DriveError: where a port or an arm cannot be opened, or the arm refuses its load; all others are closed again.
        MissingPackage: without a package that it needs.
    """

    def __init__(
        self,
        design: TrunkDesign,
        file: RobotFile,
        *,
        without_watchdog: bool = False,
        clock: Clock | None = None,
        arm: ArmPort | None = None,
    ) -> None:
        self.design, self.file = design, file
        self.clock = SystemClock() if clock is None else clock
        self.slack = file.cables.slack
        if arm is None:
            check_arm_model(file, design)
        winders = build_winders(design, file)
        options = DriverOptions(
            period=choose_period(file.motors), without_watchdog=without_watchdog, arming_time=ARMING_TIME,
            limits=fit_watches(SafetyLimits(), file.cables, file.motors),
        )  # fmt: skip
        if file.servo is not None:
            options = replace(options, gripper=file.servo)
        with ExitStack() as opening:
            self.arm = self._open_arm() if arm is None else arm
            if self.arm is not None:
                opening.callback(self.arm.close)
                self.arm.set_load(trunk_load(design))  # Before the loop, which then asks the arm from its own thread.
            cells = self._open_cells(opening)
            relay = self._open_relay(opening)
            feeding: AbstractContextManager[object] = nullcontext() if relay is None else RelayFeeder(relay)
            with feeding:
                motors, servo, watchdog = self._open_motors(opening, relay)
                driver = TrunkDriver(
                    design=design,
                    motors=motors, winders=winders, watchdog=watchdog,
                    clock=self.clock, servo=servo, arm=self.arm, load_cells=cells, options=options,
                )  # fmt: skip
            self.driver = ThreadedDriver(driver) if clock is None else driver
            self._ports = opening.pop_all()

    def _open_relay(self, opening: ExitStack) -> RelayWatchdog | None:
        """The relay of the file; None without one."""
        if self.file.relay is None:
            return None
        port = open_relay(self.file.relay)
        opening.callback(port.close)
        return RelayWatchdog(port)

    def _open_motors(
        self, opening: ExitStack, relay: RelayWatchdog | None
    ) -> tuple[MotorPort, ServoPort | None, Watchdog]:
        """Motors, servo and watchdog; what was opened is closed by the stack, too."""
        file, address = self.file, parse_bus_address(self.file.bus)
        setup = file.motors
        motors: MotorPort
        servo: ServoPort | None = None
        bus: WatchedBus | None = None
        if relay is not None:
            self.clock.sleep_until(self.clock.now() + BOOT_TIME)
        if address.kind is BusKind.STS:
            settings = StsSettings(port=address.port, servo_ids=setup.ids, directions=setup.signs, model=setup.model)
            motors = StsServos.from_settings(settings, self.clock)
        else:
            bus, servo = self._open_bus(address.kind, address.port)
            motors = GM6020Motors(bus, motor_ids=setup.ids, directions=setup.signs)
            if setup.feedback_period is not None:
                motors.data_sheet = replace(motors.data_sheet, feedback_period=setup.feedback_period)
        opening.callback(motors.close)
        if relay is not None:
            return motors, servo, relay
        if file.watchdog == "board" and bus is not None:
            return motors, servo, BoardWatchdog(bus, self.clock)
        return motors, servo, NoWatchdog()

    def _open_bus(self, kind: BusKind, port: str) -> tuple[WatchedBus, ServoPort | None]:
        """The bus of the motors, and the servo behind a board."""
        bus: FrameBus
        if kind is BusKind.BOARD:
            bus = board = open_board(port, self.clock)
            return WatchedBus(bus), None if self.file.servo is None else PwmServo(board, self.file.servo)
        ids = [*map(compute_feedback_id, self.file.motors.ids), ANSWER_ID]
        bus = open_can_bus(self.file.bus, self.clock, feedback_ids=ids)
        return WatchedBus(bus), None

    def _open_cells(self, opening: ExitStack) -> LoadCells | None:
        """The load cells of the file; None without any."""
        if self.file.load_cells is None:
            return None
        cells = LoadCells.from_settings(self.file.load_cells.build_settings(self.design.n_cable), self.clock)
        opening.callback(cells.close)
        return cells

    def _open_arm(self) -> ArmPort | None:
        """The arm of the file; None without one."""
        named = check_arm(self.file.arm)
        if named is None:
            return None
        name, host = named
        settings = ArmSettings(
            limits=arm_limits(self.design.arm), payload=arm_payload(self.design.arm), period=CONTROL_PERIOD
        )
        if name == "panda":
            from spiraltrunk.hardware.arm.panda_arm import PandaArm

            return PandaArm(host, settings, self.clock)
        from spiraltrunk.hardware.arm.franky_arm import FrankyArm

        return FrankyArm(host, settings, self.clock)

    def build_plant(
        self, task: Task, reach: Reach, camera: Callable[[], CameraObservation | None] | None = None
    ) -> HardwarePlant:
        """The plant of a strategy; the package has no driver of a camera, so that one is given where there is one.

        Raises:
            RunError: without an arm.
        """
        if self.arm is None:
            raise RunError('the robot file names no arm; allowed: arm = "panda:HOST" or "franky:HOST"')
        arm = SharedArm(self.arm, self.driver) if isinstance(self.driver, ThreadedDriver) else self.arm
        return HardwarePlant(self.driver, arm, reach, task, camera=camera, slack=self.slack)

    def close(self) -> None:
        """See `Robot.close`; all ports are closed, whatever happens."""
        try:
            super().close()
        finally:
            self._ports.close()
