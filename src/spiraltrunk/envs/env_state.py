"""State of an environment between two steps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from spiraltrunk.checks import check_type
from spiraltrunk.control.encoding import Setpoint
from spiraltrunk.control.messages import Observation
from spiraltrunk.envs.worlds import World
from spiraltrunk.errors import DesignError, Unquoted, describe
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.sim.plant_state import PlantState
from spiraltrunk.workflows.grasp.verdict.moments import Referee


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class EpisodeState:
    """Everything that the next steps of an episode depend on."""

    plant: PlantState
    """State of robot and object, with the trace so far."""
    observation: Observation
    """The last observation."""
    setpoint: Setpoint
    """The set point of the last step."""
    joints: tuple[np.ndarray, ...]
    """State of the set points of the arm's joints, for the mode that sets them."""
    referee: Referee
    """What the referee has found."""
    potential: float
    """Potential of the dense reward [-]."""
    steps: int
    """Steps since the reset."""
    is_over: bool
    """Whether the episode has ended."""
    is_rewarded: bool
    """Whether a success was rewarded, which is once in an episode."""
    quiet: int
    """Control periods for which the object has rested untouched [-]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class EnvState:
    """Everything that the next steps of an environment depend on, for one made with the same arguments.

    `TrunkEnv.set_state` restores it bit for bit, in the environment that it is from, in another, or in another process.
    """

    arguments: Mapping[str, Any]
    """Arguments of the environment that the steps of an episode depend on."""
    world: World
    """The world."""
    episode: EpisodeState
    """The episode in it."""
    generator: Mapping[str, Any]
    """State of the random generator of worlds."""


def check_state(state: object, arguments: Mapping[str, Any]) -> None:
    """Refuse the state of an environment that was made with other arguments, and anything but a state.

    Raises:
        DesignError: with the first argument that differs.
    """
    check_type("state", state, EnvState)
    assert isinstance(state, EnvState)
    for name, value in arguments.items():
        if state.arguments[name] != value:
            told = Unquoted(f"of an environment with {name} {describe(state.arguments[name])}")
            raise DesignError("state", got=told, allowed=f"one with {name} {describe(value)}, as this one")
