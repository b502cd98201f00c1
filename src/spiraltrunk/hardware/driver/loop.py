"""One period of a driver: feedback in; targets, homing or the reaction to a fault; torques out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final, final

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.arm.arm_port import ArmPort
from spiraltrunk.hardware.clock import Clock
from spiraltrunk.hardware.driver.homing_routine import HomingRoutine, ProbedHoming
from spiraltrunk.hardware.driver.options import DriverOptions
from spiraltrunk.hardware.driver.side import ArmSide, GripperSide
from spiraltrunk.hardware.driver.targets import Targets
from spiraltrunk.hardware.driver.tension_side import TensionSide
from spiraltrunk.hardware.driver.winding import Winding
from spiraltrunk.hardware.motors.load_cell import LoadCells
from spiraltrunk.hardware.motors.motor_port import MotorPort, MotorState
from spiraltrunk.hardware.motors.servo_port import ServoPort
from spiraltrunk.hardware.safety import states
from spiraltrunk.hardware.safety.cable_relation import CableRelation
from spiraltrunk.hardware.safety.fault import Fault, FaultKind
from spiraltrunk.hardware.safety.limits import adapt_to_slack_speed
from spiraltrunk.hardware.safety.reaction import LET_GO_TIME, RAMP_TIME, Ramp, is_over, ramp_torques
from spiraltrunk.hardware.safety.reading import CableReading
from spiraltrunk.hardware.safety.states import Mode, SafetyState
from spiraltrunk.hardware.safety.watch import Watches, find_silent, watch
from spiraltrunk.hardware.safety.watchdog import Watchdog
from spiraltrunk.hardware.safety.watches.cell_watch import find_untrue_zero
from spiraltrunk.hardware.winder.winder import Winder

UNHEARD: Final = frozenset(
    {FaultKind.BUS, FaultKind.STALE_FEEDBACK, FaultKind.FROZEN_FEEDBACK, FaultKind.IMPLAUSIBLE_FEEDBACK}
)
"""Faults that leave in doubt whether motors obey: after the ramp the watchdog is not fed, and ends the torque."""


@final
class ControlLoop:
    """What a driver remembers from one period to the next, and what it does in one."""

    def __init__(
        self,
        *,
        design: TrunkDesign,
        motors: MotorPort,
        winders: Sequence[Winder],
        homing: HomingRoutine,
        watchdog: Watchdog,
        clock: Clock,
        servo: ServoPort | None,
        arm: ArmPort | None,
        load_cells: LoadCells | None,
        options: DriverOptions,
    ) -> None:
        """See `driver.TrunkDriver`."""
        sheet, n_motor = motors.data_sheet, motors.n_motor
        self.motors, self.watchdog, self.options = motors, watchdog, options
        self.cells = TensionSide(load_cells, n_motor, options.limits)
        self.winding = Winding(winders, sheet, self.cells.has_cell)
        self.homing = ProbedHoming(homing)
        self.arm, self.gripper = ArmSide(arm, options.limits), GripperSide(servo, options.gripper)
        ranges, relation = self.winding.build_ranges(), CableRelation.from_design(design)
        limits = adapt_to_slack_speed(options.limits, self.winding.slack_speed, self.winding.lag)
        self.watches = Watches(sheet=sheet, limits=limits, ranges=ranges, relation=relation)
        homing_limits = replace(limits, blocked_torque=4.0 * sheet.torque_max)  # Homing finds a jam itself.
        self._homing_watches = replace(self.watches, is_homed=False, limits=homing_limits)
        self._clock = clock
        self._time: float | None = None
        self.state = SafetyState()
        """Mode and faults."""
        self.feedback: tuple[MotorState | None, ...] = (None,) * n_motor
        """Latest feedback of each motor."""
        self.readings: tuple[CableReading, ...] = ()
        """What the watches saw last; empty before."""
        self.sent = (0.0,) * n_motor
        """Torques that were sent last [N m]."""
        self.seen = self.watches.start()
        """States of the watches."""
        self.warnings: tuple[str, ...] = ()
        """What is no fault yet."""
        self.targets = self._hold_floor(-math.inf)
        """What is aimed at when armed."""
        self.has_new_position = False
        """Whether the target was not sent to the arm yet."""
        self.refusal = ""
        """Why the last targets were refused; empty where they were not."""
        self.ramp: Ramp | None = None
        """Ramp to zero torque; None with torque on."""

    # Events from outside of the loop.

    def is_released(self, now: float) -> bool:
        """Whether no ramp to zero torque is under way."""
        return self.ramp is None or is_over(self.ramp, now)

    def find_obstacles(self, now: float) -> tuple[str, ...]:
        """Why torque must not be switched on now."""
        absence = "" if self.options.without_watchdog else self.watchdog.find_absence()
        watches = self.watches
        found = states.find_obstacles(self.feedback, now, watches.sheet, watches.limits, absence=absence)
        return (*found, *self.cells.find_obstacles(), *self._find_untrue_zeros())

    def _find_untrue_zeros(self) -> tuple[str, ...]:
        """Load cells that tell a tension which nothing holds; while no torque is on."""
        told = [
            find_untrue_zero(felt, allowed.friction, self.watches.limits)
            for felt, allowed in zip(self.cells.tensions, self.watches.ranges, strict=True)
        ]
        return tuple(f"cable {i}: {text}" for i, text in enumerate(told, start=1) if text)

    def start_homing(self) -> None:
        """Begin homing; raises `DriveError` with every obstacle."""
        self.state = states.start_homing(self.state, self.find_obstacles(self._clock.now()))
        self.ramp = None
        self.motors.restart_count()
        self.homing.start(tuple(motor for motor in self.feedback if motor))
        self.seen = self._homing_watches.start()

    def start_control(self) -> None:
        """Arm, with the floor of tension as the first target; raises `DriveError` with every obstacle."""
        now = self._clock.now()
        obstacles = (*self.find_obstacles(now), *(fault.text for fault in self.arm.watch(now)))
        self.state = states.arm(self.state, obstacles)
        self.ramp, self.refusal, self.has_new_position = None, "", False
        self.winding.restart()
        self.seen = self.watches.start(self.seen)
        self.targets = self._hold_floor(now + self.options.arming_time)

    def let_go(self) -> None:
        """Disarm by a slow ramp; raises `DriveError` where the driver is not armed."""
        states.disarm(self.state)
        now = self._clock.now()
        if self.ramp is None:
            self._start_ramp(now, LET_GO_TIME)
        self.latch(self.arm.hold(now), now)

    def latch(self, faults: tuple[Fault, ...], now: float) -> None:
        """Latch faults; the first of them starts the ramp and holds the arm."""
        was_fault = self.state.mode is Mode.FAULT
        self.state = states.latch(self.state, faults)
        if self.state.mode is Mode.FAULT and not was_fault:
            self._start_ramp(now, RAMP_TIME)
            self.state = states.latch(self.state, self.arm.hold(now))

    def _start_ramp(self, now: float, duration: float) -> None:
        floors = self.winding.floor_torques
        self.ramp = Ramp(start=now, duration=duration, torques=self.sent, floors=floors)

    def _hold_floor(self, expires: float) -> Targets:
        """Targets that keep the cables on their drums."""
        floors = self.winding.tension_floor
        return Targets(tension=floors, pull=(math.inf,) * len(floors), expires=expires)

    # One period.

    def run_period(self, now: float) -> None:
        """Read, control or react, feed the watchdog, send."""
        dt = self.options.period if self._time is None else now - self._time
        faults = self._read(now)
        if dt > 0.0:
            self._time = now
            self._send(self._advance(faults, now, dt), now)

    def _read(self, now: float) -> tuple[Fault, ...]:
        """Read motors, load cells and arm."""
        faults = (*self.arm.watch(now), *self.cells.read(now))
        try:
            self.feedback = self.motors.read()
        except DriveError as error:
            return (*faults, _build_bus_fault(error, now))
        if any(motor and motor.is_count_lost for motor in self.feedback):
            self.state = states.lose_count(self.state)
        return faults

    def _advance(self, faults: tuple[Fault, ...], now: float, dt: float) -> tuple[float, ...]:
        """Torques of this period, after faults have been latched."""
        zeros = (0.0,) * self.motors.n_motor
        if self.state.mode is Mode.SAFE or (self.state.mode is Mode.FAULT and self.is_released(now)):
            self.warnings = tuple(fault.text for fault in faults)
            self.gripper.release()
            return zeros
        faults += find_silent(self.feedback, now, self.watches.sheet, self.watches.limits)
        torques = zeros
        if self.ramp is None and not faults:
            torques, faults = self._control(tuple(motor for motor in self.feedback if motor), now, dt)
        self.latch(faults, now)
        return torques if self.ramp is None else self._follow_ramp(self.ramp, now)

    def _follow_ramp(self, ramp: Ramp, now: float) -> tuple[float, ...]:
        """Torques of the ramp; a disarming ends with it."""
        if is_over(ramp, now) and self.state.mode is Mode.ARMED:
            self.state = states.disarm(self.state)
            self.ramp = None
        return ramp_torques(ramp, now)

    def _control(
        self, motors: tuple[MotorState, ...], now: float, dt: float
    ) -> tuple[tuple[float, ...], tuple[Fault, ...]]:
        """Torques while armed, and the faults that were found."""
        if self.state.mode is Mode.HOMING:
            return self._home(motors, now, dt)
        faults = (*self._find_unwatched(now), *self._find_old(now))
        try:
            self.readings, torques = self.winding.step(self.targets, motors, self.sent, dt, felt=self.cells.tensions)
        except DriveError as error:
            return self.sent, (*faults, _build_fault(FaultKind.IMPLAUSIBLE_FEEDBACK, str(error), now))
        self.seen, found, self.warnings = watch(self.watches, self.seen, self.readings, now, dt)
        faults = (*faults, *found)
        return torques, faults or self._command_sides(now)

    def _home(
        self, motors: tuple[MotorState, ...], now: float, dt: float
    ) -> tuple[tuple[float, ...], tuple[Fault, ...]]:
        """Torques of homing, and the faults that were found; homing ends safe, without torque."""
        self.readings = tuple(
            CableReading(motor=motor, torque=torque, tension=felt or 0.0, felt=felt)
            for motor, torque, felt in zip(motors, self.sent, self.cells.tensions, strict=True)
        )
        self.seen, found, self.warnings = watch(self._homing_watches, self.seen, self.readings, now, dt)
        step = self.homing.step(motors, now, dt)
        faults = (*self._find_unwatched(now), *found, *step.faults)
        if step.zero_angles is None or faults:
            return step.torques, faults
        self.winding.set_zeros(step.zero_angles)
        self.state = states.finish_homing(self.state)
        return (0.0,) * len(motors), ()

    def _find_unwatched(self, now: float) -> tuple[Fault, ...]:
        """A watchdog that is gone or has tripped."""
        absence = "" if self.options.without_watchdog else self.watchdog.find_absence()
        return (_build_fault(FaultKind.WATCHDOG, absence, now),) if absence else ()

    def _find_old(self, now: float) -> tuple[Fault, ...]:
        """Targets that were not renewed in time, or whose successors were refused."""
        age, allowed = now - self.targets.expires, self.options.limits.command_age
        if age < allowed:
            return ()
        if self.refusal:
            return (_build_fault(FaultKind.BAD_COMMAND, f"every command since was refused: {self.refusal}", now),)
        text = f"the command ended {1e3 * age:.1f} ms ago; allowed: below {1e3 * allowed:g} ms"
        return (_build_fault(FaultKind.STALE_COMMAND, text, now),)

    def _command_sides(self, now: float) -> tuple[Fault, ...]:
        """Send new targets to arm and servo."""
        faults: tuple[Fault, ...] = ()
        if self.has_new_position and self.targets.arm_position is not None:
            faults = self.arm.send(self.targets.arm_position, now)
        self.has_new_position = False
        return (*faults, *self.gripper.send(self.targets, now))

    def _send(self, torques: tuple[float, ...], now: float) -> None:
        """Feed the watchdog and send the torques; where they cannot be sent that is a fault, and no state changes."""
        has_torque = self.state.mode is not Mode.SAFE and not (self.state.mode is Mode.FAULT and self.is_released(now))
        faults: tuple[Fault, ...] = ()
        if self.is_feeding(now):
            try:
                self.watchdog.feed()
            except DriveError as error:
                faults = (_build_fault(FaultKind.WATCHDOG, str(error), now),)
        try:
            self.motors.send(torques)
            self.sent = torques
        except DriveError as error:
            faults = (*faults, _build_bus_fault(error, now))
        if has_torque:
            self.latch(faults, now)
        elif faults:
            self.warnings = tuple(fault.text for fault in faults)

    def is_feeding(self, now: float) -> bool:
        """Whether the watchdog is fed: not after the ramp of a fault that leaves in doubt whether motors obey."""
        is_unheard = any(fault.kind in UNHEARD for fault in self.state.faults)
        return not (is_unheard and self.is_released(now))


def _build_fault(kind: FaultKind, text: str, now: float) -> Fault:
    return Fault(kind=kind, time=now, cable=None, text=text)


def _build_bus_fault(error: DriveError, now: float) -> Fault:
    return _build_fault(FaultKind.BUS, str(error), now)
