"""Options of the commands that simulate a robot: its design, and the friction of its cables."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING

from spiraltrunk.cli.arguments import read_number, read_text

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
