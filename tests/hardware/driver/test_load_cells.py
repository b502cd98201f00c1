"""The driver with load cells: one contract for both motor families, on twins whose cells work, and whose cells fail."""

from __future__ import annotations

from dataclasses import replace
from types import ModuleType

import numpy as np
import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.motors.load_cell import LoadCells
from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.hardware.setup.load_cell_setup import LoadCellSetup
from spiraltrunk.hardware.setup.robot_file import MotorSetup, RobotFile
from spiraltrunk.hardware.twin.faults.cell_faults import CellSilent, CellStuck, CellUnplugged, CellWireOff
from spiraltrunk.hardware.twin.faults.device_faults import CableBreak, CableSlip
from spiraltrunk.hardware.twin.load_cells import LoadCellTwin
from spiraltrunk.workflows.drive.twin.twin_robot import TwinOptions, TwinRobot

CELLS = LoadCellSetup(port="cells", cables=(1, 2, 3), offsets=(0.0, 0.5, 0.0), scales=(1.0, 1.0, -1.0))
"""The second cell has a zero, the third is upside down."""

PULL = (20.0, 10.0, 10.0)
LIMITS = SafetyLimits()

MOTORS = pytest.mark.parametrize("build", ["gm6020", pytest.param("sts", marks=pytest.mark.slow)], indirect=True)
"""What one driver does for both families: the fast tests try it with the quicker of them."""


class Twin:
    """A robot of GM6020 with what a robot of servos has."""

    def __init__(self, cells: LoadCellSetup | None, prepared: ModuleType) -> None:
        self.cells, self.prepared = cells, prepared
        file = RobotFile(
            name="bench", bus="virtual:x", motors=MotorSetup(family="gm6020", ids=(1, 2, 3)), load_cells=cells
        )
        self.robot = TwinRobot(PAPER, options=TwinOptions(seed=2, file=file))
        self.driver, self.clock, self.twin = self.robot.driver, self.robot.clock, self.robot.motors

    def run(self, seconds, tension=None):
        end, due = self.clock.now() + seconds, self.clock.now()
        while self.clock.now() < end - 1e-9:
            if tension is not None and self.driver.mode is Mode.ARMED and self.clock.now() >= due - 1e-9:
                self.driver.set_targets(tension, valid_for=0.05)
                due += 0.02
            self.driver.wait()
            self.driver.tick()

    def prepare(self):
        """Home and arm, or become a copy of a robot as this one that was."""
        self.prepared.prepare_once(self, ("gm6020", self.cells), self.robot.prepare)

    def is_off(self):
        return all(abs(motor.torque) < 1e-3 for motor in self.twin.motors)

    def close(self):
        self.robot.close()


@pytest.fixture(params=["gm6020", "sts"])
def build(request, build_sts, prepared):
    """Builds a robot with load cells, or without."""
    robots = []

    def build(cells: LoadCellSetup | None = CELLS):
        if request.param == "sts":
            return build_sts(cells=None if cells is None else cells.build_settings(3))
        robots.append(Twin(cells, prepared))
        return robots[-1]

    yield build
    for robot in robots:
        robot.close()


@pytest.fixture
def robot(build):
    return build()


@pytest.fixture
def pulling(robot, prepared):
    """A robot that has pulled for 3 s, or a copy of one that has."""

    def prepare():
        robot.prepare()
        robot.run(3.0, PULL)

    prepared.prepare_once(robot, ("pulling", type(robot).__name__), prepare)
    return robot


def read_felt(robot):
    return [cable.felt for cable in robot.driver.snapshot().cables]


@MOTORS
def test_a_copy_of_a_prepared_robot_goes_on_as_that_does(robot, prepared):
    """On which all tests here rest that begin with a prepared robot."""

    def run(one):
        for k in range(20):
            one.run(0.05, (30.0, 5.0, 12.0 + k % 3))
            yield one.driver.snapshot(), *one.twin.tensions

    robot.run(0.1)  # So that it homes by itself.
    robot.prepare()
    copied = prepared.copy_robot(robot)
    seen = list(run(copied))
    assert seen == list(run(robot))
    assert seen[0][1:] != seen[-1][1:]


@MOTORS
def test_tensions_are_measured_with_and_without_torque(robot):
    robot.run(0.3)
    assert robot.driver.mode is Mode.SAFE
    assert read_felt(robot) == pytest.approx(robot.twin.tensions, abs=0.3)
    robot.prepare()
    robot.run(2.0, PULL)
    snapshot = robot.driver.snapshot()
    assert snapshot.faults == ()
    assert [cable.tension for cable in snapshot.cables] == pytest.approx(robot.twin.tensions, abs=1.0)
    assert [cable.tension for cable in snapshot.cables] == [max(felt, 0.0) for felt in read_felt(robot)]
    assert max(cable.cell_age for cable in snapshot.cables) <= 0.01


