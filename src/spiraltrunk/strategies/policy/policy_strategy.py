"""A policy with stages as a strategy: set points of base and cables at every decision, smoothed in between."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from spiraltrunk.control.encoding import action_names, decode_action, encode_command
from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.control.strategy import SCENE_FIELDS, Milestone, Status, Strategy
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.strategies.policy.description import PolicyDescription
from spiraltrunk.strategies.policy.memory import (
    MODE,
    Memory,
    begin_memory,
    build_inputs,
    enter_stage,
    list_inputs,
    observe,
)
from spiraltrunk.strategies.policy.network import Network, forward
from spiraltrunk.strategies.policy.smoothing import Filtered, follow
from spiraltrunk.strategies.sensing import limit_ventral_lead

END = "end"
"""Name of the stage at whose start a policy ends."""


@final
@dataclass(frozen=True, kw_only=True)
class PolicyState:
    """What a policy remembers."""

    memory: Memory
    """Stage and load."""
    goal: np.ndarray
    """Encoded set point of the last decision, shape (n_action,) [-]."""
    smooth: Filtered
    """The set point as commanded, smoothed."""
    decided: float
    """Time of the last decision [s]; minus infinity before the first."""
    command: Command | None = None
    """The last command."""
    gave_up: str | None = None
    """Why it ended before its goal, if it did."""
    is_done: bool = False
    """Whether it has ended."""


@final
class PolicyStrategy(Strategy[PolicyState]):
    """A learned policy of the control mode "pose-tension".

    Args:
        name: its name in tables.
        description: what its networks take and give.
        networks: "stage", whose largest output is the next stage, and "action", the encoded set point.
    """

    number = 0

    def __init__(self, name: str, description: PolicyDescription, networks: dict[str, Network]) -> None:
        take_over(self, name, description)
        self._description, self._networks = description, networks
        self._stages = tuple(stage.name for stage in description.stages)
        self._allowed = [
            [j for j, n in enumerate(self._stages) if not s.after or n in s.after] for s in description.stages
        ]
        self._latches = {i for i, stage in enumerate(self._stages) if stage in description.latches}

    def widths(self, design: TrunkDesign) -> tuple[float, float]:
        """Least and greatest width of the objects that it was trained for [m]."""
        return self._description.widths

    def init(self, observation: Observation) -> PolicyState:
        """Begin in the first stage.

        Raises:
            ModelError: where trunk or arm has other observations than the policy was trained with.
        """
        self._check_robot(observation.task.design, len(observation.arm_position))
        still = Command(T_world_base=observation.T_world_base, cable_tension=np.zeros(observation.cable_tension.shape))
        start = encode_command(MODE, still, still, observation.task).action.astype(float)
        return PolicyState(
            memory=begin_memory(observation, start), goal=start, decided=-np.inf,
            smooth=Filtered(value=start, rate=np.zeros(start.shape)),
        )  # fmt: skip

    def step(self, state: PolicyState, observation: Observation) -> tuple[PolicyState, Command]:
        """Decide where it is time to, and follow the last decision."""
        about, passed = self._description, observation.time - state.memory.time
        state = replace(state, memory=observe(state.memory, observation))
        if observation.time >= state.decided + about.period - 1e-9:
            state = self._decide(state, observation)
        smooth = follow(state.smooth, state.goal, about.smoothing, passed) if passed > 0 else state.smooth
        command = self._command(smooth.value, state.command, observation)
        return replace(state, smooth=smooth, command=command), command

    def status(self, state: PolicyState) -> Status:
        """Stage, and the milestone that it reports."""
        stage = self._description.stages[state.memory.stage]
        milestone = None if stage.milestone is None else Milestone(stage.milestone)
        return Status(
            phase=stage.phase, action=stage.name, milestone=milestone, is_done=state.is_done, gave_up=state.gave_up
        )

    def _decide(self, state: PolicyState, observation: Observation) -> PolicyState:
        """The next stage, and the set point in it."""
        memory, n_stage = state.memory, len(self._stages)
        inputs = build_inputs(memory, observation, state.command, n_stage)
        stage = self._choose_stage(memory, forward(self._networks["stage"], inputs))
        if stage != memory.stage:
            start = state.smooth.value
            memory = enter_stage(memory, stage, observation, start, latches=stage in self._latches)
            inputs = build_inputs(memory, observation, state.command, n_stage)
        goal = np.clip(forward(self._networks["action"], inputs), -1.0, 1.0)
        is_late = observation.time > self._description.longest
        return replace(
            state, memory=memory, goal=goal, decided=observation.time,
            is_done=is_late or self._stages[stage] == END,
            gave_up=f"not done after {self._description.longest:g} s" if is_late else None,
        )  # fmt: skip

    def _choose_stage(self, memory: Memory, score: np.ndarray) -> int:
        """The stage of the largest score among the present one and those that may follow, within its times.

        One that was entered as often as allowed is left out, unless it is the only one.
        """
        here, stages = memory.stage, self._description.stages
        about, spent = stages[here], memory.time - memory.since
        others = [j for j in self._allowed[here] if j != here]
        others = [j for j in others if memory.visits.count(j) < stages[j].visits] or others
        if not others or spent < about.least - 1e-9:
            return here
        known = others if spent > about.most else [here, *others]
        return max(known, key=lambda j: float(score[j]))

    def _command(self, point: np.ndarray, before: Command | None, observation: Observation) -> Command:
        slack = Command(T_world_base=observation.T_world_base, cable_tension=np.zeros(observation.cable_tension.shape))
        command = decode_action(MODE, point, slack if before is None else before, observation.task)
        lead = self._description.ventral_lead
        return command if lead is None else replace(command, cable_pull=limit_ventral_lead(observation, lead))

    def _check_robot(self, design: TrunkDesign, n_arm: int) -> None:
        if design.n_cable != self._description.n_cable:
            raise ModelError(f"the trunk has {design.n_cable} cables; allowed: {self._description.n_cable}, as trained")
        for kind, given, known in (
            ("inputs", self._description.inputs, list_inputs(design, self._stages, n_arm)),
            ("outputs", self._description.outputs, action_names(MODE, design)),
        ):
            if given != known:
                raise ModelError(
                    f"{self.name} has other {kind} than this version with an arm of {n_arm} joints: "
                    f"{describe_difference(given, known)}; allowed: a policy that this version trained for such a robot"
                )


def describe_difference(given: tuple[str, ...], known: tuple[str, ...]) -> str:
    """The first name that differs between two lists of names."""
    for ours, theirs in zip(given, known, strict=False):
        if ours != theirs:
            return f"{ours!r}, not {theirs!r}"
    return f"{len(given)}, not {len(known)}"


def take_over(strategy: Strategy[Any], name: str, description: PolicyDescription) -> None:
    """Set the name of a strategy, and its job, support and objects to those that a policy was trained for."""
    strategy.name = name
    for key in SCENE_FIELDS:
        setattr(strategy, key, getattr(description, key))
