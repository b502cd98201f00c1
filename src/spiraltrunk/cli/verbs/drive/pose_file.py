"""The file of poses of a command."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

from spiraltrunk.cli.arguments import Parser, read_text

if TYPE_CHECKING:
    from spiraltrunk.design.trunk import TrunkDesign
    from spiraltrunk.hardware.setup.poses import Pose


def add_poses_file(parser: Parser) -> None:
    """Add where poses are kept."""
    parser.add_argument(
        "--poses", type=read_text, default="poses.json", metavar="FILE", help="file of poses (default poses.json)"
    )


def read_poses(arguments: argparse.Namespace, design: TrunkDesign) -> dict[str, Pose]:
    """Poses of the file by name."""
    from spiraltrunk.hardware.setup.poses import load_poses
    from spiraltrunk.workflows.drive.gamepad_jog import compute_pull_limits

    return load_poses(arguments.poses, compute_pull_limits(design))


def check_save(arguments: argparse.Namespace, design: TrunkDesign, name: str) -> None:
    """Refuse, before anything moves, what `save_pose` would refuse after it.

    Raises:
        DesignError: for a name that no pose has.
        DriveError: for a file that holds no poses.
        OutputError: for a file that cannot be written.
    """
    from spiraltrunk.hardware.setup.poses import Pose, check_poses_place

    Pose(name, ())
    read_poses(arguments, design)
    check_poses_place(arguments.poses)


def save_pose(arguments: argparse.Namespace, design: TrunkDesign, pulls: Sequence[float], name: str) -> None:
    """Save a pose under a name; one of the same name is replaced."""
    from spiraltrunk.hardware.setup import poses
    from spiraltrunk.workflows.drive.gamepad_jog import compute_pull_limits

    poses.save_pose(arguments.poses, poses.Pose(name, tuple(pulls)), compute_pull_limits(design))
