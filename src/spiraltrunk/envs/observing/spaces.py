"""Spaces of observations and actions."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from gymnasium import spaces

from spiraltrunk.control.encoding import ControlMode, action_size, agent_bounds, environment_bounds
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.envs.observing.privileged import privileged_bounds
from spiraltrunk.errors import DesignError, UnknownName


def read_size(size: Sequence[int]) -> tuple[int, int]:
    """Height and width of pictures, checked to be two numbers [pixels].

    Raises:
        DesignError: for anything but two numbers.
    """
    if isinstance(size, str) or not isinstance(size, Iterable) or len(sides := tuple(size)) != 2:
        raise DesignError("picture_size", got=size, allowed="height and width in pixels, such as (96, 96)")
    return sides[0], sides[1]


def read_cameras(cameras: str | Sequence[str]) -> tuple[str, ...]:
    """Names of cameras, one text for one of them; `check_cameras` refuses unknown ones.

    Raises:
        DesignError: for anything but texts, and for a camera that is named twice.
    """
    if not isinstance(cameras, Iterable):
        raise DesignError("cameras", got=cameras, allowed="names of cameras, such as ('front', 'close')")
    names = (cameras,) if isinstance(cameras, str) else tuple(cameras)
    if any(name in names[:i] for i, name in enumerate(names)):
        raise DesignError("cameras", got=names, allowed="each camera once")
    return names


def check_name(kind: str, name: str, known: Iterable[str]) -> str:
    """The name, checked to be one of those that are known.

    Raises:
        UnknownName: lists the names.
    """
    names = tuple(known)
    if not isinstance(name, str) or name not in names:
        raise UnknownName(kind, str(name), names)
    return name


def build_action_space(mode: ControlMode, design: TrunkDesign, n_arm: int) -> spaces.Box:
    """Box of actions in [-1, 1]."""
    return spaces.Box(-1.0, 1.0, (action_size(mode, design, n_arm),), np.float32)


def build_observation_space(
    design: TrunkDesign, n_arm: int, *, is_privileged: bool, cameras: tuple[str, ...], size: tuple[int, int]
) -> spaces.Dict:
    """Dictionary of finite boxes.

    Args:
        design: the robot.
        n_arm: number of the arm's joints.
        is_privileged: whether the true state is part of it.
        cameras: cameras whose pictures are part of it; one is a box, several are a dictionary of boxes.
        size: height and width of the pictures [pixels].
    """
    boxes = {"agent_pos": agent_bounds(design, n_arm), "environment_state": environment_bounds()}
    if is_privileged:
        boxes["privileged"] = privileged_bounds()
    parts: dict[str, spaces.Space[object]] = {
        name: spaces.Box(low.copy(), high.copy(), dtype=np.float32) for name, (low, high) in boxes.items()
    }
    pictures: dict[str, spaces.Space[object]] = {name: spaces.Box(0, 255, (*size, 3), np.uint8) for name in cameras}
    if len(cameras) == 1:
        parts["pixels"] = pictures[cameras[0]]
    elif cameras:
        parts["pixels"] = spaces.Dict(pictures)
    return spaces.Dict(parts)
