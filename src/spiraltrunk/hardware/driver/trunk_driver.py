"""Driver of a trunk: motors, gripper and arm behind one loop that keeps them safe.

Each `TrunkDriver.tick` reads the feedback, steps the winders, asks the watches, and sends torques or the reaction to a
fault, once in each period. It runs on one thread; nothing waits inside. Never tried on a real robot.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from types import TracebackType
from typing import final

from numpy.typing import ArrayLike

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.arm.arm_port import ArmPort
from spiraltrunk.hardware.clock import Clock
from spiraltrunk.hardware.driver.homing_routine import HomingRoutine, WinderHoming
from spiraltrunk.hardware.driver.lateness import Lateness, Schedule
from spiraltrunk.hardware.driver.loop import ControlLoop
from spiraltrunk.hardware.driver.options import DriverOptions
from spiraltrunk.hardware.driver.snapshot import CableSnapshot, Snapshot
from spiraltrunk.hardware.driver.targets import (
    Targets,
    read_arm_position,
    read_gripper,
    read_pull,
    read_tension,
    read_validity,
)
from spiraltrunk.hardware.motors.load_cell import LoadCells
from spiraltrunk.hardware.motors.motor_port import MotorPort
from spiraltrunk.hardware.motors.servo_port import ServoPort
from spiraltrunk.hardware.safety import states
from spiraltrunk.hardware.safety.fault import Fault, FaultKind
from spiraltrunk.hardware.safety.reading import CableReading
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.hardware.safety.watchdog import Watchdog
from spiraltrunk.hardware.winder.winder import Winder


@final
class TrunkDriver:
    """Motors, servo and arm of one trunk, in one of the modes of `safety.states`."""

    def __init__(
        self,
        *,
        design: TrunkDesign,
        motors: MotorPort,
        winders: Sequence[Winder],
        watchdog: Watchdog,
        clock: Clock,
        servo: ServoPort | None = None,
        arm: ArmPort | None = None,
        load_cells: LoadCells | None = None,
        homing: HomingRoutine | None = None,
        options: DriverOptions | None = None,
    ) -> None:
        """A driver in `Mode.SAFE`; nothing is sent before the first `tick`.

        Args:
            design: the trunk.
            motors: one motor per cable.
            winders: control of each.
            watchdog: what ends the torque when this program dies.
            clock: time.
            servo: the gripper's; None without one.
            arm: the arm; None without one.
            load_cells: what measures the tension of some cables or all; None for what the motors tell.
            homing: how the zeros of the drums are found, by the winders by default; each motor is probed before.
            options: settings.

        Raises:
            DriveError: where motors, winders and cables are not as many, or the period is below the motors' own.
        """
        options = options or DriverOptions()
        sheet = motors.data_sheet
        if not len(winders) == motors.n_motor == design.n_cable:
            given = f"{motors.n_motor} motors and {len(winders)} winders for {design.n_cable} cables"
            raise DriveError(f"{given}; allowed: one of each for a cable")
        if options.period < sheet.period:
            allowed = f"at least {1e3 * sheet.period:g} ms, that of the {sheet.name}'s bus"
            raise DriveError(f"the period of control is {1e3 * options.period:g} ms; allowed: {allowed}")
        self._loop = ControlLoop(
            design=design, motors=motors, winders=winders, homing=homing or WinderHoming(winders), watchdog=watchdog,
            clock=clock, servo=servo, arm=arm, load_cells=load_cells, options=options,
        )  # fmt: skip
        self._clock, self._arm_port, self._has_servo = clock, arm, servo is not None
        self._schedule = Schedule(options.period)
        self._n_refused = 0
        self._is_closed = False

    @property
    def clock(self) -> Clock:
        """Time of the driver."""
        return self._clock

    @property
    def mode(self) -> Mode:
        """What the driver does."""
        return self._loop.state.mode

    @property
    def is_homed(self) -> bool:
        """Whether the drums are homed, and no turn was missed and no fault left their zeros in doubt since."""
        return self._loop.state.is_homed

    @property
    def faults(self) -> tuple[Fault, ...]:
        """Latched faults, the first cause first."""
        return self._loop.state.faults

    def home(self) -> None:
        """Begin homing; `tick` carries it out and ends in `Mode.SAFE`, homed, or in a fault.

        Raises:
            DriveError: where torque must not be switched on now, with every reason.
        """
        self._loop.start_homing()

    def arm(self) -> None:
        """Switch torque on, with the floor of tension until targets come, for `DriverOptions.arming_time`.

        Raises:
            DriveError: where torque must not be switched on now, with every reason.
        """
        self._loop.start_control()

    def set_targets(
        self,
        tension: ArrayLike,
        pull: ArrayLike | None = None,
        *,
        arm_position: ArrayLike | None = None,
        gripper: ArrayLike = 0.0,
        valid_for: ArrayLike = 0.0,
    ) -> None:
        """Aim at these targets until the next ones.

        They must be renewed before `SafetyLimits.command_age` has passed after their validity; else the driver stops.
        Targets that are refused change nothing and renew nothing: those before them stay until they are too old.

        Args:
            tension: upper limit of each cable's tension, shape (n_cable,) [N].
            pull: upper limit of the cable wound in since the straight trunk, shape (n_cable,) [m]; infinity or None
                sets no limit.
            arm_position: joint positions of the arm, shape (n_arm,) [rad]; None leaves it where it is.
            gripper: from -1 (open) over 0 (slack) to 1 (closed) [-].
            valid_for: validity from now on [s].

        Raises:
            DriveError: where the driver is not armed, or a value is not finite, of another shape or out of its range.
        """
        loop = self._loop
        try:
            if loop.state.mode is not Mode.ARMED or loop.ramp is not None:
                raise DriveError(f"no targets are taken in {self._describe_mode()}; arm the driver first")
            loop.targets = Targets(
                tension=read_tension(tension, loop.winding.tension_most),
                pull=read_pull(pull, len(loop.sent)),
                arm_position=read_arm_position(arm_position, self._arm_port),
                gripper=read_gripper(gripper, has_servo=self._has_servo),
                expires=self._clock.now() + read_validity(valid_for, loop.options.validity_most),
            )
        except DriveError as error:
            self._n_refused += 1
            loop.refusal = str(error)
            raise
        loop.refusal = ""
        loop.has_new_position = loop.targets.arm_position is not None

    def _describe_mode(self) -> str:
        """The mode, with the first fault."""
        if not self.faults:
            return self.mode.value
        return f"{self.mode.value} ({self.faults[0].kind.value}: {self.faults[0].text})"

    def disarm(self) -> None:
        """Let the cables go within `reaction.LET_GO_TIME`, and then be safe; the arm holds.

        Raises:
            DriveError: where the driver is not armed.
        """
        self._loop.let_go()

    def stop(self) -> None:
        """Stop as on a fault, on a person's request; never refused."""
        now = self._clock.now()
        fault = Fault(kind=FaultKind.STOPPED, time=now, cable=None, text="a person stopped the robot")
        self._loop.latch((fault,), now)

    def clear_fault(self, person: str) -> None:
        """Go back to `Mode.SAFE`, by a person; a watchdog that has tripped lets torques through again.

        Raises:
            DriveError: where there is no fault and the watchdog has not tripped, ``person`` is no name, or the torque
                is not off yet.
        """
        loop = self._loop
        if self.mode is not Mode.SAFE or loop.watchdog.is_present():
            loop.state = states.clear(loop.state, person, is_released=loop.is_released(self._clock.now()))
            loop.ramp = None
        else:
            states.check_person(person)
        loop.watchdog.clear()

    def wait(self) -> None:
        """Sleep until the next `tick` is due."""
        if self._schedule.due > -math.inf:
            self._clock.sleep_until(self._schedule.due)

    def tick(self) -> None:
        """Advance by one period: read, control or react, feed the watchdog, send; never waits.

        Raises:
            DriveError: where the driver is closed.
        """
        if self._is_closed:
            raise DriveError("the driver is closed; make a new one")
        now = self._clock.now()
        self._schedule.begin(now)
        self._loop.run_period(now)

    def close(self) -> None:
        """Let go as on a fault where torque is on, then release servo, motors, arm and load cells, whatever fails.

        Harmless when called again. After a ramp that failed the watchdog is not told of an end in order.
        """
        if self._is_closed:
            return
        loop = self._loop
        with ExitStack() as closing:  # The last one first.
            for close in (loop.cells.close, loop.arm.close, loop.motors.close, loop.gripper.release):
                closing.callback(close)
            try:
                self._ramp_down()
            finally:
                self._is_closed = True
            if loop.is_feeding(self._clock.now()):
                with suppress(DriveError):  # Unheard, a board trips, as it does without.
                    loop.watchdog.end()

    def _ramp_down(self) -> None:
        """Let go as on a fault where torque is on, and wait until it is off."""
        if self._loop.state.has_torque:
            self.stop()
        while not self._loop.is_released(self._clock.now()):
            self.wait()
            self.tick()

    def __enter__(self) -> TrunkDriver:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def summarise_lateness(self) -> Lateness:
        """Lateness of the loop; takes about 0.5 ms, and may run beside the loop, which then adds one number at most."""
        return self._schedule.summarise()

    def snapshot(self, lateness: Lateness | None = None) -> Snapshot:
        """What logs and screens show now; ``lateness`` is what `summarise_lateness` told, None for asking it here."""
        loop, now = self._loop, self._clock.now()
        return Snapshot(
            time=now, mode=self.mode, is_homed=self.is_homed, is_letting_go=not loop.is_released(now),
            absence=loop.watchdog.find_absence(), faults=self.faults,
            warnings=loop.warnings,
            cables=tuple(self._show_cable(i, now) for i in range(len(loop.sent))), arm=loop.arm.state,
            gripper=loop.targets.gripper, n_refused=self._n_refused, loss=loop.seen.loss.loss,
            lateness=self.summarise_lateness() if lateness is None else lateness,
        )  # fmt: skip

    def _tell_tension(self, i: int, reading: CableReading | None) -> float:
        """Tension of one cable [N]; that of a load cell is told without torque, too."""
        felt = self._loop.cells.tensions[i]
        if felt is None:
            return reading.tension if reading else 0.0
        return max(felt, 0.0)

    def _show_cable(self, i: int, now: float) -> CableSnapshot:
        """What is shown of one cable; tension and speed are known while torque is on."""
        loop = self._loop
        motor = loop.feedback[i]
        reading = loop.readings[i] if loop.readings and self.mode is Mode.ARMED else None
        return CableSnapshot(
            pull=loop.winding.compute_pull(i, motor) if self.is_homed else 0.0,
            speed=reading.speed if reading else 0.0,
            tension=self._tell_tension(i, reading),
            felt=loop.cells.tensions[i],
            cell_age=loop.cells.compute_age(i, now),
            tension_target=loop.targets.tension[i],
            pull_target=loop.targets.pull[i],
            angle=motor.angle if motor else math.nan,
            motor_speed=motor.speed if motor else math.nan,
            torque=motor.torque if motor else math.nan,
            torque_sent=loop.sent[i],
            temperature=motor.temperature if motor else math.nan,
            voltage=motor.voltage if motor else None,
            feedback_age=now - motor.time if motor else math.inf,
        )
