"""A strategy that chooses: the best candidate is tried, and after a failed try the next, in the same world.

A try has failed where its strategy gives up, where the camera sees the object low during the hold, or away from its
place at the end. Then the trunk lets go and the arm goes back to where it began. The camera observes the object again,
since one that has fallen over needs another plan. The candidates that were not tried yet are ranked for it
(`candidates.rank`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from spiraltrunk import strategies
from spiraltrunk.control.messages import Command, Observation, Task
from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.control.strategy import Milestone, Status, Strategy
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError, UnknownName
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.sim.objects.catalogue import ObjectSpec
from spiraltrunk.sim.robot.arm_ik import ArmReach
from spiraltrunk.strategies.moves import Move, MoveSequence, advance, begin, command_at, fraction
from spiraltrunk.strategies.policy.library import PREFIX, get_policy, is_policy
from spiraltrunk.strategies.push.sweep import with_task
from spiraltrunk.strategies.sensing import seen_position
from spiraltrunk.workflows.grasp.choice.candidates import Candidate, find_highest_base, list_strategies, rank
from spiraltrunk.workflows.grasp.choice.orientation import find_orientation
from spiraltrunk.workflows.grasp.choice.seen_task import correct_place, task_as_seen

AUTO = "auto"
"""Name of the strategy that chooses."""

MOST_TRIES = 3
"""Largest number of tries [-] (ours)."""
LATEST = 170.0
"""Time after which no further try begins [s] (ours): a run ends at 300 s."""
RISEN = 0.5
"""Share of the lift below which an object that is seen during the hold counts as dropped [-]."""
LET_GO_TIME = 1.5
"""Time in which the trunk lets go [s] (ours)."""
BACK_SPEED = 0.15
"""Mean speed of the base on its way back [m/s] (ours)."""
LOOK_TIME = 1.6
"""Time in which the camera looks again [s] (ours): three observations."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Attempt:
    """A try with one strategy."""

    strategy: str
    """Name of the strategy."""
    began: float
    """Time at which it began [s]."""
    task: Task
    """Its task, with the object as it was seen then."""
    told: Task
    """The task as its strategy is told it: the place is moved against the error of the try before."""
    candidates: tuple[Candidate, ...]
    """The ranking that it was taken from."""
    outcome: str = ""
    """Why it failed; empty for one that did not."""


@final
@dataclass(frozen=True, kw_only=True)
class AutoState:
    """What the strategy remembers."""

    candidates: tuple[Candidate, ...]
    """The ranking before anything moved."""
    attempts: tuple[Attempt, ...] = ()
    """Tries, the present one last."""
    inner: Any = None
    """State of the present try's strategy."""
    back: MoveSequence | None = None
    """Moves that bring the arm back after a failed try."""
    T_home: np.ndarray
    """Frame of the base at the start, shape (4, 4) [-, m]."""
    command: Command
    """The last command."""
    velocity: np.ndarray
    """Velocity of the base that the last two commanded, shape (3,) [m/s]."""
    low: float = 0.0
    """Height of the object as seen before the present try [m]."""
    is_done: bool = False
    """Whether the strategy has ended."""
    gave_up: str | None = None
    """Why it ended before its goal, if it did."""


Ranking = Callable[[Observation, tuple[str, ...]], tuple[Candidate, ...]]
"""Function that ranks the strategies for an observed task, without the names of those that were tried."""


