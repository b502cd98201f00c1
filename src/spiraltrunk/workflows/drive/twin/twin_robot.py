"""The whole robot as a twin: simulated trunk, arm and gripper, behind motors, bus, watchdog and the real driver."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import final

import numpy as np

from spiraltrunk.control.messages import CameraObservation
from spiraltrunk.design.drum import size_drum
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import RunError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.arm.trunk_load import trunk_load
from spiraltrunk.hardware.clock import SystemClock
from spiraltrunk.hardware.driver.options import DriverOptions
from spiraltrunk.hardware.driver.snapshot import Snapshot
from spiraltrunk.hardware.driver.threaded_driver import SharedArm, ThreadedDriver
from spiraltrunk.hardware.driver.trunk_driver import TrunkDriver
from spiraltrunk.hardware.motors.gm6020_motors import GM6020Motors
from spiraltrunk.hardware.motors.load_cell import LoadCells
from spiraltrunk.hardware.plant import HardwarePlant
from spiraltrunk.hardware.safety.watchdog import BoardWatchdog, WatchedBus
from spiraltrunk.hardware.setup.robot_file import RobotFile
from spiraltrunk.hardware.setup.robot_limits import choose_stiffness, fit_watches
from spiraltrunk.hardware.twin.assembly import AssemblyOptions, build_twin
from spiraltrunk.hardware.twin.cable_load import CableLoad
from spiraltrunk.hardware.twin.clock import RealTimeTwin, TwinClock
from spiraltrunk.hardware.twin.device import TwinDevice
from spiraltrunk.hardware.twin.motor import MotorParameters
from spiraltrunk.hardware.twin.trunk.curl_shape import CurlShape
from spiraltrunk.hardware.twin.trunk.slack_load import SlackLoad
from spiraltrunk.hardware.twin.trunk.spring_trunk import SpringTrunk
from spiraltrunk.sim.machine import SimMachine
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.workflows.drive.robot import Robot
from spiraltrunk.workflows.drive.twin.machine_arm import MachineArm
from spiraltrunk.workflows.drive.twin.machine_load import MachineLoad
from spiraltrunk.workflows.drive.twin.machine_servo import MachineServo
from spiraltrunk.workflows.drive.twin.wiring import build_wiring

SLACK_MOST = 0.010
"""Most slack of a cable before homing [m] (ours): a trunk that was just threaded."""

PLANNING_TIME = 10.0
"""Time after arming for which the floor of tension is held in real time, while a strategy plans [s] (ours)."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class TwinOptions:
    """How the twin differs from the ideal; everything that is drawn follows from the seed."""

    seed: int = 0
    """Seed of slack, encoder angles and faults."""
    feedback_period: float = 1e-3
    """Time between two answers of a motor [s]."""
    driver: DriverOptions = field(default_factory=DriverOptions)
    """Settings of the driver."""
    has_board: bool = True
    """Whether the board's watchdog is between bus and motors."""
    file: RobotFile | None = None
    """Robot file whose ids, directions, periods, limits, slack and load cells the twin has; None for none."""
    is_real_time: bool = False
    """Whether twin and driver follow the computer's clock, each in its thread; no run is like another then."""


