"""Calibration of load cells: what they read with slack cables, and with a known mass. Never tried on real cells."""

from __future__ import annotations

import math
from typing import NamedTuple, final

import numpy as np

from spiraltrunk.checks import check_number
from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.motors.load_cell import STANDARD_GRAVITY, LoadCellSettings
from spiraltrunk.workflows.drive.robot import RENEWAL, Robot

MEASURING = 2.0
"""Time over which readings are averaged [s] (ours)."""

UNSTEADY, UNSTEADY_PART = 0.2, 0.02
"""Largest standard deviation of a reading [N], and beside it over the difference from the zero [-] (ours)."""

MASS_LEAST, MASS_MOST = 0.05, 20.0
"""Masses [kg] (ours)."""

LEAST = 1.0
"""Least difference of a reading with a mass from that without one [N] (ours: fifty times the twin's noise)."""


@final
class CellReading(NamedTuple):
    """What one cell reads, without offset and scale."""

    mean: float
    """Mean [N]."""
    noise: float
    """Standard deviation [N]."""


def measure_cells(robot: Robot, settings: LoadCellSettings, duration: float = MEASURING) -> tuple[CellReading, ...]:
    """What every cell reads, in the order of its board, without torque.

    Args:
        robot: the robot; nothing moves.
        settings: its cells, whose offsets and scales are taken out again.
        duration: time over which readings are averaged [s].

    Raises:
        DriveError: where a cell has no reading that may be used.
    """
    robot.listen()
    felt, end = [], robot.clock.now() + duration - 1e-9
    while robot.clock.now() < end:
        robot.run(RENEWAL)
        cables = robot.driver.snapshot().cables
        felt.append([cables[cable].felt for cable in settings.cables])
    for cable, readings in zip(settings.cables, zip(*felt, strict=True), strict=True):
        if None in readings:
            raise DriveError(f"cable {cable + 1}: no usable reading of its load cell; check plug, board and wires")
    raw = np.asarray(felt, float) / settings.scales + settings.offsets
    return tuple(map(CellReading, raw.mean(axis=0).tolist(), raw.std(axis=0).tolist()))


def compute_scale(reading: CellReading, offset: float, mass: float) -> float:
    """Tension per newton of reading, from the weight of a mass: m g / (reading - offset) [-].

    Args:
        reading: what the cell reads with the mass.
        offset: what it reads without a load [N].
        mass: the mass that hangs on the cable [kg].

    Raises:
        DesignError: for a mass that is none.
        DriveError: where the reading swings, or hardly differs from the offset.
    """
    check_mass(mass)
    load = reading.mean - offset
    check_steady(reading, load)
    if abs(load) < LEAST:
        raise DriveError(
            f"the cell reads {reading.mean:.2f} N with {mass:g} kg and {offset:.2f} N without; allowed: at least "
            f"{LEAST:g} N apart; does the mass hang on this cable, over its pulley?"
        )
    return mass * STANDARD_GRAVITY / load


def check_mass(mass: float) -> None:
    """Refuse a mass that is none [kg]: it raises `DesignError`."""
    check_number("mass", mass, least=MASS_LEAST, most=MASS_MOST)


def check_steady(reading: CellReading, load: float = 0.0) -> None:
    """Refuse a reading that swings, such as by a mass that was just hung up.

    Raises:
        DriveError: with what is allowed.
    """
    most = math.hypot(UNSTEADY, UNSTEADY_PART * load)
    if reading.noise > most:
        raise DriveError(f"a load cell's reading varies by {reading.noise:.2f} N; allowed: {most:.2f} N; wait for rest")