@final
class Auto(Strategy[AutoState]):
    """The best strategy for the object and its stage, and after a failed try the next.

    Args:
        design: the trunk.
        stage: "ground" or "hung".
        orientation: of the object on the ground, "upright" or "lying".
        ranking: how candidates are found; by their models and the arm's reach by default.
    """

    name = AUTO
    number = 0
    needs_camera = True
    has_fixed_orientation = True
    holds = "fingers"
    job = "grasp"
    objects = (
        "cylinder-60", "cylinder-90", "cylinder-120", "box-60", "box-80", "bottle-70", "rod-20", "bar-20x20", "ball-30",
        "cube-28", "cylinder-32", "cone-35",
    )  # fmt: skip

    def __init__(
        self, design: TrunkDesign, stage: str = "ground", orientation: str = "upright", ranking: Ranking | None = None
    ) -> None:
        list_strategies(stage)  # Refuses an unknown stage.
        self.support = stage
        self.orientation = orientation if stage == "ground" else "lying"
        self.position = (0.46, 0.12) if stage == "ground" else None
        self._rank = _rank_with(ArmReach(design)) if ranking is None else ranking

    def widths(self, design: TrunkDesign) -> tuple[float, float]:
        """Any width: the ranking decides [m]."""
        return 0.0, math.inf

    def highest_base(self, task: Task) -> float | None:
        """Largest height of the base that a strategy able to do the task plans [m]; None where none plans one."""
        return find_highest_base(task)

    def init(self, observation: Observation) -> AutoState:
        """Rank the candidates and plan the first try."""
        state = AutoState(
            candidates=self._rank(observation, ()), T_home=observation.T_world_base, velocity=np.zeros(3),
            command=Command(
                T_world_base=observation.T_world_base, cable_tension=np.zeros(observation.cable_tension.shape)
            ),
        )  # fmt: skip
        return _begin_try(state, state.candidates, observation, {})

    def step(self, state: AutoState, observation: Observation) -> tuple[AutoState, Command]:
        """Go on with the present try, or with the way back from a failed one."""
        if not state.is_done:
            state = self._go_back(state, observation) if state.back is not None else self._try(state, observation)
        if state.is_done:
            return state, state.command
        if state.back is not None:
            return _remember(state, command_at(state.back, observation.time))
        attempt = state.attempts[-1]
        inner, command = strategies.get(attempt.strategy).step(state.inner, with_task(observation, attempt.told))
        return _remember(replace(state, inner=inner), command)

    def status(self, state: AutoState) -> Status:
        """Status of the present try; of the way back, "reach" without a milestone."""
        if state.is_done or not state.attempts:
            done = {} if state.inner is None else {"milestone": self._inner_status(state).milestone}
            return Status(phase="release", action="end", is_done=True, gave_up=state.gave_up, **done)
        if state.back is not None:
            return Status(phase="reach", action=state.back.move.action)
        return replace(self._inner_status(state), is_done=False, gave_up=None)

    def _inner_status(self, state: AutoState) -> Status:
        return strategies.get(state.attempts[-1].strategy).status(state.inner)

    def _try(self, state: AutoState, observation: Observation) -> AutoState:
        """End the present try where it succeeded or failed."""
        status = self._inner_status(state)
        failure = _find_failure(state, status, observation)
        if failure is not None:
            return _fail(state, failure, observation)
        return replace(state, is_done=True) if status.is_done else state

    def _go_back(self, state: AutoState, observation: Observation) -> AutoState:
        """Next move of the way back; at its end the next try."""
        assert state.back is not None
        if fraction(state.back, observation.time) < 1.0:
            return state
        if not state.back.is_last:
            return replace(state, back=advance(state.back, observation.time))
        tried = tuple(attempt.strategy for attempt in state.attempts)
        seen = with_task(observation, task_as_seen(observation))
        corrected = self._correct_place(state, seen, tried)
        return _begin_try(replace(state, back=None), self._rank(seen, tried), seen, corrected)

    def _correct_place(self, state: AutoState, seen: Observation, tried: tuple[str, ...]) -> dict[str, Task]:
        """The task with its place corrected by the error of the try before (`correct_place`), by name of the strategies
        that reach it and hold the object by the same means: fingers do not drag what a wrap has dragged.
        """
        last, status = state.attempts[-1], self._inner_status(state)
        corrected = correct_place(seen, last.told)
        if corrected is None or not status.is_done or status.gave_up is not None:
            return {}
        able = [each.strategy for each in self._rank(with_task(seen, corrected), tried) if each.feasible]
        holds = strategies.get(last.strategy).holds
        return {name: corrected for name in able if strategies.get(name).holds == holds}


def get_strategy(name: str, design: TrunkDesign, shape: ObjectSpec, stage: str | None = None) -> Strategy[Any]:
    """The strategy called ``name`` for a trunk and an object; "auto", on the ground or hung, among them.

    ``policy:FILE.safetensors`` is a learned policy.

    Raises:
        UnknownName: lists the names.
        DesignError: for the files of a policy that cannot be used.
    """
    if is_policy(name):
        return get_policy(name)
    list_objects(name)  # Refuses an unknown name.
    if name != AUTO:
        return strategies.get(name)
    return Auto(design, "ground" if stage is None else stage, find_orientation(shape))


def list_objects(name: str) -> tuple[str, ...]:
    """Objects of the catalogue for which a strategy is meant, "auto" and learned policies among them.

    Raises:
        UnknownName: lists the names.
        DesignError: for the files of a policy that cannot be used.
    """
    if is_policy(name):
        return get_policy(name).objects
    if name != AUTO and name not in strategies.NAMES:
        raise UnknownName("strategy", name, (*strategies.NAMES, AUTO, f"{PREFIX}FILE.safetensors"))
    return Auto.objects if name == AUTO else strategies.get(name).objects


def _rank_with(reach: ArmReach) -> Ranking:
    return lambda observation, tried: rank(observation, reach, but=tried)


