"""Arguments of moves, checked before a port is opened or a motor turns, and warnings of moves that end short."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, final

from spiraltrunk.cli.output import DONE, UsageError, complain, format_count, quote
from spiraltrunk.workflows.drive.move_defaults import SPEED, TENSION

if TYPE_CHECKING:
    from spiraltrunk.design.trunk import TrunkDesign
    from spiraltrunk.mocap.protocol.protocol import Protocol

SPEED_LEAST, SPEED_MOST = 0.1, 300.0
"""Speeds of a move [mm/s] (ours): nobody waits for less, and no GM6020 on the design's drum follows more."""

HOLD = 1.0
"""Time for which the end of a move is held, unless given [s] (ours)."""

HOLD_MOST = 3600.0
"""Longest time at the end of a move [s] (ours)."""

SHORT = 0.5
"""Distance from the target at the end of a move above which there is a warning [mm] (ours)."""


@final
@dataclass(frozen=True, kw_only=True)
class MoveSettings:
    """How cables are moved."""

    tension: float
    """Largest tension of each cable [N]."""
    speed: float
    """Speed of the cable with the longest way [m/s]."""
    hold: float
    """Time for which the end is held [s]."""


class _Limit(NamedTuple):
    """Largest value of an option, and where it is from."""

    most: float
    unit: str


def read_move(arguments: argparse.Namespace, design: TrunkDesign) -> MoveSettings:
    """Tension, speed and hold of a move; what was not given is `TENSION` and `SPEED`, or the limit where that is lower.

    Raises:
        UsageError: with the option, what was given and what is allowed by the design and the file of ``--robot``.
        DesignError: for a robot file that does not fit.
    """
    tension, speed = _find_limits(arguments, design)
    tension_n = min(TENSION, tension.most) if arguments.tension_n is None else arguments.tension_n
    speed_mm_s = min(1e3 * SPEED, speed.most) if arguments.speed_mm_s is None else arguments.speed_mm_s
    hold = HOLD if arguments.hold_s is None else float(arguments.hold_s)
    for option, value, least, limit in (
        ("--tension-n", tension_n, 0.0, tension),
        ("--speed-mm-s", speed_mm_s, SPEED_LEAST, speed),
        ("--hold-s", hold, 0.0, _Limit(HOLD_MOST, "s")),
    ):
        if not least <= value <= limit.most:
            raise UsageError(f"{option} is {value:g}; allowed: {least:g} to {limit.most:g} {limit.unit}")
    return MoveSettings(tension=tension_n, speed=1e-3 * speed_mm_s, hold=hold)


def _find_limits(arguments: argparse.Namespace, design: TrunkDesign) -> tuple[_Limit, _Limit]:
    """Largest tension [N] and speed [mm/s]: those of the design, lowered where the file of ``--robot`` says so."""
    from spiraltrunk.cli.verbs.drive.robot import load_wiring

    tension, speed = _Limit(design.cable.tension_max, "N, the largest of the design"), _Limit(SPEED_MOST, "mm/s")
    file = load_wiring(arguments, design)
    if file is None:
        return tension, speed
    where = f"of {quote(arguments.robot)}"
    if file.cables.tension_max is not None:
        tension = _Limit(file.cables.tension_max, f"N, the tension_max_n {where}")
    if file.cables.speed_max is not None and 1e3 * file.cables.speed_max < SPEED_MOST:
        speed = _Limit(round(1e3 * file.cables.speed_max, 9), f"mm/s, the speed_max_mm_s {where}")
    return tension, speed


def check_lengths(design: TrunkDesign, lengths_mm: Sequence[float]) -> None:
    """Refuse lengths that the design's drum does not wind, or another number of them than cables.

    Raises:
        UsageError: with the length and the range.
    """
    if len(lengths_mm) != design.n_cable:
        raise UsageError(
            f"{format_count(len(lengths_mm), 'length')} given; allowed: {design.n_cable}, one for each cable"
        )
    for number, length in enumerate(lengths_mm, start=1):
        _check_length(design, number, length)


def check_jog(design: TrunkDesign, cable: int, way_mm: float) -> None:
    """Refuse a cable that is none, or a way that its drum does not wind: a jog begins where homing ends, at 0.

    Raises:
        UsageError: with the value and what is allowed.
    """
    if not 1 <= cable <= design.n_cable:
        raise UsageError(f"cable is {cable}; allowed: 1 to {design.n_cable}")
    _check_length(design, cable, way_mm)


def _check_length(design: TrunkDesign, cable: int, length_mm: float) -> None:
    """Refuse a length since the straight trunk that the drum does not wind."""
    from spiraltrunk.design.drum import SPARE, size_drum

    drum = size_drum(design)
    least, most = -1e3 * (1 + SPARE) * drum.travel_out, 1e3 * (1 + SPARE) * drum.travel_in
    if not least <= length_mm <= most:
        raise UsageError(f"cable {cable}: {length_mm:g} mm; allowed: {least:.0f} to {most:.0f} mm, what its drum winds")


def check_slack(arguments: argparse.Namespace, design: TrunkDesign, protocol: Protocol) -> None:
    """Refuse a protocol whose slack the robot file tells, too: both would compensate it.

    Raises:
        UsageError: where both do.
        DesignError: for a robot file that does not fit.
    """
    from spiraltrunk.cli.verbs.drive.robot import load_wiring

    file = load_wiring(arguments, design)
    if file is not None and any(protocol.slack) and any(file.cables.slack):
        where = f"the protocol and {quote(arguments.robot)}"
        raise UsageError(f"slack_mm is set in {where}, and would be compensated twice; allowed: in one of the two")


_CAUSE = "the tension is at its limit, or friction holds it"
"""Why a cable ends away from its target."""


def warn_short(ended: Sequence[float], pulls: Sequence[float]) -> None:
    """Warn of each cable that ended away from its target [m], held by its largest tension or by friction."""
    for number, (is_, wanted) in enumerate(zip(ended, pulls, strict=True), start=1):
        left = 1e3 * (wanted - is_)
        if not math.isnan(left) and abs(left) > SHORT:
            text = f"cable {number} ended at {1e3 * is_:.1f} mm, {abs(left):.1f} mm from its target"
            complain(f"{text}: {_CAUSE}", DONE)


def warn_short_steps(steps: Sequence[dict[str, Any]]) -> None:
    """Warn of each cable that ended steps of a protocol away from its targets, with the step where it was farthest."""
    for cable in range(len(steps[0]["target_mm"])):
        missed = {number: distance for number, distance in list_distances(steps, cable) if distance > SHORT}
        if missed:
            worst = max(missed, key=lambda number: missed[number])
            where = f"most in step {worst}, {missed[worst]:.1f} mm at {steps[worst - 1]['pull_mm'][cable]:.1f} mm"
            text = f"cable {cable + 1} ended {len(missed)} of {format_count(len(steps), 'step')} away from its target"
            complain(f"{text}, {where}: {_CAUSE}", DONE)


def list_distances(steps: Sequence[dict[str, Any]], cable: int) -> Iterator[tuple[int, float]]:
    """Steps, counted from 1, in which a cable is not free, each with its distance from the target at the end [mm]."""
    for number, step in enumerate(steps, start=1):
        distance = abs(step["pull_mm"][cable] - step["target_mm"][cable])
        if not math.isnan(distance):
            yield number, distance
