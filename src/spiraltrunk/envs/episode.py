"""One episode of an environment: from actions to commands, and from the truth to reward and end."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from spiraltrunk.control.encoding import (
    ArmJoints,
    ControlMode,
    EncodedAction,
    Setpoint,
    begin_setpoint,
    decode_action,
    decode_joints,
    encode_command,
    follow_action,
    restart_setpoint,
)
from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.envs.env_state import EpisodeState
from spiraltrunk.envs.evaluator import EpisodeEvaluator
from spiraltrunk.envs.joint_follower import JointFollower
from spiraltrunk.envs.rewards import FAULT, SUCCESS
from spiraltrunk.errors import RunError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.workflows.grasp.verdict.grasp_verdict import Verdict


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class EpisodeRules:
    """Rules of an episode."""

    job: str
    """"grasp", "kick" or "sweep"."""
    mode: ControlMode
    """What an action sets."""
    arm: ArmJoints
    """The arm's joints."""
    periods: int
    """Control periods of an action."""
    most_steps: int
    """Steps after which it is truncated."""
    is_dense: bool
    """Whether the reward is the change of a potential, and not only 1 at a success."""
    ends: bool
    """Whether it terminates with a success or a fault."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What a step led to."""

    reward: float
    """Reward [-]."""
    is_terminated: bool
    """Whether the episode ended with a success or a fault."""
    is_truncated: bool
    """Whether its time was over."""
    info: dict[str, Any]
    """Success, milestone, terms of the reward, time, and the reason at the end."""


@final
class Episode:
    """An episode on a plant.

    Args:
        plant: the plant, before or after its reset.
        rules: what the episode goes by.
    """

    def __init__(self, plant: SimPlant, rules: EpisodeRules) -> None:
        self.plant, self._rules = plant, rules
        self.observation: Observation = plant.reset()
        """The last observation as strategies get it."""
        self.setpoint: Setpoint = begin_setpoint(self.observation)
        """The last command, from which actions displace the base."""
        self._joints = JointFollower(plant.reach)
        self._joints.restart(self.observation.arm_position)
        self._evaluator = EpisodeEvaluator(plant, rules.job)
        self._potential = self._evaluator.potential(self._evaluator.measure())
        self._steps, self._is_over, self._is_rewarded = 0, False, False

    def follow(self, action: np.ndarray | None, command: Command | None) -> Outcome:
        """Follow an action, or a command as it is, for the control periods of a step.

        Raises:
            RunError: after the end, and for a command that is refused.
            ModelError: for an action of another size, or that is not finite.
        """
        if self._is_over:
            raise RunError("the episode has ended; allowed: reset, then step")
        plant, evaluator, fault, has_ended = self.plant, self._evaluator, "", False
        for period in range(self._rules.periods):
            try:
                self.observation = self._step_plant(action, command, period)
            except RunError:
                if not plant.has_diverged():
                    raise
                fault = "the simulation diverged"
                break
            evaluator.update(plant.trace[-1])
            fault = fault or evaluator.find_fault(plant.trace[-1])
            has_ended = has_ended or evaluator.has_ended()  # In one control period of a rest.
        self._steps += 1
        return self._finish(fault, has_ended)

    def encode_command(self, command: Command) -> EncodedAction:
        """The action whose next command is the given one, and what it leaves out."""
        rules, period = self._rules, CONTROL_PERIOD * self._rules.periods
        joints = None
        if rules.mode.sets_joints:
            joints = self.plant.reach.follow(self._joints.position, command.T_world_base, period)
        # The relative modes ask for the same displacement in each control period.
        return encode_command(
            rules.mode, command, self.setpoint.command, self.observation.task, period=period, arm=rules.arm,
            arm_position=joints,
        )  # fmt: skip

    def verdict(self) -> Verdict:
        """The survey's verdict so far."""
        return self._evaluator.verdict()

    def get_state(self) -> EpisodeState:
        """Everything that its next steps depend on."""
        return EpisodeState(
            plant=self.plant.get_state(), observation=self.observation, setpoint=self.setpoint,
            joints=self._joints.get_state(), referee=self._evaluator.referee.copy(), quiet=self._evaluator.quiet,
            potential=self._potential, steps=self._steps, is_over=self._is_over,
            is_rewarded=self._is_rewarded,
        )  # fmt: skip

    def set_state(self, state: EpisodeState) -> None:
        """Go on from a state of an episode in the same world, by the same rules."""
        self.plant.set_state(state.plant)
        self._evaluator.referee, self._evaluator.quiet = state.referee.copy(), state.quiet
        self._joints.set_state(state.joints)
        self.observation, self.setpoint = state.observation, state.setpoint
        self._potential, self._steps, self._is_over = state.potential, state.steps, state.is_over
        self._is_rewarded = state.is_rewarded

    def _step_plant(self, action: np.ndarray | None, command: Command | None, period: int) -> Observation:
        plant, rules = self.plant, self._rules
        if action is None:
            assert command is not None
            return self._step_command(command)
        if not rules.mode.sets_joints:
            self.setpoint = follow_action(
                self.setpoint, rules.mode, action, self.observation, period=period, periods=rules.periods
            )
            return plant.step(self.setpoint.command)
        task = self.observation.task
        wanted = decode_action(rules.mode, action, self.setpoint.command, task, arm=rules.arm)
        joints = self._joints.follow(decode_joints(action, rules.arm), period=period, periods=rules.periods)
        self.setpoint = restart_setpoint(replace(wanted, T_world_base=plant.reach.T_base(joints)))
        return plant.step_joints(joints, self.setpoint.command)

    def _step_command(self, command: Command) -> Observation:
        """Follow a command as it is; the set points of later actions go on from it."""
        plant = self.plant
        observation = plant.step(command)  # Before the set point, which a refused command must not become.
        self.setpoint = restart_setpoint(deepcopy(command), self.setpoint.command)  # Callers may reuse their arrays.
        if self._rules.mode.sets_joints:
            *_, last, now = [*(sample.arm_command for sample in plant.trace[-2:]), *plant.predict_arm()]
            is_moving = bool(self.setpoint.velocity.any())
            self._joints.restart(now, (now - last) / CONTROL_PERIOD if is_moving else None)
        return observation

    def _finish(self, fault: str, has_ended: bool) -> Outcome:
        """Reward, end and info of a step, in which the job may have ended."""
        evaluator, rules = self._evaluator, self._rules
        is_late = self._steps >= rules.most_steps
        verdict = evaluator.verdict() if (has_ended or is_late) and not fault else None
        is_success = verdict is not None and verdict.success
        is_terminated = rules.ends and (bool(fault) or is_success)
        terms = evaluator.measure()
        potential = evaluator.potential(terms)
        is_first, self._is_rewarded = is_success and not self._is_rewarded, self._is_rewarded or is_success
        terms["success"], terms["fault"] = float(is_first), float(bool(fault) and is_terminated)
        reward = SUCCESS * terms["success"]
        if rules.is_dense:
            reward += potential - self._potential + FAULT * terms["fault"]
        self._potential, self._is_over = potential, is_terminated or is_late
        info: dict[str, Any] = {
            "is_success": is_success, "success": is_success, "time_s": round(float(self.observation.time), 9),
            "milestone": evaluator.latest_milestone(), "reward_terms": terms,
        }  # fmt: skip
        if self._is_over:
            info["reason"] = fault or ("" if verdict is None else verdict.reason)
        return Outcome(
            reward=float(reward), is_terminated=is_terminated, is_truncated=is_late and not is_terminated, info=info
        )
