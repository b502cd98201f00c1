"""Self-test of the driver: every fault on the twin, with the time until it is noticed and until the robot is safe."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.files.results import Progress, ignore_progress
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.hardware.setup.load_cell_setup import LoadCellSetup
from spiraltrunk.hardware.setup.robot_file import MotorSetup, RobotFile
from spiraltrunk.hardware.twin.faults import build_fault
from spiraltrunk.workflows.drive.twin.twin_robot import TwinOptions, TwinRobot

SAFE_BAR = 0.100
"""Time within which the robot must be safe after the link or the host failed [s]."""

CABLE_BAR = 0.200
"""Time within which a cable that breaks or slips must be noticed [s]."""

DEVICE_BAR = 1.0
"""Time within which another fault of a motor or drum must be noticed while the trunk moves [s] (ours)."""

PULL_BAR = 0.003
"""Length wound in by which a cable that breaks or slips must be noticed, where that comes later [m]."""

OFF = 1e-3
"""Torque below which a motor is off [N m]: 0.1 N on a drum of 10 mm."""

_BEFORE, _AFTER = 2.0, 4.0
"""Time of the exercise before and after a fault begins [s]."""

_PERIOD, _MEAN, _SWING = 3.0, 12.0, 8.0
"""Exercise: period [s], mean and amplitude of the tensions, a third of a period apart [N] (ours)."""

_STRONG = 2.0
"""Factor of the tensions for a fault that small ones do not show [-] (ours)."""

_SWAP_ANGLE = 0.3
"""Difference of two encoders at which their ids are exchanged [rad] (ours): 5 mm of cable. When they stand alike, the
exchange shows in nothing, see SAFETY.md."""

_RENEWAL = 0.02
"""Period of the commands [s]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Scenario:
    """A fault, and what must happen."""

    fault: str | None
    """Name in the twin's catalogue; None for the host that dies."""
    settings: Mapping[str, Any] = field(default_factory=dict)
    """Settings of the fault that differ from its defaults."""
    is_stop: bool = True
    """Whether the driver must stop; otherwise control must go on."""
    may_stop: bool = False
    """Whether the driver may stop where it need not, which must then be safe."""
    is_warned: bool = False
    """Whether a warning must be given."""
    bar: float = DEVICE_BAR
    """Largest time [s]: until the robot is safe where the link or the host failed, else until it is noticed."""
    is_safe_bar: bool = False
    """Whether the bar is for the safe state."""
    is_length_enough: bool = False
    """Whether `PULL_BAR` of cable is as good as the bar."""
    at_start: bool = False
    """Whether the fault is there from the beginning, before homing."""
    strength: float = 1.0
    """Factor of the exercise's tensions [-]."""
    has_cells: bool = False
    """Whether the twin has load cells."""


SCENARIOS: Mapping[str, Scenario] = {
    "frame_loss_1_percent": Scenario(fault="frame_loss", settings={"probability": 0.01}, is_stop=False),
    "frame_loss_5_percent": Scenario(
        fault="frame_loss", settings={"probability": 0.05}, is_stop=False, is_warned=True
    ),
    "frame_loss_20_percent": Scenario(
        fault="frame_loss", settings={"probability": 0.20}, bar=SAFE_BAR, is_safe_bar=True
    ),
    "20_missed_cycles": Scenario(
        fault="frame_loss", settings={"probability": 1.0}, bar=SAFE_BAR, is_safe_bar=True
    ),
    "host_killed": Scenario(fault=None, bar=SAFE_BAR, is_safe_bar=True),
    "bus_off": Scenario(fault="bus_off", bar=SAFE_BAR, is_safe_bar=True),
    "delay": Scenario(fault="delay", settings={"duration": 0.002}, is_stop=False),
    "reorder": Scenario(fault="reorder", settings={"probability": 0.02}, is_stop=False),
    "duplicate": Scenario(fault="duplicate", is_stop=False),
    "corrupt": Scenario(fault="corrupt", settings={"probability": 0.01}, is_stop=False, may_stop=True),
    "frozen_feedback": Scenario(fault="frozen_feedback"),
    "frozen_at_rest": Scenario(fault="frozen_feedback", strength=0.0),
    "id_swap": Scenario(fault="id_swap"),
    "encoder_wrap": Scenario(fault="encoder_wrap", is_stop=False, at_start=True),
    "power_cycle": Scenario(fault="power_cycle", bar=SAFE_BAR, is_safe_bar=True),
    "over_temperature": Scenario(fault="over_temperature", settings={"rate": 200.0}, is_warned=True),
    "stall": Scenario(fault="stall", strength=_STRONG),
    "cable_break": Scenario(fault="cable_break", bar=CABLE_BAR, is_length_enough=True),
    "cable_slip": Scenario(fault="cable_slip", bar=CABLE_BAR, is_length_enough=True),
    "tangled_drum": Scenario(fault="tangled_drum"),
    "cell_silent": Scenario(fault="cell_silent", bar=SAFE_BAR, is_safe_bar=True, has_cells=True),
    "cell_unplugged": Scenario(fault="cell_unplugged", bar=SAFE_BAR, is_safe_bar=True, has_cells=True),
    "cell_stuck": Scenario(fault="cell_stuck", has_cells=True),
    "cell_reads_zero": Scenario(fault="cell_wire_off", strength=_STRONG, has_cells=True),
    "cell_reads_negative": Scenario(fault="cell_wire_off", settings={"reading": -20.0}, has_cells=True),
    "cell_out_of_range": Scenario(fault="cell_wire_off", settings={"reading": 500.0}, has_cells=True),
}  # fmt: skip
"""Every fault of the self-test, by the name that its report has."""


