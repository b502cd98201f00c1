"""``spiraltrunk drive pose`` and ``ports``: poses by name, and what this computer is connected to."""

from __future__ import annotations

import argparse
from typing import Any

from spiraltrunk.cli.arguments import read_number, read_text
from spiraltrunk.cli.output import DONE, Answer, format_json
from spiraltrunk.cli.verbs.drive.actions import add_action, add_move, answer, move
from spiraltrunk.cli.verbs.drive.move_check import check_lengths, read_move, warn_short
from spiraltrunk.cli.verbs.drive.pose_file import add_poses_file, read_poses, save_pose
from spiraltrunk.cli.verbs.drive.robot import open_robot


def add_pose(actions: Any, name: str) -> None:
    """Add the action that moves to a pose."""
    parser = add_action(actions, name, _pose, "home, and move to a pose that was saved, or save one")
    parser.add_argument("pose", type=read_text, metavar="NAME", help="name of the pose")
    parser.add_argument(
        "--save", type=read_number, nargs="+", metavar="MM",
        help="save a pose of this name with so much of each cable wound in, and move nothing",
    )  # fmt: skip
    add_poses_file(parser)
    add_move(parser)


def add_ports(actions: Any, name: str) -> None:
    """Add the action that lists ports."""
    add_action(actions, name, _ports, "list CAN adapters and serial ports, and with --bus the motors that answer there")


def _pose(arguments: argparse.Namespace) -> Answer:
    from spiraltrunk.design import load_design
    from spiraltrunk.hardware.setup.poses import find_pose

    design = load_design(arguments.design)
    if arguments.save is not None:
        check_lengths(design, arguments.save)
        save_pose(arguments, design, [1e-3 * pull for pull in arguments.save], arguments.pose)
        told = {
            "saved": arguments.pose,
            "pull_mm": [float(pull) + 0.0 for pull in arguments.save],
            "file": arguments.poses,
        }
        return DONE, format_json(told) if arguments.json else f"{arguments.pose} is saved in {arguments.poses}"
    settings = read_move(arguments, design)
    pose = find_pose(read_poses(arguments, design), arguments.pose)
    with open_robot(arguments) as robot:
        robot.prepare()
        move(robot, list(pose.pulls), settings)
        end = robot.finish()
        warn_short(robot.compute_pulls(end), list(pose.pulls))
        return answer(arguments, end)


def _ports(arguments: argparse.Namespace) -> Answer:
    from spiraltrunk.cli.verbs.drive.robot import read_robot_file
    from spiraltrunk.design import load_design
    from spiraltrunk.hardware.bus.bus_address import parse_bus_address
    from spiraltrunk.hardware.setup.ports import ask_ids, find_ports

    file = read_robot_file(arguments, load_design(arguments.design))
    found = find_ports()
    ids = None if file is None else list(ask_ids(parse_bus_address(file.bus)))
    if arguments.json:
        bus = None if file is None else file.bus
        return DONE, format_json({"can": list(found.can), "serial": list(found.serial), "bus": bus, "ids": ids})
    lines = [f"CAN adapters: {', '.join(found.can) or 'none'}", f"serial ports: {', '.join(found.serial) or 'none'}"]
    if file is not None and ids is not None:
        lines.append(f"motors on {file.bus}: {', '.join(map(str, ids)) or 'none answered'}")
    return DONE, "\n".join(lines)
