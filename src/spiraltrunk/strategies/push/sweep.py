"""Strategy 9, the trunk sweep: the rolled-up trunk pushes an object to a place where it can be grasped, which follows.

Source: "Grasping by Spiraling", Results, "Preparatory Action": objects beyond reach, or oriented so that they cannot be
grasped at once, are rolled or pushed by a kick or a sweep (strategies 8 and 9) to a more accessible place.

Phases: all of the sweep is reach (roll up, tilt, come down behind the object, push it by the camera's looks, withdraw,
unroll, look); where the object rests outside the zone before its place, it is pushed once more. Then the grasp takes
over with its own four phases: by the tip's gripper (strategy 3) what that holds, by a horizontal wrap (strategy 6)
what is larger. Any other strategy for objects on the ground will do.

Limits: one way of the push, along which the arm reaches; it never pulls back what went too far; a camera throughout.
The fist meets things no lower than its own radius. What is higher than wide and reaches no higher may be pushed over
where friction is high (a cylinder 32 mm wide and 40 mm high, about one time in eight). What stands higher slides where
friction is less than the radius r of its base over the height h of the contact, 38 mm, and may fall over where it is
more: a cylinder of 60 mm from 0.7 on, and the trials draw 0.5 to 1.2. It fell in 2 of the first 7. The grasp holds what
its own strategy holds.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, final

import numpy as np

from spiraltrunk.checks import check_type
from spiraltrunk.control.messages import Command, Observation, Task
from spiraltrunk.control.strategy import Milestone, Status, Strategy
from spiraltrunk.design.rules import graspable_range
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.strategies.fingertip.tip_grip import TipGrip
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
from spiraltrunk.strategies.push.steering import (
    Steering,
    SteerOptions,
    SteerPlan,
    command_of,
    is_over,
    seen_place,
    steer,
)
from spiraltrunk.strategies.wrap.standing_variants import WrapHorizontal

_FALLEN = 0.7
"""Cosine of the angle between seen and announced axis under which an object has fallen over [-]."""


@final
@dataclass(frozen=True, kw_only=True)
class SweepOptions:
    """What the strategy chooses."""

    steering: SteerOptions = field(default_factory=SteerOptions)
    """How the fist is steered."""
    gap: float = 0.03
    """Gap behind the object when the fist comes down [m]."""
    contact: float = 0.0
    """Height of the contact over that of the object [-]: as low as the fist goes."""
    back: float = 0.08
    """How far the fist backs off before it rises [m]."""
    margin: float = 0.6
    """Part of the zone in which the object must be seen, lest it be pushed again [-]: the grasp needs no more."""
    unroll: float = 4.5
    """Time to unroll [s]: let go fast, the trunk swings on."""
    settle: float = 2.5
    """Time in which the unrolled trunk comes to rest before the look [s]."""
    renewals: int = 6
    """How often to come down behind the object anew when the fist has slid past it [-]: where friction is high, small
    things jam under it after a few centimetres."""
    retries: int = 1
    """How often to push again after the look [-]."""

    def __post_init__(self) -> None:
        check_type("SweepOptions.steering", self.steering, SteerOptions)
        check_choices(self, positive=("unroll", "settle"))


@final
@dataclass(frozen=True, kw_only=True)
class SweepState:
    """What the strategy remembers."""

    progress: Progress
    """Moves of the sweep, done and to do."""
    stance: Stance
    """How the fist stands."""
    T_home: np.ndarray
    """Frame of the base at the start, to which the trunk returns to look, shape (4, 4) [-, m]."""
    steering: Steering | None = None
    """The push under way, if there is one."""
    grasp: Any = None
    """What the grasp remembers, once it has taken over."""
    task: Task | None = None
    """The grasp's task: the object where it was seen after the sweep."""
    renewals: int = 0
    """How often the fist came down anew in this push."""
    retries: int = 0
    """How often it pushed again after the look."""
    gave_up: str | None = None
    """Why it ended before its goal, if it did."""