def _remember(state: AutoState, command: Command) -> tuple[AutoState, Command]:
    way = command.T_world_base[:3, 3] - state.command.T_world_base[:3, 3]
    return replace(state, command=command, velocity=way / CONTROL_PERIOD), command


def _begin_try(
    state: AutoState, candidates: tuple[Candidate, ...], observation: Observation, corrected: dict[str, Task]
) -> AutoState:
    """Plan the first feasible candidate that has a plan, or end where there is none.

    Args:
        state: with the tries before.
        candidates: strategies that were not tried, ranked.
        observation: with the task, the object in it as it is seen.
        corrected: the task with its place corrected, by name of the strategies that are told this one instead.
    """
    low = float(seen_position(observation)[2])
    failed = {strategies.get(attempt.strategy).holds for attempt in state.attempts}
    able = [strategies.get(each.strategy) for each in candidates if each.feasible]
    for best in sorted(able, key=lambda each: each.holds in failed):  # Fingers that failed seldom hold it otherwise.
        told = corrected.get(best.name, observation.task)
        try:
            inner = best.init(with_task(observation, told))
        except ModelError:
            continue
        attempt = Attempt(
            strategy=best.name, began=observation.time, task=observation.task, told=told, candidates=candidates
        )
        return replace(state, attempts=(*state.attempts, attempt), inner=inner, low=low)
    return replace(state, is_done=True, gave_up=_describe_end(state, candidates))


def _describe_end(state: AutoState, candidates: tuple[Candidate, ...]) -> str:
    reasons = "; ".join(f"{each.strategy}: {each.reason}" for each in candidates)
    if not state.attempts:
        return f"no strategy can take it: {reasons}"
    last = state.attempts[-1]
    return f"{last.strategy}: {last.outcome}" + (f"; no other can take it: {reasons}" if reasons else "")


def _find_failure(state: AutoState, status: Status, observation: Observation) -> str | None:
    """Why the present try has failed; None where it goes on, or succeeded."""
    if status.gave_up is not None:
        return status.gave_up
    camera, goal = observation.camera, state.attempts[-1].task.goal
    if camera is None:
        return None
    if status.milestone is Milestone.HELD and camera.position[2] - state.low < RISEN * goal.lift:
        return "the object is seen low while it should be held"
    distance = float(np.linalg.norm((camera.position - goal.place)[:2]))
    if status.is_done and distance > goal.zone:
        return f"the object is seen {100 * distance:.0f} cm from its place"
    return None


def _fail(state: AutoState, outcome: str, observation: Observation) -> AutoState:
    """End the present try and plan the way back; the last one ends the strategy."""
    attempts = (*state.attempts[:-1], replace(state.attempts[-1], outcome=outcome))
    state = replace(state, attempts=attempts)
    if len(attempts) >= MOST_TRIES or observation.time > LATEST:
        return replace(state, is_done=True, gave_up=f"{attempts[-1].strategy}: {outcome}")
    return replace(state, back=_plan_way_back(state, observation))


def _plan_way_back(state: AutoState, observation: Observation) -> MoveSequence:
    """Let go, rise, return to the start and look.

    A strategy that came to its end has risen already: further up beside the object, the arm comes near a singularity.
    """
    status = strategies.get(state.attempts[-1].strategy).status(state.inner)
    has_risen = status.is_done and status.gave_up is None
    frame, home = state.command.T_world_base.copy(), state.T_home[:3, 3]
    frame[:3, 3] += CONTROL_PERIOD * state.velocity  # The base goes on for this period, else it would stop in it.
    here = frame[:3, 3]
    held = np.minimum(state.command.cable_tension, np.maximum(observation.cable_tension, 0.0))
    start = replace(state.command, T_world_base=frame, cable_tension=held, cable_pull=None)
    over = here if has_risen else np.array([here[0], here[1], max(here[2], home[2])])
    move = Move(
        phase="reach", action="let go", duration=LET_GO_TIME, position=here, tension=np.zeros(held.shape), gripper=-1.0
    )
    rise = replace(move, action="rise", position=over, duration=_time_for(over - here))
    back = replace(
        rise, action="return", position=home, rotation=state.T_home[:3, :3], gripper=0.0,
        duration=_time_for(home - over),
    )  # fmt: skip
    up = () if has_risen else (rise,)
    moves = (move, *up, back, replace(back, action="look again", duration=LOOK_TIME))
    return replace(begin(moves, observation), start=start, velocity=state.velocity)


def _time_for(way: np.ndarray) -> float:
    return max(2.0, float(np.linalg.norm(way)) / BACK_SPEED)
