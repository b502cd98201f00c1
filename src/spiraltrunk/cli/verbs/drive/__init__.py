"""``spiraltrunk drive``: motors, gripper and arm, on their twin unless a bus is named."""

from __future__ import annotations

import argparse
from typing import Any, final

from spiraltrunk.cli.arguments import Parser, add_parser, read_seed, read_text
from spiraltrunk.cli.arguments import read_number as read_number
from spiraltrunk.cli.output import Answer, UsageError
from spiraltrunk.cli.output import quote as quote
from spiraltrunk.cli.verbs.drive import actions, cells, clear, poses, run_strategy, selftest

ACTIONS = {
    "status": actions.add_status,
    "clear": clear.add_clear,
    "home": actions.add_home,
    "pull": actions.add_pull,
    "jog": actions.add_jog,
    "pose": poses.add_pose,
    "protocol": actions.add_protocol,
    "run": run_strategy.add_run,
    "replay": run_strategy.add_replay,
    "selftest": selftest.add_selftest,
    "ports": poses.add_ports,
    "cells": cells.add_cells,
}
"""Actions, in the order of the help."""


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(verbs, "drive", _refuse, "drive motors, gripper and arm, on their twin unless a bus is named")
    parser.__class__ = _DriveParser
    parser.add_argument(
        "design", type=read_text, nargs="?", default="paper", metavar="DESIGN",
        help="preset or TOML file (default paper), before the action",
    )  # fmt: skip
    parser.add_argument(
        "--bus", type=read_text, default="virtual", metavar="BUS",
        help="virtual (default): the twin; robot: the bus of --robot; or a bus such as socketcan:can0, "
        "board:/dev/ttyACM0, sts:/dev/ttyUSB0. Only a name opens a port",
    )  # fmt: skip
    parser.add_argument("--robot", type=read_text, metavar="FILE", help="how the robot is wired: a TOML file")
    parser.add_argument(
        "--without-watchdog", action="store_true", help="arm although nothing ends the torque when this computer dies"
    )
    parser.add_argument("--real-time", action="store_true", help="let the twin follow the computer's clock")
    parser.add_argument("--seed", type=read_seed, default=0, help="seed of the twin and of the scene (default 0)")
    chosen = parser.add_subparsers(required=True, metavar="ACTION", parser_class=Parser)
    for name, add in ACTIONS.items():
        add(chosen, name)


@final
class _DriveParser(Parser):
    """Takes the action's name for what it is where no design is given before it."""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """See `argparse.ArgumentParser.parse_known_args`."""
        return super().parse_known_args(_name_design(list(args or ())), namespace)


def _name_design(arguments: list[str]) -> list[str]:
    """The arguments with the design right before the action, the default one where none is given.

    Argparse takes an optional positional only together with the next one: with options between them it is lost.
    """
    design: int | None = None
    is_value = False
    for place, argument in enumerate(arguments):
        if is_value or argument.startswith("-"):
            is_value = not is_value and argument in {"--bus", "--robot", "--seed"}
        elif design is not None:
            return [*arguments[:design], *arguments[design + 1 : place], arguments[design], *arguments[place:]]
        elif argument in ACTIONS:
            return [*arguments[:place], "paper", *arguments[place:]]
        else:
            design = place
    return arguments


def _refuse(arguments: argparse.Namespace) -> Answer:
    raise UsageError(f"no action given; allowed: {', '.join(ACTIONS)}")