@final
class Sweep(Strategy[SweepState]):
    """A push with the rolled-up trunk to a place, and the grasp there.

    Args:
        options: what the strategy chooses.
        grasp: which strategy grasps what it is told of; by its size by default.
    """

    name = "sweep"
    number = 9
    stage = "ground"
    stance = "upright"
    looks = True
    holds = "fingers"
    job = "sweep"
    objects = ("cylinder-60", "ball-30", "cube-28", "cylinder-90", "cone-35")
    position = (0.46, -0.05)
    push = (0.0, 0.17)

    def __init__(
        self, options: SweepOptions | None = None, grasp: Callable[[Task], Strategy[Any]] | None = None
    ) -> None:
        self.options = choose(options, SweepOptions())
        self._grasp = choose_grasp if grasp is None else grasp

    def widths(self, design: TrunkDesign) -> tuple[float, float]:
        """Least and greatest width of what it can take [m]: anything up to what the trunk can wrap."""
        return 0.0, graspable_range(design).maximum

    def init(self, observation: Observation) -> SweepState:
        """Plan the stance from design, object and goal.

        Raises:
            ModelError: where no cable pulls ventral, or the object cannot be pushed.
        """
        stance = plan_stance(observation.task, self.options.contact)
        moves = roll_up(observation, stance, self._behind(stance, observation))
        return SweepState(progress=begin(moves, observation), stance=stance, T_home=observation.T_world_base)

    def step(self, state: SweepState, observation: Observation) -> tuple[SweepState, Command]:
        """Follow the moves, steer the push by the looks, and hand over to the grasp."""
        if state.task is not None:
            return self._step_grasp(state, state.task, observation)
        if state.steering is not None:
            return self._step_push(state, state.steering, observation)
        if fraction(state.progress, observation.time) >= 1.0:
            state = self._next(state, observation)
        if state.task is not None:
            return self._step_grasp(state, state.task, observation)
        return state, self._command(state, observation)

    @staticmethod
    def _command(state: SweepState, observation: Observation) -> Command:
        return keep_level(command_at(state.progress, observation.time), state.progress, observation)

    def status(self, state: SweepState) -> Status:
        """Where the strategy stands; once the grasp has taken over, where that stands."""
        if state.task is not None:
            return self._grasp(state.task).status(state.grasp)
        if state.steering is not None:
            return Status(phase="reach", action="push", milestone=Milestone.PUSHED)
        return status_of(state.progress, is_done=state.gave_up is not None, gave_up=state.gave_up)

    def _step_grasp(self, state: SweepState, task: Task, observation: Observation) -> tuple[SweepState, Command]:
        grasp, command = self._grasp(task).step(state.grasp, told(observation, task))
        return replace(state, grasp=grasp), command

    def _step_push(self, state: SweepState, steering: Steering, observation: Observation) -> tuple[SweepState, Command]:
        seen, goal, plan = seen_place(observation), observation.task.goal.place, self._plan(state, observation)
        if is_over(steering, observation, goal, plan):
            left = float(np.dot(goal - seen, state.stance.way))
            is_short = left > self.options.margin * observation.task.goal.zone
            again = is_short and state.renewals < self.options.renewals
            state = (self._renew if again else self._withdraw)(state, steering, observation)
            return state, self._command(state, observation)
        steering = steer(steering, observation.time, seen, goal, plan)
        command = keep_level(command_of(steering, state.stance), state.progress, observation)
        return replace(state, steering=steering), command

    def _next(self, state: SweepState, observation: Observation) -> SweepState:
        progress, time = state.progress, observation.time
        if progress.move.action in ("turn", "aim"):
            progress = insert_next(progress, go_down(state.stance, self._behind(state.stance, observation)))
        if progress.move.action == "come down":
            base = command_at(progress, time).T_world_base[:3, 3]
            steering = Steering(base=base, velocity=np.zeros(3), since=time, time=time, force=observation.base_force)
            return replace(state, steering=steering)
        if progress.move.action == "look over":
            return self._judge(state, observation)
        return replace(state, progress=advance(progress, time))

    def _judge(self, state: SweepState, observation: Observation) -> SweepState:
        """Hand over what rests in the zone, push again what does not."""
        goal = observation.task.goal
        beside = float(np.linalg.norm((goal.place - seen_place(observation))[:2]))
        if beside <= self.options.margin * goal.zone:
            return self._hand_over(state, observation)
        left = float(np.dot(goal.place - seen_place(observation), state.stance.way))
        if state.retries < self.options.retries and left > self.options.margin * goal.zone:
            moves = roll_up(observation, state.stance, self._behind(state.stance, observation))
            return replace(state, progress=begin(moves, observation), retries=state.retries + 1)
        if beside <= goal.zone:
            return self._hand_over(state, observation)
        return replace(state, gave_up=f"the object lies {beside * 100:.0f} cm from its place")

    def _hand_over(self, state: SweepState, observation: Observation) -> SweepState:
        task = task_to_grasp(observation)
        grasp = self._grasp(task).init(told(observation, task))
        return replace(state, task=task, grasp=grasp)

    def _withdraw(self, state: SweepState, steering: Steering, observation: Observation) -> SweepState:
        """Back off, rise, unroll in the air, and look."""
        stance, options, home = state.stance, self.options, state.T_home
        back = steering.base - options.back * stance.way
        up = np.array([back[0], back[1], home[2, 3]])
        still = Move(
            phase="reach", action="stop", milestone=Milestone.PUSHED, duration=0.5, position=steering.base,
            tension=stance.tension, rotation=stance.rotation,
        )  # fmt: skip
        if self._is_low(stance, observation):  # Backing off would take along what is under the fist.
            off = replace(still, action="lift off", duration=1.5, position=steering.base + np.array([0.0, 0.0, 0.08]))
        else:
            off = replace(still, action="back off", duration=1.5, position=back)
        moves = (
            still,
            off,
            replace(still, action="rise", duration=2.0, position=up, tension=0.5 * stance.tension),
            replace(still, action="unroll", duration=options.unroll, position=home[:3, 3], rotation=home[:3, :3],
                    tension=0.0 * stance.tension),
            replace(still, action="look over", duration=options.settle, position=home[:3, 3], rotation=home[:3, :3],
                    tension=0.0 * stance.tension),
        )  # fmt: skip
        return replace(state, progress=self._from(steering, stance, moves, observation), steering=None)

    def _renew(self, state: SweepState, steering: Steering, observation: Observation) -> SweepState:
        """Rise straight off what may be jammed under the fist, and come down behind it anew."""
        stance = state.stance
        up = Move(
            phase="reach", action="rise", duration=1.2, position=steering.base + np.array([0.0, 0.0, 0.10]),
            tension=stance.tension, rotation=stance.rotation,
        )  # fmt: skip
        aim = replace(up, action="aim", duration=0.8)
        progress = self._from(steering, stance, (up, aim), observation)
        return replace(state, progress=progress, steering=None, renewals=state.renewals + 1)

    @staticmethod
    def _from(steering: Steering, stance: Stance, moves: tuple[Move, ...], observation: Observation) -> Progress:
        """Moves that go on from a push."""
        held = command_of(steering, stance)
        return replace(
            begin(moves, observation), T_start=held.T_world_base, tension_start=held.cable_tension,
            velocity_start=steering.velocity,
        )  # fmt: skip

    @staticmethod
    def _is_low(stance: Stance, observation: Observation) -> bool:
        """Whether the object's centre lies lower than the fist's middle."""
        return bool(observation.task.target.position[2] < stance.height - stance.fist.below)

    def _behind(self, stance: Stance, observation: Observation) -> np.ndarray:
        gap = reach_of(observation.task.target) + self.options.gap
        return stance.base_behind(seen_place(observation), gap)

    def _plan(self, state: SweepState, observation: Observation) -> SteerPlan:
        target = observation.task.target
        rolls = target.kind == "sphere" and not self._is_low(state.stance, observation)
        return SteerPlan(stance=state.stance, reach=target.width / 2, rolls=rolls, options=self.options.steering)