def build_cell_file(design: TrunkDesign) -> RobotFile:
    """Robot file of a twin with a load cell at each cable."""
    cables = tuple(range(1, design.n_cable + 1))
    return RobotFile(
        name="twin", bus="virtual:twin", motors=MotorSetup(family="gm6020", ids=cables),
        load_cells=LoadCellSetup(port="cells", cables=cables),
    )  # fmt: skip


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class FaultResult:
    """What a fault did."""

    detected: float | None
    """Time from its beginning until it was noticed [s]; None where it was not."""
    safe: float | None
    """Time until every motor was without torque [s]; None where that did not come."""
    cause: str | None
    """Kind of the first fault that was noticed."""
    bar: float | None
    """The bar [s]; None where control must go on."""
    holds: bool
    """Whether what must happen happened."""
    tracking: float
    """Root mean square of tension less command, over that without a fault [-]; NaN where the driver stopped."""
    wound: float
    """Cable wound in from the beginning until it was noticed, of the cable concerned [m]."""
    warnings: tuple[str, ...]
    """Warnings that were given."""


@final
class _Exercise:
    """A twin that is pulled about, and what is seen of it."""

    def __init__(self, design: TrunkDesign, seed: int, strength: float = 1.0, *, has_cells: bool = False) -> None:
        self._strength = strength
        file = build_cell_file(design) if has_cells else None
        self.robot = TwinRobot(design, options=TwinOptions(seed=seed, file=file))
        self.warnings: set[str] = set()
        self.errors: list[float] = []
        self.most_wound = -math.inf

    def command(self, elapsed: float) -> None:
        """Give the next command of the exercise, unless the driver has stopped."""
        driver, n_cable = self.robot.driver, self.robot.design.n_cable
        if driver.mode is Mode.ARMED:
            phase = 2 * math.pi * (elapsed / _PERIOD - np.arange(n_cable) / n_cable)
            driver.set_targets(self._strength * (_MEAN + _SWING * np.sin(phase)), valid_for=_RENEWAL)

    def run(self, duration: float, began: float) -> Iterator[float]:
        """Run the exercise; yields the time after each period of control [s]."""
        robot, period = self.robot, self.robot.options.driver.period
        end, due = robot.clock.now() + duration, robot.clock.now()
        while robot.clock.now() < end - 1e-9:
            if robot.clock.now() >= due - 1e-9:
                self.command(robot.clock.now() - began)
                due += _RENEWAL
            robot.run(period)
            self._look()
            yield robot.clock.now()

    def _look(self) -> None:
        snapshot = self.robot.driver.snapshot()
        self.warnings.update(snapshot.warnings)
        if snapshot.mode is Mode.ARMED:
            wanted = np.array([cable.tension_target for cable in snapshot.cables])
            self.errors.append(float(np.mean((np.array(self.robot.motors.tensions) - wanted) ** 2)))

    def is_swap_seen(self) -> bool:
        """Whether the encoders of the first two motors differ by `_SWAP_ANGLE`."""
        first, second = self.robot.motors.motors[:2]
        turn = first.parameters.encoder_counts
        return abs(math.remainder(first.count - second.count, turn)) * math.tau / turn >= _SWAP_ANGLE

    def is_off(self) -> bool:
        """Whether no motor has torque."""
        return all(abs(motor.torque) < OFF for motor in self.robot.motors.motors)


def run_selftest(
    design: TrunkDesign,
    *,
    seed: int = 0,
    names: tuple[str, ...] = tuple(SCENARIOS),
    progress: Progress = ignore_progress,
) -> dict[str, FaultResult]:
    """Inject every fault into a twin that is pulled about, each into a fresh one.

    The trunk of this twin is `SpringTrunk`: what is tested is the driver, and it must stop for the motors' sake.

    Raises:
        DesignError: where the twin cannot be built.
        RunError: where it does not even run without a fault.
    """
    nominal = _measure_nominal(design, seed)
    results = {}
    for done, name in enumerate(names):
        progress(name, done, len(names))
        results[name] = run_scenario(design, SCENARIOS[name], seed=seed, nominal=nominal)
    return results