@pytest.mark.slow
def test_the_error_of_friction_is_removed(build):
    """Mean error of the cables' true tensions from 12 s on, without and with cells; both are printed."""
    errors = []
    for cells in (None, CELLS):
        robot, left = build(cells), []
        robot.prepare()
        for tension in (PULL, (30.0, 20.0, 10.0)):
            robot.run(12.0, tension)
            for _ in range(30):
                robot.run(0.1, tension)
                left.append(np.abs(np.array(robot.twin.tensions) - tension).mean())
            assert robot.driver.faults == ()
        errors.append(float(np.mean(left)))
    print(f"mean error {errors[0]:.2f} N by the motors, {errors[1]:.2f} N by load cells")
    assert errors[1] < min(errors[0], 2.0)


@MOTORS
def test_one_cell_is_used_and_the_other_cables_are_estimated(build):
    robot = build(LoadCellSetup(port="cells", cables=(2,)))
    robot.prepare()
    robot.run(2.0, PULL)
    cables = robot.driver.snapshot().cables
    assert robot.driver.faults == ()
    assert [cable.felt is None for cable in cables] == [True, False, True]
    assert [cable.cell_age is None for cable in cables] == [True, False, True]
    assert cables[1].tension == pytest.approx(robot.twin.tensions[1], abs=1.0)


@pytest.mark.parametrize(
    ("build", "count"),
    [("sts", 6), *(pytest.param(*row, marks=pytest.mark.slow) for row in (("gm6020", 6), ("gm6020", 20), ("sts", 20)))],
    indirect=["build"],
)
def test_steps_of_the_tensions_raise_no_alarm(robot, count):
    robot.prepare()
    draw = np.random.default_rng(5)
    for _ in range(count):
        robot.run(float(draw.uniform(0.3, 1.5)), tuple(draw.uniform(0.0, 40.0, 3)))
        assert robot.driver.faults == ()


FAULTS = {
    "silent": (CellSilent(), 0.07, "no plausible reading of its load cell for 50 ms"),
    "unplugged": (CellUnplugged(), 0.02, "load cells on cells: the adapter was unplugged; is the board plugged in?"),
    "beyond its range": (CellWireOff(reading=500.0), 0.07, "no plausible reading of its load cell for 50 ms"),
    "not a number": (CellWireOff(reading=1e6), 0.07, "no plausible reading of its load cell for 50 ms"),
    "stuck": (CellStuck(), 0.53, "its load cell has told"),
    "zero": (CellWireOff(), 1.5, "its load cell tells"),
    "negative": (CellWireOff(reading=-20.0), 0.25, "allowed: at least -3 N"),
    "too much": (CellWireOff(reading=150.0), 0.25, ""),
}
"""Fault, time within which it must be noticed [s], and what is told."""


@pytest.mark.parametrize("name", FAULTS)
def test_a_cell_that_fails_is_a_fault_and_is_never_used_silently(pulling, name):
    robot, (fault, bar, text) = pulling, FAULTS[name]
    fault.begin(robot.twin)
    began, highest = robot.clock.now(), 0.0
    while not robot.driver.faults and robot.clock.now() < began + bar + 1.0:
        robot.run(0.01, PULL)
        highest = max(highest, *robot.twin.tensions)
    first = robot.driver.faults[0]
    print(f"{name}: {1e3 * (first.time - began):.0f} ms, {first.kind.value}: {first.text}; at most {highest:.1f} N")
    assert first.time - began <= bar
    if name == "too much":
        assert first.kind is FaultKind.OVER_TENSION
    else:
        assert first.kind is FaultKind.LOAD_CELL
        assert text in first.text
    assert highest < 1.15 * PAPER.cable.tension_max
    robot.run(0.1)
    assert robot.is_off()


@pytest.mark.parametrize(
    ("build", "tension"),
    [
        pytest.param(family, tension, marks=[] if (family, tension) == ("sts", 4.0) else [pytest.mark.slow])
        for family in ("gm6020", "sts")
        for tension in (4.0, 6.0, 10.0)
    ],
    indirect=["build"],
)
def test_a_cell_that_reads_0_at_a_low_tension_is_told_by_the_trunk_that_its_cable_bends(build, tension):
    """Friction hides such a tension from the motor, with servos up to 15 N of it; the lengths tell that it is there."""
    robot, pull = build(replace(CELLS, offsets=(0.0,) * 3, scales=(1.0,) * 3)), (tension,) * 3
    robot.prepare()
    robot.run(3.0, pull)
    CellWireOff().begin(robot.twin)
    began, highest = robot.clock.now(), 0.0
    while not robot.driver.faults and robot.clock.now() < began + 3.0:
        robot.run(0.01, pull)
        highest = max(highest, *robot.twin.tensions)
    first = robot.driver.faults[0]
    print(f"0 at {tension:g} N: {first.time - began:.2f} s, at most {highest:.1f} N: {first.text}")
    assert (first.kind, first.cable) == (FaultKind.LOAD_CELL, 0)
    assert first.time - began <= 1.3
    assert highest < tension + 10.0