def choose_grasp(task: Task) -> Strategy[Any]:
    """The tip's gripper for what it can hold, a horizontal wrap for what is larger."""
    gripper = task.design.gripper
    return TipGrip() if gripper is not None and task.target.width <= gripper.grasp_width else WrapHorizontal()


def task_to_grasp(observation: Observation) -> Task:
    """The task of grasping the object where it is seen: lift, carry aside and hold as before, set down there.

    Its axis, which has no sign, points as announced as far as may be. Unless it has fallen over, its height is kept as
    announced: what stands on the ground is better known than seen.
    """
    task, seen = observation.task, seen_place(observation)
    axis = task.target.axis if observation.look is None else observation.look.axis
    along = float(np.dot(axis, task.target.axis))
    if abs(along) > _FALLEN:
        seen = np.array([*seen[:2], task.target.position[2]])
    target = replace(task.target, position=seen, axis=math.copysign(1.0, along) * axis)
    return replace(task, target=target, goal=replace(task.goal, place=seen + task.goal.aside))


def told(observation: Observation, task: Task) -> Observation:
    """The observation with another task, the object's axis seen to point as that task says."""
    look = observation.look
    if look is not None and float(np.dot(look.axis, task.target.axis)) < 0:
        look = replace(look, axis=-look.axis)
    return replace(observation, task=task, look=look)
