"""Policies of environments as strategies: a function from what is observed to an action."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from spiraltrunk.checks import check_number
from spiraltrunk.control.encoding import (
    ControlMode,
    Setpoint,
    begin_setpoint,
    encode_agent,
    encode_environment,
    follow_action,
    parse_control_mode,
    read_periods,
)
from spiraltrunk.control.loop import LONGEST
from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.control.strategy import SCENE_FIELDS, Status, Strategy
from spiraltrunk.errors import DesignError

Policy = Callable[[Mapping[str, np.ndarray]], np.ndarray]
"""From a dictionary with "agent_pos" and "environment_state", as of an environment, to an action in [-1, 1]."""


@final
@dataclass(frozen=True, kw_only=True)
class ActionState:
    """What the strategy remembers."""

    setpoint: Setpoint
    """Set point of the last control period."""
    action: np.ndarray
    """The present action [-]."""
    count: int = 0
    """Control periods so far [-]."""
    is_done: bool = False
    """Whether its time is over."""


@final
class ActionPolicy(Strategy[ActionState]):
    """A policy of an environment as a strategy, for any plant and for surveys; it commands as in the environment.

    It reports no milestones: in simulation the verdict's referee finds them. It ends when its time is over.

    Args:
        policy: the policy; equal observations must give equal actions.
        scene: strategy whose job, objects and scenes it has.
        name: its name.
        control_mode: what its actions set; not the mode that sets joints, which a strategy cannot command.
        control_hz: its actions in a second, of which 50 is a whole multiple [1/s].
        duration: time after which it ends [s].

    Raises:
        UnknownName: for a control mode that does not exist.
        DesignError: for another value that is not allowed.
    """

    number = 0

    def __init__(
        self,
        policy: Policy,
        scene: Strategy[Any],
        *,
        name: str = "policy",
        control_mode: str | ControlMode = ControlMode.DELTA_POSE_TENSION,
        control_hz: float = 50.0,
        duration: float = 60.0,
    ) -> None:
        self._policy, self.name = policy, name
        self._mode = parse_control_mode(control_mode)
        if self._mode.sets_joints:
            raise DesignError("control_mode", got=self._mode.value, allowed="a mode that sets the base")
        check_number("duration", duration, above=0.0, below=LONGEST)
        self._periods, self._duration = read_periods(control_hz), duration
        for each in SCENE_FIELDS:
            setattr(self, each, getattr(scene, each))
        self._scene = scene

    def widths(self, design: Any) -> tuple[float, float]:
        """Least and greatest width of the objects of the strategy whose scenes it has [m]."""
        return self._scene.widths(design)

    def grasp_task(self, task: Any) -> Any:
        """The task of the grasp in the strategy whose scenes it has."""
        return self._scene.grasp_task(task)

    def highest_base(self, task: Any) -> float | None:
        """Largest height of the base in the strategy whose scenes it has, which sets the ground [m].

        Raises:
            ModelError: where the robot cannot do what the task asks.
        """
        return self._scene.highest_base(task)

    def base_path(self, observation: Observation) -> tuple[np.ndarray, ...] | None:
        """Path of the base in the strategy whose scenes it has, which sets the object's place, each (4, 4) [-, m].

        Raises:
            ModelError: where the robot cannot do what the task asks.
        """
        return self._scene.base_path(observation)

    def init(self, observation: Observation) -> ActionState:
        """The base stays where it is, cables and gripper are slack."""
        return ActionState(setpoint=begin_setpoint(observation), action=np.zeros(0))

    def step(self, state: ActionState, observation: Observation) -> tuple[ActionState, Command]:
        """The set point on the way to the present action; a new action at the start of each."""
        if observation.time >= self._duration - 1e-9:
            return replace(state, is_done=True), state.setpoint.command
        period, action = state.count % self._periods, state.action
        if period == 0:
            seen = {
                "agent_pos": encode_agent(observation, state.setpoint.command),
                "environment_state": encode_environment(observation),
            }
            action = np.asarray(self._policy(seen))
        setpoint = follow_action(
            state.setpoint, self._mode, action, observation, period=period, periods=self._periods
        )  # fmt: skip
        return ActionState(setpoint=setpoint, action=action, count=state.count + 1), setpoint.command

    def status(self, state: ActionState) -> Status:
        """In one phase, without a milestone."""
        return Status(phase="transport", action="policy", is_done=state.is_done)