def test_a_cell_that_fails_while_the_drums_are_homed_ends_homing(robot):
    robot.run(0.3)
    robot.driver.home()
    robot.run(0.3)
    CellSilent().begin(robot.twin)
    robot.run(0.3)
    assert robot.driver.mode is Mode.FAULT
    assert robot.driver.faults[0].kind is FaultKind.LOAD_CELL
    assert robot.is_off()


def test_torque_is_not_switched_on_without_every_cell_and_is_again_afterwards(pulling):
    robot = pulling
    CellSilent().begin(robot.twin)
    robot.run(0.3, PULL)
    robot.driver.clear_fault("a person")
    with pytest.raises(DriveError, match=r"cable 1: no plausible reading of its load cell.*cable 3: no plausible"):
        robot.driver.arm()
    assert read_felt(robot) == [None] * 3
    CellSilent().end(robot.twin)
    robot.run(0.3)
    robot.driver.arm()
    robot.run(1.0, PULL)
    assert robot.driver.faults == ()


def test_a_stuck_cell_is_not_armed(robot):
    robot.prepare()
    robot.driver.disarm()
    robot.run(1.0)
    CellStuck(cable=1).begin(robot.twin)
    robot.run(0.7)
    with pytest.raises(DriveError, match="cable 2: its load cell has told"):
        robot.driver.arm()


def test_a_zero_that_was_not_measured_is_not_armed(build):
    robot = build(replace(CELLS, offsets=(0.0, -60.0, 0.0)))
    robot.twin.cells._settings = CELLS.build_settings(3)
    robot.run(0.3)
    with pytest.raises(DriveError, match=r"cable 2: its load cell tells 60\.\d N without torque; .* its zero"):
        robot.driver.home()


def test_a_cell_upside_down_ends_homing_as_soon_as_its_cable_is_taut(build):
    robot = build(replace(CELLS, scales=(-1.0, 1.0, -1.0)))
    robot.twin.cells._settings = CELLS.build_settings(3)
    robot.run(0.3)
    robot.driver.home()
    end = robot.clock.now() + 60.0
    while robot.driver.mode is Mode.HOMING and robot.clock.now() < end:
        robot.run(0.1)
    first = robot.driver.faults[0]
    print(f"{first.kind.value} of cable {first.cable}: {first.text}")
    assert (first.kind, first.cable) == (FaultKind.LOAD_CELL, 0)
    assert "allowed: at least -3 N" in first.text


@pytest.mark.parametrize("fault", [CableBreak(), CableSlip(length=0.01, cable=1), CableSlip(length=0.005)], ids=repr)
def test_a_cable_that_breaks_or_slips_is_noticed_with_cells_too(pulling, fault):
    robot = pulling
    robot.run(3.0, PULL)
    fault.begin(robot.twin)
    began, motor = robot.clock.now(), robot.twin.motors[fault.cable]
    start = motor.wound
    while not robot.driver.faults and robot.clock.now() < began + 2.0:
        robot.run(0.01, PULL)
    first, wound = robot.driver.faults[0], motor.wound - start
    print(f"{fault.name}: after {1e3 * (first.time - began):.0f} ms and {1e3 * wound:.1f} mm: {first.text}")
    assert first.kind is not FaultKind.LOAD_CELL
    assert first.time - began <= 0.2 or wound <= 3e-3


def test_closing_releases_the_port(robot):
    robot.run(0.1)
    robot.driver.close()
    assert robot.twin.cells.is_closed


def test_faults_of_cells_need_cells(build):
    twin = build(None).twin
    for fault in (CellSilent(), CellUnplugged(), CellStuck(), CellWireOff()):
        with pytest.raises(DriveError, match="without load cells"):
            fault.begin(twin)
    some = build(LoadCellSetup(port="cells", cables=(2,))).twin
    with pytest.raises(DriveError, match="load cell of cable 0; allowed: 1"):
        CellStuck().begin(some)


def test_the_reader_gives_the_true_tension_of_the_twin_whatever_the_calibration():
    """Offset and scale of the twin are the inverse of the reader's; noise of 20 mN remains."""

    class Clock:
        time = 0.0

        def now(self):
            return self.time

    true, clock = [3.0, 0.0, 41.5], Clock()
    settings = LoadCellSetup(port="x", cables=(3, 1), offsets=(5.0, -7.5), scales=(-2.0, 0.5)).build_settings(3)
    twin = LoadCellTwin(settings, lambda: true)
    cells, seen = LoadCells(settings, twin, clock), []
    for _ in range(400):
        twin.advance(1e-3)
        clock.time += 1e-3
        seen.append([None if sample is None else sample.tension for sample in cells.read()])
    felt = np.array([[one[0], one[2]] for one in seen[10:]], float)
    assert all(one[1] is None for one in seen)
    np.testing.assert_allclose(felt.mean(axis=0), [3.0, 41.5], atol=0.02)
    assert (felt.std(axis=0) > 0.005).all()
