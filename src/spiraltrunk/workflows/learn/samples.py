"""Samples of recorded episodes for behaviour cloning: inputs of a policy at each step, and its wanted outputs.

The policy's own code makes the inputs, step by step, so that training and use agree. A sample at a step has the stage
of the last decision, one period before, and asks for the stage now and the encoded set point a little later in the same
stage: the filter of the set points lags by twice its time constant, a held decision by half of its period.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import final

import numpy as np

from spiraltrunk.control.encoding import encode_command
from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.strategies.policy.description import Stage
from spiraltrunk.strategies.policy.memory import MODE, Memory, begin_memory, build_inputs, enter_stage, observe
from spiraltrunk.strategies.policy.policy_strategy import END
from spiraltrunk.workflows.learn.episodes import Episode

EVERY = 2
"""Steps from one sample to the next (ours): neighbours differ little."""

LONGER, LATER = 1.2, 0.3
"""Longest time in a stage: that of the demonstrations times the first, plus the second [-, s] (ours)."""


@final
@dataclass(frozen=True, kw_only=True)
class Timing:
    """Times of a policy's decisions."""

    period: float = 0.04
    """Time between two decisions [s]: at 0.1 s a stiff trunk that touches the table loads the arm to its limit."""
    smoothing: float = 0.1
    """Time constant of the set points' filter [s]."""

    @property
    def ticks(self) -> int:
        """Steps between two decisions."""
        return round(self.period / CONTROL_PERIOD)

    @property
    def ahead(self) -> int:
        """Steps from a sample to the set point that it asks for: the lag of the filter and of a held decision."""
        return round((2 * self.smoothing + self.period / 2) / CONTROL_PERIOD)


@final
@dataclass(frozen=True, kw_only=True)
class Samples:
    """Samples of one episode; every array begins with n_sample."""

    before: np.ndarray
    """Inputs with the stage of the last decision, shape (n_sample, n_input)."""
    now: np.ndarray
    """Inputs with the present stage, shape (n_sample, n_input)."""
    stage: np.ndarray
    """Index of the present stage, shape (n_sample,)."""
    goal: np.ndarray
    """Encoded set point to ask for, shape (n_sample, n_action) [-]."""


def list_stages(episodes: Sequence[Episode]) -> tuple[Stage, ...]:
    """Stages of all episodes in the order in which they first come, and the end.

    Each has the times that the episodes stayed in it, those that came next, and how often it came at most.
    """
    reported: dict[str, tuple[str, str, str]] = {}
    times: dict[str, list[float]] = {}
    after: dict[str, dict[str, None]] = {}
    visits: dict[str, int] = {}
    for episode in episodes:
        runs = [(each, sum(1 for _ in steps)) for each, steps in groupby(episode.reported)]
        names = [name_stage(*each) for each, _ in runs]
        for (each, steps), name, following in zip(runs, names, [*names[1:], END], strict=True):
            reported.setdefault(name, each)
            times.setdefault(name, []).append(steps * CONTROL_PERIOD)
            after.setdefault(name, {})[following] = None
            visits[name] = max(visits.get(name, 0), names.count(name))
    last = episodes[0].reported[-1]
    return (
        *(
            replace(_build_stage(name, reported[name], times[name], tuple(after[name])), visits=visits[name])
            for name in reported
        ),
        Stage(name=END, phase=last[0], milestone=last[2] or None),
    )


def _build_stage(name: str, reported: tuple[str, str, str], times: Sequence[float], after: tuple[str, ...]) -> Stage:
    return Stage(
        name=name, phase=reported[0], milestone=reported[2] or None, least=round(min(times), 3),
        most=round(LONGER * max(times) + LATER, 3), after=after,
    )  # fmt: skip


def name_stage(phase: str, action: str, milestone: str) -> str:
    """Name of a stage, unique for its phase, action and milestone."""
    return f"{phase}: {action}" + (f" ({milestone})" if milestone else "")


def sample_episode(episode: Episode, stages: Sequence[Stage], latches: Sequence[str], timing: Timing) -> Samples:
    """Samples of an episode, one of EVERY steps."""
    place = {stage.name: i for i, stage in enumerate(stages)}
    index = np.array([place[name_stage(*each)] for each in episode.reported] + [len(stages) - 1])
    goals = _encode_commands(episode)
    latching = {place[name] for name in latches}
    memories = _remember(episode, index, goals, latching)
    rows: list[tuple[np.ndarray, np.ndarray]] = []
    chosen = np.arange(0, len(index), EVERY)
    for i in chosen.tolist():
        observation, command = episode.observations[i], episode.commands[i - 1] if i else None
        last = memories[max(0, i - timing.ticks)]
        held = replace(last, time=memories[i].time, load=memories[i].load)
        rows.append((
            build_inputs(held, observation, command, len(stages)),
            build_inputs(memories[i], observation, command, len(stages)),
        ))  # fmt: skip
    before, now = (np.array([row[side] for row in rows], dtype=np.float32) for side in (0, 1))
    ends = _find_ends(index)
    ahead = np.minimum(np.minimum(np.arange(len(index)) + timing.ahead, ends), len(goals) - 1)
    return Samples(before=before, now=now, stage=index[chosen], goal=goals[ahead[chosen]].astype(np.float32))


def _encode_commands(episode: Episode) -> np.ndarray:
    """Encoded set points, shape (n_step, n_action) [-]."""
    before = episode.commands[0]
    return np.array([encode_command(MODE, each, before, episode.task).action for each in episode.commands])


def _remember(episode: Episode, index: np.ndarray, goals: np.ndarray, latching: set[int]) -> list[Memory]:
    """Memory of the policy at each step, if it had decided as the episode did."""
    memory = begin_memory(episode.observations[0], goals[0].astype(float))
    memory = replace(memory, stage=int(index[0]))
    memories = []
    for i, observation in enumerate(episode.observations):
        memory = observe(memory, observation) if i else memory
        if index[i] != memory.stage:
            start = goals[i - 1].astype(float)
            memory = enter_stage(memory, int(index[i]), observation, start, latches=int(index[i]) in latching)
        memories.append(memory)
    return memories


def _find_ends(index: np.ndarray) -> np.ndarray:
    """Last step of the stage that each step is in."""
    ends, last = np.zeros(len(index), dtype=int), len(index) - 1
    for i in range(len(index) - 1, -1, -1):
        last = i if i + 1 == len(index) or index[i] != index[i + 1] else last
        ends[i] = last
    return ends
