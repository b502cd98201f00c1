"""Calibration of load cells: what swings, is too little or gone is refused."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DesignError, DriveError
from spiraltrunk.hardware.setup.load_cell_setup import LoadCellSetup
from spiraltrunk.hardware.setup.robot_file import MotorSetup, RobotFile
from spiraltrunk.hardware.twin.faults.cell_faults import CellSilent
from spiraltrunk.workflows.drive.cell_calibration import CellReading, check_steady, compute_scale, measure_cells
from spiraltrunk.workflows.drive.twin.twin_robot import TwinOptions, TwinRobot

CELLS = LoadCellSetup(port="cells", cables=(2,), offsets=(3.0,), scales=(-2.0,))
FILE = RobotFile(name="bench", bus="virtual:x", motors=MotorSetup(family="gm6020", ids=(1, 2, 3)), load_cells=CELLS)


@given(st.floats(0.05, 20.0), st.floats(-50.0, 50.0), st.floats(0.1, 10.0), st.sampled_from([1.0, -1.0]))
def test_the_scale_maps_the_reading_to_the_weight(mass, offset, scale, sign):
    weight = mass * 9.80665
    reading = CellReading(offset + sign * weight / scale, 0.0)
    if weight / scale < 0.999:
        with pytest.raises(DriveError, match="at least 1 N apart"):
            compute_scale(reading, offset, mass)
    elif weight / scale > 1.001:
        assert compute_scale(reading, offset, mass) == pytest.approx(sign * scale, rel=1e-9)


@pytest.mark.parametrize("mass", [0.0, -1.0, 21.0, float("nan"), float("inf")])
def test_a_mass_that_is_none_is_refused(mass):
    with pytest.raises(DesignError, match="mass"):
        compute_scale(CellReading(10.0, 0.0), 0.0, mass)


def test_a_reading_that_swings_is_refused():
    check_steady(CellReading(0.0, 0.19))
    with pytest.raises(DriveError, match=r"varies by 0.21 N; allowed: 0.20 N; wait for rest"):
        check_steady(CellReading(0.0, 0.21))
    assert compute_scale(CellReading(20.0, 0.4), 0.0, 2.0) == pytest.approx(0.980665)
    with pytest.raises(DriveError, match="wait for rest"):
        compute_scale(CellReading(20.0, 0.5), 0.0, 2.0)


def test_cells_are_read_as_the_board_sends_them_and_silence_is_told():
    with TwinRobot(PAPER, options=TwinOptions(file=FILE)) as robot:
        settings = CELLS.build_settings(3)
        (reading,) = measure_cells(robot, settings, 0.5)
        assert reading.mean == pytest.approx(3.0, abs=0.02)
        assert 0.005 < reading.noise < 0.04
        CellSilent().begin(robot.motors)
        with pytest.raises(DriveError, match="cable 2: no usable reading of its load cell"):
            measure_cells(robot, replace(settings), 0.2)
