"""Requests to the robot's process, and their check, which the sender and the process both carry out."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

from spiraltrunk.checks import Range, read_numbers
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DriveError, describe
from spiraltrunk.hardware.setup.poses import PullLimits
from spiraltrunk.workflows.drive.gamepad_jog import compute_pull_limits

STEP_MOST = 0.05
"""Longest way of one jog [m] (ours)."""

SPEED_LEAST, SPEED_MOST = 0.001, 0.1
"""Speeds of a cable [m/s] (ours)."""

NAME_MOST = 60
"""Longest name of a person [characters] (ours)."""


@final
@dataclass(frozen=True)
class Alive:
    """The page answers."""

    asked: float
    """When it was asked what it answered, by `time.monotonic` [s]."""


@final
@dataclass(frozen=True)
class Home:
    """Find the zeros of the drums."""


@final
@dataclass(frozen=True)
class Arm:
    """Switch torque on; all cables follow the trunk at the floor of tension."""


@final
@dataclass(frozen=True)
class Disarm:
    """Let the cables go, and be safe."""


@final
@dataclass(frozen=True)
class Stop:
    """Stop as on a fault, because a person wants it."""


@final
@dataclass(frozen=True)
class Leave:
    """Nobody is in control any more: let the cables go at once."""


@final
@dataclass(frozen=True)
class Clear:
    """Clear the faults."""

    person: str
    """Who does."""


@final
@dataclass(frozen=True)
class Jog:
    """Wind one cable in or out; it holds its length from then on."""

    cable: int
    """Its number, from 0."""
    way: float
    """Length to wind in; negative to let out [m]."""


@final
@dataclass(frozen=True)
class Move:
    """Wind the cables to these lengths; all empty: they follow the trunk."""

    pulls: tuple[float | None, ...]
    """Cable wound in since the straight trunk, one for each [m]; None for one that follows the trunk at the floor."""


@final
@dataclass(frozen=True)
class Limit:
    """Limits of all moves from now on."""

    tension: float
    """Largest tension of a cable that holds its length [N]."""
    speed: float
    """Largest speed of a cable [m/s]."""


@final
@dataclass(frozen=True)
class Run:
    """Run a strategy on the twin, in the scene of a trial, with home and arm before."""

    strategy: str
    """Its name."""
    shape: str
    """The object, as `spiraltrunk.sim.objects.catalogue.parse_object` reads it."""
    seed: int = 0
    """Seed of scene and twin."""


@final
@dataclass(frozen=True)
class Close:
    """Let go, and end the process."""


Request = Alive | Home | Arm | Disarm | Stop | Leave | Clear | Jog | Move | Limit | Run | Close


def check_request(design: TrunkDesign, request: Request) -> None:
    """Refuse values that are no finite numbers, no known names, or beyond what the design allows.

    Raises:
        DriveError: with what was given and what is allowed.
        UnknownName: for a strategy that does not exist.
        DesignError: for an object that does not exist.
    """
    match request:
        case Alive(asked):
            _read("asked", asked, Range())
        case Clear(person):
            _check_person(person)
        case Jog(cable, way):
            if isinstance(cable, bool) or not isinstance(cable, int) or not 0 <= cable < design.n_cable:
                raise DriveError(f"cable is {describe(cable)}; allowed: 0 to {design.n_cable - 1}")
            _read("way", way, Range(least=-STEP_MOST, most=STEP_MOST), "m")
        case Move(pulls):
            check_pulls(design, pulls)
        case Limit(tension, speed):
            _read("largest tension", tension, Range(least=0.0, most=design.cable.tension_max), "N")
            _read("speed", speed, Range(least=SPEED_LEAST, most=SPEED_MOST), "m/s")
        case Run(strategy, shape, seed):
            _check_run(strategy, shape, seed)


def check_pulls(design: TrunkDesign, pulls: tuple[float | None, ...], limits: PullLimits | None = None) -> None:
    """Refuse lengths that the design's drum does not wind, or another number of them than cables.

    Raises:
        DriveError: with the cable, its length and the range.
    """
    limits = compute_pull_limits(design) if limits is None else limits
    if not isinstance(pulls, tuple) or len(pulls) != design.n_cable:
        raise DriveError(f"pulls are {describe(pulls)}; allowed: {design.n_cable}, one for each cable")
    for number, (pull, least, most) in enumerate(zip(pulls, *limits, strict=True), start=1):
        if pull is not None and not (isinstance(pull, float) and math.isfinite(pull) and least <= pull <= most):
            given = f"{1e3 * pull:.4g} mm" if isinstance(pull, float) else describe(pull)
            raise DriveError(
                f"cable {number} at {given}; allowed: {1e3 * least:.0f} to {1e3 * most:.0f} mm, what its drum winds"
            )


def _read(name: str, value: object, allowed: Range, unit: str = "") -> None:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise DriveError(f"{name} is {describe(value)}; allowed: a number")
    read_numbers(name, float(value), allowed, shape=(), unit=unit, error=DriveError)


def _check_person(person: object) -> None:
    is_name = isinstance(person, str) and 0 < len(person.strip()) <= NAME_MOST and person.isprintable()
    if not is_name:
        raise DriveError(f"the person is {describe(person)}; allowed: a name of 1 to {NAME_MOST} characters")


def _check_run(strategy: object, shape: object, seed: object) -> None:
    from spiraltrunk import strategies
    from spiraltrunk.sim.objects.catalogue import parse_object

    if not isinstance(strategy, str) or not isinstance(shape, str) or not isinstance(seed, int):
        raise DriveError("a run has the names of a strategy and an object, and a whole number as seed")
    strategies.get(strategy)
    parse_object(shape)
