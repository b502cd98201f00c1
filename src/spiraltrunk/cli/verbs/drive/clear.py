"""``spiraltrunk drive clear``: a person lets a watchdog that has tripped pass torque again."""

from __future__ import annotations

import argparse
from typing import Any

from spiraltrunk.cli.arguments import read_text
from spiraltrunk.cli.output import Answer
from spiraltrunk.cli.verbs.drive.actions import add_action, answer
from spiraltrunk.cli.verbs.drive.robot import open_robot


def add_clear(actions: Any, name: str) -> None:
    """Add the action that clears a watchdog."""
    parser = add_action(actions, name, _clear, "let a watchdog that has tripped pass torque again, its cause found")
    parser.add_argument("person", type=read_text, metavar="NAME", help="who decided it")


def _clear(arguments: argparse.Namespace) -> Answer:
    with open_robot(arguments) as robot:
        robot.clear(arguments.person)
        code, text = answer(arguments, robot.driver.snapshot())
    told = "" if arguments.json else f"cleared by {arguments.person}: the watchdog lets torque through\n\n"
    return code, told + text