def _measure_nominal(design: TrunkDesign, seed: int) -> float:
    """Root mean square of tension less command without a fault [N]."""
    exercise = _Exercise(design, seed)
    exercise.robot.prepare()
    began = exercise.robot.clock.now()
    for _ in exercise.run(_BEFORE, began):
        pass
    exercise.errors.clear()
    for _ in exercise.run(_AFTER, began):
        exercise.robot.raise_fault()
    return math.sqrt(float(np.mean(exercise.errors)))


def run_scenario(design: TrunkDesign, scenario: Scenario, *, seed: int, nominal: float) -> FaultResult:
    """One fault; ``nominal`` is the tracking error without a fault [N]."""
    exercise = _Exercise(design, seed, scenario.strength, has_cells=scenario.has_cells)
    robot = exercise.robot
    if scenario.at_start and scenario.fault is not None:
        robot.faults.inject(build_fault(scenario.fault, scenario.settings))
    injected = robot.clock.now()
    if not _prepare(robot):
        return _evaluate(scenario, exercise, injected, _wait_until_off(exercise), nominal)
    began = robot.clock.now()
    for now in exercise.run(_BEFORE + _PERIOD, began):
        if now >= began + _BEFORE - 1e-9 and (scenario.fault != "id_swap" or exercise.is_swap_seen()):
            break
    exercise.errors.clear()
    if not scenario.at_start:
        injected = robot.clock.now()
        if scenario.fault is None:
            return _kill_host(scenario, exercise)
        robot.faults.inject(build_fault(scenario.fault, scenario.settings), at=injected)
    start = [motor.wound for motor in robot.motors.motors]
    safe = None
    for now in exercise.run(_AFTER, began):
        if robot.driver.mode is Mode.ARMED:
            moved = robot.motors.motors[0].wound - start[0]
            exercise.most_wound = max(exercise.most_wound, moved)
        elif exercise.is_off():
            safe = now
            break
    return _evaluate(scenario, exercise, injected, safe, nominal)


def _prepare(robot: TwinRobot) -> bool:
    """Home and arm; False where a fault kept it from that."""
    try:
        robot.prepare()
    except RuntimeError:
        if robot.driver.faults:
            return False
        raise
    return True


def _wait_until_off(exercise: _Exercise) -> float | None:
    for now in exercise.run(1.0, 0.0):
        if exercise.is_off():
            return now
    return None


def _kill_host(scenario: Scenario, exercise: _Exercise) -> FaultResult:
    """The driver is never called again: what is left is the board."""
    clock, injected = exercise.robot.clock, exercise.robot.clock.now()
    safe = None
    while clock.now() < injected + 1.0 and safe is None:
        clock.sleep_until(clock.now() + 1e-3)
        safe = clock.now() - injected if exercise.is_off() else None
    return FaultResult(
        detected=None, safe=safe, cause="watchdog" if safe is not None else None, bar=scenario.bar,
        holds=safe is not None and safe <= scenario.bar, tracking=math.nan, wound=0.0, warnings=(),
    )  # fmt: skip


def _evaluate(
    scenario: Scenario, exercise: _Exercise, injected: float, safe_at: float | None, nominal: float
) -> FaultResult:
    faults = exercise.robot.driver.faults
    detected = faults[0].time - injected if faults else None
    safe = None if safe_at is None else safe_at - injected
    errors = exercise.errors
    tracking = math.sqrt(float(np.mean(errors))) / nominal if errors and not faults else math.nan
    result = FaultResult(
        detected=detected, safe=safe, cause=faults[0].kind.value if faults else None,
        bar=scenario.bar if scenario.is_stop else None, holds=True, tracking=tracking,
        wound=max(0.0, exercise.most_wound), warnings=tuple(sorted(exercise.warnings)),
    )  # fmt: skip
    return replace(result, holds=_holds(scenario, result))


def _holds(scenario: Scenario, result: FaultResult) -> bool:
    is_warned = bool(result.warnings) or not scenario.is_warned
    if not scenario.is_stop and result.cause is None:
        return result.tracking < 2.0 and is_warned
    if not (scenario.is_stop or scenario.may_stop) or result.detected is None or result.safe is None or not is_warned:
        return False
    if scenario.is_safe_bar:
        return result.safe <= scenario.bar
    is_soon = (
        scenario.may_stop or result.detected <= scenario.bar or (scenario.is_length_enough and result.wound <= PULL_BAR)
    )
    return is_soon and result.safe - result.detected <= SAFE_BAR
