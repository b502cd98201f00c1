"""``spiraltrunk drive cells``: zero and gain of the load cells."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import read_count, read_number
from spiraltrunk.cli.output import DONE, Answer, UsageError, format_json
from spiraltrunk.cli.verbs.drive.actions import add_action
from spiraltrunk.cli.verbs.drive.figures import format_figure
from spiraltrunk.cli.verbs.drive.robot import load_wiring, open_robot

if TYPE_CHECKING:
    from spiraltrunk.hardware.motors.load_cell import LoadCellSettings
    from spiraltrunk.workflows.drive.cell_calibration import CellReading


def add_cells(actions: Any, name: str) -> None:
    """Add the action that calibrates load cells."""
    parser = add_action(actions, name, _cells, "tell zeros, or with a known mass a gain, of the load cells of --robot")
    parser.add_argument(
        "--cable", type=read_count, metavar="CABLE", help="cable on which a known mass hangs, counted from 1"
    )
    parser.add_argument("--mass-kg", type=read_number, metavar="KG", help="that mass (0.05 to 20)")


def _cells(arguments: argparse.Namespace) -> Answer:
    from spiraltrunk.design import load_design
    from spiraltrunk.workflows.drive.cell_calibration import check_steady, compute_scale, measure_cells

    design = load_design(arguments.design)
    file = load_wiring(arguments, design)
    if file is None or file.load_cells is None:
        raise UsageError("no load cells given; allowed: --robot FILE with a table [load_cells]")
    settings = file.load_cells.build_settings(design.n_cable)
    cell = _find_cell(arguments, settings)
    with open_robot(arguments) as robot:
        readings = measure_cells(robot, settings)
    offsets, scales = list(settings.offsets), list(settings.scales)
    if cell is None:
        for reading in readings:
            check_steady(reading)
        offsets = [reading.mean for reading in readings]
    else:
        scales[cell] = compute_scale(readings[cell], offsets[cell], arguments.mass_kg)
    return _answer(arguments, settings, readings, offsets, scales)


def _find_cell(arguments: argparse.Namespace, settings: LoadCellSettings) -> int | None:
    """Cell of the cable with the mass, in the order of the board; None for the zeros.

    Raises:
        UsageError: for a cable without its mass, a mass without its cable, or a cable without a cell.
        DesignError: for a mass that is none.
    """
    from spiraltrunk.workflows.drive.cell_calibration import check_mass

    if (arguments.cable is None) != (arguments.mass_kg is None):
        raise UsageError("--cable and --mass-kg belong together; allowed: both for a gain, none of them for the zeros")
    if arguments.cable is None:
        return None
    check_mass(arguments.mass_kg)
    cables = [cable + 1 for cable in settings.cables]
    if arguments.cable not in cables:
        raise UsageError(f"--cable is {arguments.cable}; allowed, with a load cell: {', '.join(map(str, cables))}")
    return cables.index(arguments.cable)


def _answer(
    arguments: argparse.Namespace,
    settings: LoadCellSettings,
    readings: Sequence[CellReading],
    offsets: Sequence[float],
    scales: Sequence[float],
) -> Answer:
    """Readings, and the lines of the robot file that follow from them."""
    cables = [cable + 1 for cable in settings.cables]
    if arguments.json:
        told = {
            "cables": cables,
            "reading_n": [one.mean for one in readings],
            "noise_n": [one.noise for one in readings],
        }
        return DONE, format_json({**told, "offsets_n": list(offsets), "scales": list(scales)})
    from spiraltrunk.report import format_table

    pairs = zip(cables, readings, strict=True)
    rows = [(str(cable), format_figure(reading.mean, 2), format_figure(reading.noise, 2)) for cable, reading in pairs]
    table = format_table(rows, header=("cable", "reads [N]", "noise [N]"), title="", indent=2)
    lines = f"cables = {cables}\noffsets_n = {_format(offsets, 3)}\nscales = {_format(scales, 4)}"
    return DONE, f"{table}\n\n[load_cells]\n{lines}"


def _format(numbers: Sequence[float], digits: int) -> str:
    return f"[{', '.join(format_figure(number, digits) for number in numbers)}]"
