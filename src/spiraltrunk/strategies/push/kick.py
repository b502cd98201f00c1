"""Strategy 8, the trunk kick: a stroke of the arm with the rolled-up trunk sends an object the goal's way.

Source: "Grasping by Spiraling", Results, "Preparatory Action": objects beyond reach, or oriented so that they cannot be
grasped at once, are rolled or pushed by a kick or a sweep (strategies 8 and 9) to a more accessible place.

Phases: reach (roll up, tilt, look, come down behind the object), transport (the stroke, which meets the object at its
greatest speed), release (rise, wait, look whether the object went far enough; if not, once more). There is no
prehension. A ball rolls on, so it is struck more slowly than what slides.

Limits: one way of the stroke, along which the arm reaches; a camera that sees the object before the stroke; the object
is sent beyond a line, not to a place.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.control.strategy import Milestone, Status, Strategy
from spiraltrunk.design.rules import GRAVITY, graspable_range
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.strategies.moves import (
    Move,
    Progress,
    advance,
    begin,
    command_at,
    fraction,
    insert_next,
    status_of,
)
from spiraltrunk.strategies.options import check_choices, choose
from spiraltrunk.strategies.push.stance import Stance, go_down, keep_level, plan_stance, reach_of, roll_up
from spiraltrunk.strategies.push.steering import seen_place

_PEAK = 1.875
"""Greatest over mean speed of a path of least jerk [-]."""


@final
@dataclass(frozen=True, kw_only=True)
class KickOptions:
    """What the strategy chooses."""

    run_up: float = 0.08
    """Way of the fist before it meets the object [m]."""
    follow: float = 0.20
    """Way of the fist after it has met the object [m]."""
    speed: float = 0.70
    """Greatest speed of the stroke [m/s]: the arm's limits allow about 0.8."""
    roll: float = 0.20
    """How far a ball shall roll on [m]; with the resistance below it sets the speed of its stroke."""
    resistance: float = 1e-3
    """Rolling resistance expected of a ball [m]."""
    contact: float = 0.22
    """Height of the contact over that of the object [-]: low, so that what stands slides and does not fall over."""
    watch: float = 4.0
    """Time to wait after the stroke [s]."""
    retries: int = 1
    """How often to kick again what did not go far enough [-]."""

    def __post_init__(self) -> None:
        check_choices(self, positive=("run_up", "follow", "speed", "roll", "resistance", "watch"))


@final
@dataclass(frozen=True, kw_only=True)
class KickState:
    """What the strategy remembers."""

    progress: Progress
    """Moves done and to do."""
    stance: Stance
    """How the fist stands."""
    retries: int = 0
    """How often it kicked again."""
    is_done: bool = False
    """Whether all is done."""
    gave_up: str | None = None
    """Why it ended before its goal, if it did."""


@final
class Kick(Strategy[KickState]):
    """A stroke with the rolled-up trunk."""

    name = "kick"
    number = 8
    stage = "ground"
    stance = "upright"
    looks = True
    holds = "nothing"
    job = "kick"
    objects = ("box-80", "box-100", "cylinder-90", "cylinder-120", "ball-80", "ball-100", "ball-120")
    position = (0.50, 0.10)
    push = (0.0, 0.15)

    def __init__(self, options: KickOptions | None = None) -> None:
        self.options = choose(options, KickOptions())

    def widths(self, design: TrunkDesign) -> tuple[float, float]:
        """Least and greatest width of what it can take [m]: anything up to what the trunk could wrap can be struck."""
        return 0.0, graspable_range(design).maximum

    def init(self, observation: Observation) -> KickState:
        """Plan the stance from design, object and goal.

        Raises:
            ModelError: where no cable pulls ventral, or the object cannot be pushed.
        """
        stance = plan_stance(observation.task, self.options.contact)
        base = self._start(observation, stance)
        return KickState(progress=begin(roll_up(observation, stance, base), observation), stance=stance)

    def step(self, state: KickState, observation: Observation) -> tuple[KickState, Command]:
        """Follow the moves; aim by the last look before the stroke, and look again after it."""
        if fraction(state.progress, observation.time) >= 1.0:
            state = self._next(state, observation)
        return state, self._command(state, observation)

    @staticmethod
    def _command(state: KickState, observation: Observation) -> Command:
        return keep_level(command_at(state.progress, observation.time), state.progress, observation)

    def status(self, state: KickState) -> Status:
        """Where the strategy stands."""
        return status_of(state.progress, is_done=state.is_done, gave_up=state.gave_up)

    def _next(self, state: KickState, observation: Observation) -> KickState:
        progress = state.progress
        if progress.move.action == "turn":
            progress = insert_next(progress, self._strike(state.stance, observation))
        if progress.move.action == "watch":
            if self._is_far(state.stance, observation):
                return replace(state, is_done=True)
            if state.retries >= self.options.retries:
                return replace(state, is_done=True, gave_up="the object did not go far enough")
            progress = insert_next(progress, self._strike(state.stance, observation))
            state = replace(state, retries=state.retries + 1)
        return replace(state, progress=advance(progress, observation.time))

    def _is_far(self, stance: Stance, observation: Observation) -> bool:
        left = observation.task.goal.place - seen_place(observation)
        return float(np.dot(left, stance.way)) <= 0.0

    def _start(self, observation: Observation, stance: Stance) -> np.ndarray:
        gap = reach_of(observation.task.target) + self.options.run_up
        return stance.base_behind(seen_place(observation), gap)

    def _strike(self, stance: Stance, observation: Observation) -> tuple[Move, ...]:
        options, start = self.options, self._start(observation, stance)
        stroke = options.run_up + options.follow
        end = start + stroke * stance.way
        kick = Move(
            phase="transport", action="kick", milestone=Milestone.PUSHED, position=end, tension=stance.tension,
            duration=_PEAK * stroke / self._speed(observation), rotation=stance.rotation,
        )  # fmt: skip
        up = end - 0.10 * stance.way + np.array([0.0, 0.0, 0.15])
        rise = replace(kick, phase="release", action="rise", duration=1.5, position=up)
        watch = replace(rise, action="watch", duration=options.watch)
        return (*go_down(stance, start), kick, rise, watch)

    def _speed(self, observation: Observation) -> float:
        """Speed at which a ball rolls on as far as it shall, or at which what stands does not fall over [m/s].

        A ball that rolls loses 5/7 g c / r of speed a second, c its rolling resistance, r its radius. What stands and
        is stopped at its foot falls over where its energy lifts its centre over the edge: v^2 / 2 = g (d - h), h the
        height of its centre and d the distance of that from the edge.
        """
        target, radius = observation.task.target, observation.task.target.width / 2
        if target.kind == "sphere":
            free = math.sqrt(2 * 5 / 7 * GRAVITY * self.options.resistance / radius * self.options.roll)
        else:
            height = float(target.position[2]) - (observation.task.goal.ground or 0.0)
            free = math.sqrt(2 * GRAVITY * (math.hypot(height, radius) - height))
        return min(self.options.speed, free)
