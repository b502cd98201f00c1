"""Arguments of moves, checked before a port is opened or a motor turns, and the warning of a move that ends short."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from spiraltrunk.cli.output import DONE, UsageError, complain, format_count

if TYPE_CHECKING:
    from spiraltrunk.design.trunk import TrunkDesign
    from spiraltrunk.workflows.drive.robot import Robot

SPEED_LEAST, SPEED_MOST = 0.1, 300.0
"""Speeds of a move [mm/s] (ours): nobody waits for less, and no GM6020 on the design's drum follows more."""

HOLD_MOST = 3600.0
"""Longest time at the end of a move [s] (ours)."""

SHORT = 0.5
"""Distance from the target at the end of a move above which there is a warning [mm] (ours)."""


def check_move(arguments: argparse.Namespace, design: TrunkDesign) -> None:
    """Refuse tension, speed and hold that no move has.

    Raises:
        UsageError: with the option, what was given and what is allowed.
    """
    most = design.cable.tension_max
    for option, value, least, largest, unit in (
        ("--tension-n", arguments.tension_n, 0.0, most, "N, the largest of the design"),
        ("--speed-mm-s", arguments.speed_mm_s, SPEED_LEAST, SPEED_MOST, "mm/s"),
        ("--hold-s", arguments.hold_s, 0.0, HOLD_MOST, "s"),
    ):
        if not least <= value <= largest:
            raise UsageError(f"{option} is {value:g}; allowed: {least:g} to {largest:g} {unit}")


def check_lengths(design: TrunkDesign, lengths_mm: Sequence[float]) -> None:
    """Refuse lengths that the design's drum does not wind, or another number of them than cables.

    Raises:
        UsageError: with the length and the range.
    """
    from spiraltrunk.design.drum import SPARE, size_drum

    if len(lengths_mm) != design.n_cable:
        raise UsageError(
            f"{format_count(len(lengths_mm), 'length')} given; allowed: {design.n_cable}, one for each cable"
        )
    drum = size_drum(design)
    least, most = -1e3 * (1 + SPARE) * drum.travel_out, 1e3 * (1 + SPARE) * drum.travel_in
    for number, length in enumerate(lengths_mm, start=1):
        if not least <= length <= most:
            raise UsageError(
                f"cable {number}: {length:g} mm; allowed: {least:.0f} to {most:.0f} mm, what its drum winds"
            )


def check_jog(design: TrunkDesign, cable: int, way_mm: float) -> None:
    """Refuse a cable that is none, or a way beyond all that its drum winds.

    Raises:
        UsageError: with the value and what is allowed.
    """
    from spiraltrunk.design.drum import SPARE, size_drum

    if not 1 <= cable <= design.n_cable:
        raise UsageError(f"cable is {cable}; allowed: 1 to {design.n_cable}")
    drum = size_drum(design)
    most = 1e3 * (1 + SPARE) * (drum.travel_in + drum.travel_out)
    if not abs(way_mm) <= most:
        raise UsageError(
            f"cable {cable} by {way_mm:g} mm; allowed: up to {most:.0f} mm either way, all that its drum winds"
        )


def warn_short(robot: Robot, pulls: Sequence[float]) -> None:
    """Warn of each cable that ended away from its target [m], held by its largest tension or by friction."""
    for number, (is_, wanted) in enumerate(zip(robot.read_pulls(), pulls, strict=True), start=1):
        left = 1e3 * (wanted - is_)
        if not math.isnan(left) and abs(left) > SHORT:
            text = f"cable {number} ended at {1e3 * is_:.1f} mm, {abs(left):.1f} mm from its target"
            complain(f"{text}: the tension is at its limit, or friction holds it", DONE)
