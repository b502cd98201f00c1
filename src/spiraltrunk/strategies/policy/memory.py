"""Memory of a policy with stages, and the numbers that its networks take: observation, task and memory.

A network without memory cannot wait, nor can it know which load it has weighed. So a policy remembers the stage that it
is in, when and from where that stage began, and the load at the start of some stages.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.control.encoding import (
    ControlMode,
    action_names,
    agent_names,
    encode_agent,
    encode_environment,
    environment_names,
)
from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.strategies.sensing import lever, weight

MODE = ControlMode.POSE_TENSION
"""How set points are encoded: pose of the base in the frame of the announced object, and tensions."""

TIMES = (0.5, 1.0, 2.0, 4.0, 12.0)
"""Bounds of the time since a stage began that networks take, each clipped to one of them [s] (ours)."""

_WEIGHT_TIME, _LEVER_TIME = 0.1, 0.4
"""Time constants of the means of the load's weight and lever [s] (ours)."""


@final
@dataclass(frozen=True, kw_only=True)
class Memory:
    """What a policy remembers between two steps."""

    stage: int
    """Index of the present stage."""
    since: float
    """Time at which it began [s]."""
    start: np.ndarray
    """Set point at its start, encoded, shape (n_action,) [-]."""
    start_pull: np.ndarray
    """Measured pulls at its start, shape (n_cable,) [m]."""
    time: float
    """Time of the latest observation [s]."""
    load: np.ndarray
    """Weight on the base and its lever, smoothed, shape (2,) [N, m]."""
    visits: tuple[int, ...] = (0,)
    """Stages entered so far, the first among them, in order."""
    latched: np.ndarray
    """Load and pulls at the start of the latest stage that latches them, shape (2 + n_cable,) [N, m, m]."""


def begin_memory(observation: Observation, start: np.ndarray) -> Memory:
    """Memory at the first observation, in the first stage."""
    load = measure_load(observation)
    return Memory(
        stage=0, since=observation.time, start=start, start_pull=observation.cable_pull, time=observation.time,
        load=load, latched=np.concatenate([load, observation.cable_pull]),
    )  # fmt: skip


def observe(memory: Memory, observation: Observation) -> Memory:
    """Memory after an observation: exponential means of the load."""
    step = observation.time - memory.time
    share = 1.0 - np.exp(-step / np.array([_WEIGHT_TIME, _LEVER_TIME]))
    load = memory.load + share * (measure_load(observation) - memory.load)
    return replace(memory, load=load, time=observation.time)


def enter_stage(memory: Memory, stage: int, observation: Observation, start: np.ndarray, *, latches: bool) -> Memory:
    """Memory at the start of a stage, from the set point at that time."""
    latched = np.concatenate([memory.load, observation.cable_pull]) if latches else memory.latched
    return replace(
        memory, stage=stage, since=observation.time, start=start, start_pull=observation.cable_pull, latched=latched,
        visits=(*memory.visits, stage),
    )  # fmt: skip


def measure_load(observation: Observation) -> np.ndarray:
    """Weight on the base and its lever along the object's axis, shape (2,) [N, m]."""
    return np.array([weight(observation), lever(observation)])


def list_inputs(design: TrunkDesign, stages: tuple[str, ...], n_arm: int = 7) -> tuple[str, ...]:
    """Name of each number of `build_inputs`, in order, for an arm of ``n_arm`` joints."""
    cables = range(1, design.n_cable + 1)
    return (
        *agent_names(design, n_arm), *environment_names(),
        *(f"stage_is_{name}" for name in stages),
        *(f"stage_time_to_{bound:g}_s" for bound in TIMES),
        *(f"stage_start_{name}" for name in action_names(MODE, design)),
        *(f"stage_start_pull_{c}" for c in cables),
        "load_weight", "load_lever", "latched_weight", "latched_lever", *(f"latched_pull_{c}" for c in cables),
    )  # fmt: skip


def build_inputs(memory: Memory, observation: Observation, command: Command | None, n_stage: int) -> np.ndarray:
    """The numbers that a network takes, in SI units, shape (n_input,).

    Args:
        memory: what the policy remembers.
        observation: what the robot measures.
        command: the last command; None before the first.
        n_stage: number of the policy's stages.
    """
    stage = np.zeros(n_stage)
    stage[memory.stage : memory.stage + 1] = 1.0
    return np.concatenate([
        encode_agent(observation, command), encode_environment(observation), stage,
        np.minimum(observation.time - memory.since, TIMES), memory.start, memory.start_pull, memory.load,
        memory.latched,
    ])  # fmt: skip