@final
class TwinRobot(Robot):
    """A twin with its driver, in simulated time or by the computer's clock.

    Args:
        design: the robot.
        scene: the scene of a trial, simulated in MuJoCo with time steps of 1 ms; None for motors alone, on a trunk of
            two degrees of freedom.
        options: how the twin differs from the ideal.

    Raises:
        DesignError: where drum, winder or scene cannot be built, or the robot file does not fit.
    """

    def __init__(
        self, design: TrunkDesign, scene: SceneOptions | None = None, options: TwinOptions | None = None
    ) -> None:
        self.design, self._lock = design, threading.RLock()
        self.options = options = TwinOptions() if options is None else options
        self.clock = clock = SystemClock() if options.is_real_time else TwinClock()
        self.wiring = build_wiring(
            design, options.file, period=options.driver.period, feedback_period=options.feedback_period
        )
        """Motors, winders and cables."""
        self.slack = self.wiring.cables.slack
        self.machine = None if scene is None else SimMachine(design, scene)
        self._load: CableLoad
        if self.machine is None:
            self._load = SpringTrunk(design)
        else:
            self.machine.restore()
            self._load = MachineLoad(self.machine)
        self.servo = None if self.machine is None else MachineServo(self.machine)
        self.arm = None if self.machine is None else MachineArm(self.machine, self.clock, self._lock)
        twin = build_twin(
            design, self._assemble(), clock=clock,
            load=SlackLoad(self._load, self.slack, design.cable_stroke) if self.slack else self._load,
            beside=[device for device in (self.servo, self.arm) if device is not None],
            load_cells=self.wiring.load_cells,
        )  # fmt: skip
        self.motors = twin.motors
        self.faults = twin.injector
        """Lets faults begin and end."""
        driver = self._build_driver(WatchedBus(twin.bus))
        self._twin: RealTimeTwin | None = None
        if options.is_real_time:
            self._twin = RealTimeTwin(_Locked(self._lock, twin.devices))
            self._twin.start()
        self.driver = ThreadedDriver(driver) if options.is_real_time else driver

    def _assemble(self) -> AssemblyOptions:
        """Motors whose drums have some slack, and whose encoders stand anywhere; faults of the bus at their end."""
        options, wiring, radius = self.options, self.wiring, size_drum(self.design).winding_radius
        rng = np.random.default_rng(options.seed)
        slack = rng.uniform(0.2, 1.0, self.design.n_cable) * SLACK_MOST
        starts = rng.integers(0, MotorParameters().encoder_counts, self.design.n_cable)
        motors = [
            MotorParameters(
                drum_radius=radius,
                wound=-float(loose),
                encoder_start=int(start),
                is_reversed=sign < 0,
                cable_stiffness=choose_stiffness(wiring.cables),
            )
            for loose, start, sign in zip(slack, starts, wiring.motors.signs, strict=True)
        ]
        return AssemblyOptions(
            motor=motors, motor_ids=wiring.motors.ids, feedback_period=wiring.feedback_period,
            is_watched=options.has_board,
            fails_at_driver=False, seed=options.seed,
        )  # fmt: skip

    def _build_driver(self, bus: WatchedBus) -> TrunkDriver:
        wiring, setup = self.wiring, self.wiring.motors
        limits = fit_watches(self.options.driver.limits, wiring.cables)
        options = replace(self.options.driver, period=wiring.period, limits=limits)
        if self.options.is_real_time:
            options = replace(options, arming_time=PLANNING_TIME)
        motors = GM6020Motors(bus, motor_ids=setup.ids, directions=setup.signs)
        motors.data_sheet = replace(motors.data_sheet, feedback_period=wiring.feedback_period)
        return TrunkDriver(
            design=self.design, motors=motors, winders=wiring.winders,
            watchdog=BoardWatchdog(bus, self.clock), clock=self.clock,
            servo=self.servo, arm=self.arm, load_cells=self._open_cells(), options=options,
        )  # fmt: skip

    def _open_cells(self) -> LoadCells | None:
        """The reader of the twin's load cells; None without any."""
        settings, stream = self.wiring.load_cells, self.motors.cells
        return None if settings is None or stream is None else LoadCells(settings, stream, self.clock)

    def prepare(self) -> None:
        """See `Robot.prepare`; the load of the arm is set before."""
        if self.arm is not None and self.arm.load is None:
            self.arm.set_load(trunk_load(self.design))
        super().prepare()

    def build_plant(self) -> HardwarePlant:
        """The plant of a strategy, armed; the scene's time begins with its reset.

        Raises:
            RunError: without a scene.
        """
        if self.machine is None:
            raise RunError("the twin has no scene; allowed: one that was built with a scene")
        assert isinstance(self._load, MachineLoad)
        assert self.arm is not None
        with self._lock:
            self._load.begin()
        arm = SharedArm(self.arm, self.driver) if isinstance(self.driver, ThreadedDriver) else self.arm
        reach, task = self.machine.reach, self.machine.task
        return HardwarePlant(self.driver, arm, reach, task, camera=self._read_camera, slack=self.slack)

    def read_torques(self) -> tuple[float, ...]:
        """True electric torque of each motor [N m]."""
        with self._lock:
            return tuple(motor.torque for motor in self.motors.motors)

    def read_frames(self) -> np.ndarray:
        """True frames of the trunk's sections in that of the first one, shape (n_section, 4, 4) [-, m]."""
        with self._lock:
            if self.machine is not None:
                return self.machine.read_section_frames()
            assert isinstance(self._load, SpringTrunk)
            return self._shape.compute_frames(self._load.curl)

    @cached_property
    def _shape(self) -> CurlShape:
        return CurlShape(self.design)

    def _read_camera(self) -> CameraObservation | None:
        assert self.machine is not None
        with self._lock:
            return self.machine.read_camera()

    def finish(self) -> Snapshot:
        """See `Robot.finish`; the ground truth of a scene ends before it lets go."""
        if isinstance(self._load, MachineLoad):
            with self._lock:
                self._load.end()
        return super().finish()

    def close(self) -> None:
        """See `Robot.close`; the twin's thread ends after the driver's.

        Raises:
            RunError: where the simulation diverged.
        """
        try:
            super().close()
        finally:
            if self._twin is not None:
                self._twin.stop()


@final
class _Locked(TwinDevice):
    """Devices that are advanced under a lock, because other threads read them."""

    def __init__(self, lock: AbstractContextManager[object], devices: Sequence[TwinDevice]) -> None:
        self._lock, self._devices = lock, tuple(devices)

    def advance(self, dt: float) -> None:
        """See `TwinDevice.advance`."""
        with self._lock:
            for device in self._devices:
                device.advance(dt)
