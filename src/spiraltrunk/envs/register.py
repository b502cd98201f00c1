"""Registration of the environments with Gymnasium."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from typing import Any

import gymnasium

from spiraltrunk.envs.trunk_env import TrunkEnv

IDS: Mapping[str, Mapping[str, Any]] = {
    "spiraltrunk/Grasp-v0": {"job": "grasp", "stage": "hung", "episode_s": 60.0},
    "spiraltrunk/Kick-v0": {"job": "kick", "stage": "ground", "episode_s": 20.0},
    "spiraltrunk/Sweep-v0": {"job": "sweep", "stage": "ground", "episode_s": 90.0},
}
"""Name of each environment, and its arguments that are not the defaults of `TrunkEnv`."""


def register_envs() -> None:
    """Register every environment once; its specification has all arguments."""
    for name, given in IDS.items():
        if name not in gymnasium.registry:
            gymnasium.register(
                name, entry_point="spiraltrunk.envs.trunk_env:TrunkEnv", kwargs={**_read_defaults(), **given}
            )


def _read_defaults() -> dict[str, Any]:
    """Default of every argument but the render mode, which `gymnasium.make` gives."""
    arguments = inspect.signature(TrunkEnv).parameters.values()
    return {each.name: each.default for each in arguments if each.name != "render_mode"}
