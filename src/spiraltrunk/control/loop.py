"""Control loop of a plant and a strategy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from numbers import Real
from time import perf_counter
from typing import Any, final

from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.control.plant import Plant
from spiraltrunk.control.strategy import Milestone, Status, Strategy
from spiraltrunk.errors import RunError, describe
from spiraltrunk.field_docs import explain_fields

LONGEST = 300.0
"""Simulated or real time after which a run is stopped [s]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class RunLog:
    """Log of a run: every message between plant and strategy."""

    observations: tuple[Observation, ...]
    """Observations, one more than commands: the first is from reset."""
    commands: tuple[Command, ...]
    """Commands of the strategy."""
    statuses: tuple[Status, ...]
    """Status of the strategy at each command."""
    gave_up: str | None
    """Why the strategy ended before its goal, if it did."""
    planning: float = 0.0
    """Wall time of the strategy's `init` [s]."""
    state: Any = None
    """State of the strategy at the end."""

    def span(self, phase: str, action: str | None = None) -> tuple[float, float] | None:
        """First and last time of a phase, or of one action in it [s]; None where it never came."""
        return self._span([s.phase == phase and action in (None, s.action) for s in self.statuses])

    def milestone_span(self, milestone: Milestone) -> tuple[float, float] | None:
        """Start of the first attempt at a milestone and end of the last one [s]; None where none was reported."""
        return self._span([s.milestone is milestone for s in self.statuses])

    def _span(self, is_part: list[bool]) -> tuple[float, float] | None:
        times = [seen.time for seen, holds in zip(self.observations[1:], is_part, strict=True) if holds]
        return (times[0], times[-1]) if times else None


def run(plant: Plant, strategy: Strategy[Any], *, watch: Callable[[Observation, Status], None] | None = None) -> RunLog:
    """Reset the plant and run the strategy on it until the strategy is done.

    Args:
        plant: simulator or hardware.
        strategy: what to do.
        watch: called after every step with its observation and status; an exception in it ends the run.

    Raises:
        RunError: where an argument or a returned value has the wrong type, where time does not advance, where the plant
            cannot go on, and after LONGEST seconds.
    """
    _check_arguments(plant, strategy, watch)
    observation = _read_observation(plant.reset(), "reset")
    began = perf_counter()
    state = strategy.init(observation)
    planning = perf_counter() - began
    observations, commands, statuses = [observation], [], []
    while True:
        state, command = _read_step(strategy.step(state, observation))
        status = _read_status(strategy.status(state))
        if status.is_done:
            break
        before, observation = observation.time, _read_observation(plant.step(command), "step")
        if not observation.time > before:
            raise RunError(f"the plant's time went from {before!r} to {observation.time!r} s; allowed: forward")
        observations.append(observation)
        commands.append(command)
        statuses.append(status)
        if watch is not None:
            watch(observation, status)
        if observation.time > LONGEST:
            raise RunError(f"{strategy.name} did not end in {LONGEST:g} s")
    if status.gave_up and statuses:
        statuses[-1] = status
    return RunLog(
        observations=tuple(observations), commands=tuple(commands), statuses=tuple(statuses), gave_up=status.gave_up,
        planning=planning, state=state,
    )  # fmt: skip


def _check_arguments(plant: object, strategy: object, watch: object) -> None:
    _check(_has(plant, "reset", "step"), "plant is", plant, "a Plant, such as spiraltrunk.sim.SimPlant()")
    allowed = "a Strategy, such as spiraltrunk.strategies.get('wrap-vertical')"
    _check(_has(strategy, "init", "step", "status"), "strategy is", strategy, allowed)
    _check(watch is None or callable(watch), "watch is", watch, "a function of an observation and a status")


def _read_observation(value: Observation, call: str) -> Observation:
    _check(isinstance(getattr(value, "time", None), Real), f"plant.{call} returned", value, "an Observation")
    return value


def _read_step(value: tuple[Any, Command]) -> tuple[Any, Command]:
    is_pair = isinstance(value, tuple) and len(value) == 2
    _check(is_pair, "strategy.step returned", value, "a pair of a state and a Command")
    return value


def _read_status(value: Status) -> Status:
    _check(isinstance(value, Status), "strategy.status returned", value, "a Status")
    has_milestone = isinstance(value.milestone, Milestone | None)
    _check(has_milestone, "status.milestone is", value.milestone, "a Milestone, or None")
    return value


def _has(value: object, *methods: str) -> bool:
    return not isinstance(value, type) and all(callable(getattr(value, method, None)) for method in methods)


def _check(is_right: bool, what: str, value: object, allowed: str) -> None:
    if not is_right:
        raise RunError(f"{what} {describe(value)}; allowed: {allowed}")
