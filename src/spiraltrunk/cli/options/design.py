"""Options of the commands that simulate a robot: its design, the friction of its cables, and the time step."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING

from spiraltrunk.cli.arguments import read_number, read_text
from spiraltrunk.cli.output import quote
from spiraltrunk.errors import DesignError

if TYPE_CHECKING:
    from spiraltrunk.design import TrunkDesign


def add_design(parser: argparse.ArgumentParser) -> None:
    """Add ``--design`` and ``--friction``."""
    parser.add_argument(
        "--design", type=read_text, default="paper", metavar="DESIGN",
        help="preset or TOML file (default paper, which the strategies are tuned for; the presets spirob-15 and "
        "spirob-1m run, but fail with the default object)",
    )  # fmt: skip
    parser.add_argument(
        "--friction", type=read_number, metavar="MU",
        help="coefficient of friction between cables and holes (default: the design's; 0 in the preset paper)",
    )  # fmt: skip


def add_timestep(parser: argparse.ArgumentParser) -> None:
    """Add ``--timestep-ms``."""
    parser.add_argument(
        "--timestep-ms", type=read_timestep, default=None, metavar="T", dest="timestep",
        help="time step of the physics, 10 ms over a whole number, from 0.1 to 2.5 (default 2); shorter is slower",
    )  # fmt: skip


def read_timestep(text: str) -> float:
    """A time step in milliseconds, as an argument's type [s]."""
    from spiraltrunk.sim.scene.options import check_timestep

    value = float(read_number(text)) / 1e3
    try:
        check_timestep("timestep", value)
    except DesignError:
        allowed = "10 ms over a whole number, from 0.1 to 2.5 ms, such as 0.5, 1 or 2"
        raise argparse.ArgumentTypeError(f"{quote(text)} given; allowed: {allowed}") from None
    return value


def load_robot(arguments: argparse.Namespace) -> TrunkDesign:
    """The design that was asked for, with the friction that was asked for.

    Raises:
        DesignError: for a file that is no design, or a friction out of range.
    """
    from spiraltrunk.design import load_design

    design = load_design(arguments.design)
    if arguments.friction is None:
        return design
    return replace(design, cable=replace(design.cable, friction=float(arguments.friction)))


def choose_timestep(arguments: argparse.Namespace) -> float:
    """The time step that was asked for, or the simulation's own [s]."""
    from spiraltrunk.sim.scene.options import TIMESTEP

    return TIMESTEP if arguments.timestep is None else arguments.timestep
