"""Strategies as agents of an environment: their commands as its actions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, final

import gymnasium
import numpy as np

from spiraltrunk.control.messages import Command
from spiraltrunk.control.strategy import Status, Strategy
from spiraltrunk.envs.trunk_env import TrunkEnv
from spiraltrunk.errors import DesignError, RunError


@final
class StrategyAgent:
    """Chooses the actions of an environment by a strategy, which sees what it would see on a robot.

    The control modes that set tensions and pulls tell its commands in full; others leave pulls or tensions out, which
    `dropped` tells. Rounding to float32 moves a command by less than a micrometre.

    Args:
        env: the environment, wrapped or not, of `TrunkEnv`.
        strategy: the strategy.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], strategy: Strategy[Any]) -> None:
        base = env.unwrapped
        if not isinstance(base, TrunkEnv):
            raise DesignError("env", got=base, allowed="an environment of spiraltrunk.envs")
        self._env, self._strategy, self._state = base, strategy, None
        self.is_done = False
        """Whether the strategy has ended; it holds still from then on."""
        self.clipped = 0.0
        """Largest amount by which a command was beyond the range of actions [-]."""
        self.dropped: set[str] = set()
        """Parts of its commands that the control mode cannot express."""

    def reset(self) -> None:
        """Plan from the first observation, after a reset of the environment.

        Raises:
            ModelError: where the strategy cannot plan for the object.
        """
        self._state = self._strategy.init(self._env.observation)
        self.is_done, self.clipped, self.dropped = False, 0.0, set()

    @property
    def status(self) -> Status:
        """The strategy's status.

        Raises:
            RunError: before `reset`.
        """
        if self._state is None:
            raise RunError("the agent has no plan; allowed: env.reset, agent.reset, then this")
        return self._strategy.status(self._state)

    def command(self) -> Command:
        """The strategy's command at the environment's last observation; its last one once it has ended.

        Raises:
            RunError: before `reset`.
        """
        assert self.status is not None
        if self.is_done:
            return self._env.setpoint.command
        self._state, command = self._strategy.step(self._state, self._env.observation)
        self.is_done = self.status.is_done
        return self._env.setpoint.command if self.is_done else command

    def act(self) -> np.ndarray:
        """The command as an action.

        Raises:
            RunError: before `reset`.
        """
        encoded = self._env.encode_command(self.command())
        self.clipped = max(self.clipped, encoded.clipped)
        self.dropped |= set(encoded.dropped)
        return encoded.action


def drive(
    env: gymnasium.Env[Any, Any],
    strategy: Strategy[Any],
    *,
    seed: int | None = None,
    options: Mapping[str, Any] | None = None,
) -> tuple[float, dict[str, Any]]:
    """Run an episode by a strategy until it ends, or the strategy does.

    Returns:
        Sum of the rewards, and the last info.

    Raises:
        ModelError: where the strategy cannot plan for the object.
    """
    agent, total = StrategyAgent(env, strategy), 0.0
    _, info = env.reset(seed=seed, options=None if options is None else dict(options))
    agent.reset()
    while True:
        action = agent.act()
        if agent.is_done:
            return total, info
        _, reward, is_terminated, is_truncated, info = env.step(action)
        total += float(reward)
        if is_terminated or is_truncated:
            return total, info
