"""Strategy 9, the trunk sweep: the rolled trunk pushes an object to a place where it can be grasped, and it is grasped.

Source: as of the kick. The whole sweep is reach (roll up, tilt, come down behind the object, push it by camera
observations, withdraw, unroll, observe). An object that rests outside the zone before its place is pushed once more.
Then the grasp takes over with its own four phases: the tip gripper (strategy 3) for what it can hold, a horizontal wrap
(strategy 6) for larger objects, or any other strategy for objects on the ground that is given instead.

Limits: one direction of the push, along which the arm reaches; no way back for what went too far; a camera throughout.
The rolled trunk meets nothing lower than its own radius. Objects that are higher than wide and reach no higher than
that may be pushed over where friction is high (a cylinder 32 mm wide and 40 mm high, about one time in eight). Higher
ones slide where friction is less than the radius r of their base over the height h of the contact, 38 mm, and may fall
over otherwise: a cylinder of 60 mm from 0.7 on, where trials draw 0.5 to 1.2. It fell in 2 of the first 7.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from spiraltrunk.control.messages import Command, Observation, Task
from spiraltrunk.control.strategy import Milestone, Status, Strategy
from spiraltrunk.strategies.fingertip.assess import assess_fingers
from spiraltrunk.strategies.fingertip.tip_grip import TipGrip
from spiraltrunk.strategies.moves import Move, advance, base_position, begin, insert_next
from spiraltrunk.strategies.object_measures import UPRIGHT
from spiraltrunk.strategies.push.approach_pose import go_down, plan_pose
from spiraltrunk.strategies.push.push_strategy import PushState, PushStrategy, keep_together
from spiraltrunk.strategies.push.steering import Steering, SteerPlan, command_of, is_over, steer
from spiraltrunk.strategies.sensing import seen_position
from spiraltrunk.strategies.timing import stretch, travel_time
from spiraltrunk.strategies.winder_drag import straighten
from spiraltrunk.strategies.wrap.standing import StandingWrap, WrapHorizontal

# All of these are ours, tuned in simulated trials.
GAP = 0.03
"""Gap behind the object when the rolled trunk comes down [m]."""
CONTACT = 0.0
"""Height of the contact over that of the object [-]: as low as the rolled trunk goes."""
BACK = 0.08
"""Retreat of the rolled trunk before it rises [m]."""
MARGIN = 0.6
"""Part of the zone outside which the object is pushed again [-]: the grasp needs no more."""
STOP_TIME = 0.3
"""Time in which the push stops [s]."""
RISE = 0.08
"""Rise of the rolled trunk off an object that is lower than its front [m]."""
RISE_SPEED = 0.5
"""Greatest speed of the rise [m/s]."""
EASE = 0.3
"""Part of the tension that is left at the end of the rise [-]."""
UNROLL_TIME = 3.0
"""Time to unroll from there [s]: let go fast, the trunk swings on."""
SETTLE_TIME = 0.8
"""Time in which the unrolled trunk is left alone before the grasp [s], and the camera observes the object."""
AIM_TIME = 0.5
"""Time to observe an object before a further approach [s]: the camera's period."""
RENEWALS = 6
"""Number of further approaches after the trunk slid past the object [-]: small objects jam where friction is high."""
RETRIES = 1
"""Number of further pushes after the observation [-]."""


@final
@dataclass(frozen=True, kw_only=True)
class SweepState(PushState):
    """What the strategy remembers."""

    T_home: np.ndarray
    """Frame of the base at the start, to which the trunk returns to observe, shape (4, 4) [-, m]."""
    steering: Steering | None = None
    """The present push, if there is one."""
    grasp: Any = None
    """State of the grasp, once it has taken over."""
    task: Task | None = None
    """Task of the grasp: the object as observed after the sweep."""
    renewals: int = 0
    """Further approaches in this push [-]."""


@final
class Sweep(PushStrategy[SweepState]):
    """A push with the rolled trunk to a place, and the grasp there by what ``grasp`` chooses for its task."""

    name = "sweep"
    number = 9
    holds = "fingers"
    job = "sweep"
    objects = ("cylinder-60", "ball-30", "cube-28", "cylinder-90", "cone-35")
    position = (0.46, -0.05)
    push = (0.0, 0.17)
    gap = GAP

    def __init__(self, grasp: Callable[[Task], Strategy[Any]] | None = None) -> None:
        self._grasp = choose_grasp if grasp is None else grasp

    def grasp_task(self, task: Task) -> Task:
        """The task with the object at the place to which it is pushed, whence it is carried aside."""
        target, goal = replace(task.target, position=task.goal.place), task.goal
        return replace(task, target=target, goal=replace(goal, place=goal.place + goal.aside))

    def highest_base(self, task: Task) -> float | None:
        """Largest height of the base that the grasp plans [m]; None where it plans none.

        Raises:
            ModelError: where the grasp cannot do what the task asks.
        """
        return self._grasp(task).highest_base(task)

    def base_path(self, observation: Observation) -> tuple[np.ndarray, ...] | None:
        """Frames of the base that the grasp plans, each of shape (4, 4) [-, m]; None where it tells none.

        Raises:
            ModelError: where the grasp cannot do what the task asks.
        """
        return self._grasp(observation.task).base_path(observation)

    def init(self, observation: Observation) -> SweepState:
        """Plan the approach pose from design, object and goal."""
        pose = plan_pose(observation.task, CONTACT)
        return SweepState(sequence=self.roll_up(pose, observation), pose=pose, T_home=observation.T_world_base)

    def step(self, state: SweepState, observation: Observation) -> tuple[SweepState, Command]:
        """Follow the moves, steer the push by camera observations, and hand over to the grasp."""
        if state.steering is not None:
            return self._step_push(state, state.steering, observation)
        if state.task is None:
            state, command = super().step(state, observation)
        if state.task is not None:
            grasp, command = self._grasp(state.task).step(state.grasp, with_task(observation, state.task))
            state = replace(state, grasp=grasp)
        return state, command

    def status(self, state: SweepState) -> Status:
        """Status of the push; once the grasp has taken over, the status of the grasp."""
        if state.task is not None:
            return self._grasp(state.task).status(state.grasp)
        if state.steering is not None:
            return Status(phase="reach", action="push", milestone=Milestone.PUSHED)
        return super().status(state)

    def command(self, state: SweepState, observation: Observation) -> Command:
        """Command of the present move; the unrolled trunk is pulled straight."""
        command = super().command(state, observation)
        return straighten(command, observation) if state.sequence.move.action == "look over" else command

    def next_move(self, state: SweepState, observation: Observation) -> SweepState:
        """Come down behind the object as observed, begin the push, and decide after the last observation."""
        sequence, time, action = state.sequence, observation.time, state.sequence.move.action
        if action in ("turn", "aim"):
            behind = self.base_behind(state.pose, observation)
            sequence = insert_next(sequence, go_down(state.pose, behind, base_position(sequence, time)))
        if action == "come down":
            base, still, force = base_position(sequence, time), np.zeros(3), observation.base_force
            return replace(state, steering=Steering(base=base, velocity=still, since=time, time=time, force=force))
        if action == "look over":
            return self._decide(state, observation)
        return replace(state, sequence=advance(sequence, time))

    def _step_push(self, state: SweepState, steering: Steering, observation: Observation) -> tuple[SweepState, Command]:
        seen, goal, target = seen_position(observation), observation.task.goal, observation.task.target
        rolls = target.kind == "sphere" and not _is_low(state, observation)
        plan = SteerPlan(pose=state.pose, reach=target.width / 2, rolls=rolls)
        if is_over(steering, observation, goal.place, plan):
            is_short = float(np.dot(goal.place - seen, state.pose.way)) > MARGIN * goal.zone
            end = _renew if is_short and state.renewals < RENEWALS else _withdraw
            state = end(state, steering, observation)
            return state, self.command(state, observation)
        steering = steer(steering, observation.time, seen, goal.place, plan)
        command = keep_together(command_of(steering, state.pose), state.sequence, observation)
        return replace(state, steering=steering), command

    def _decide(self, state: SweepState, observation: Observation) -> SweepState:
        """Hand over an object that rests in the zone; push another one again.

        What has fallen over is given up where the grasp is a wrap of what stands.
        """
        goal, left = observation.task.goal, observation.task.goal.place - seen_position(observation)
        distance, is_short = float(np.linalg.norm(left[:2])), float(np.dot(left, state.pose.way)) > MARGIN * goal.zone
        if distance > MARGIN * goal.zone and state.retries < RETRIES and is_short:
            return replace(state, sequence=self.roll_up(state.pose, observation), retries=state.retries + 1)
        if distance <= goal.zone:
            task = task_to_grasp(observation)
            along = float(np.dot(task.target.axis, observation.task.target.axis))
            if along < UPRIGHT and task.target.kind != "sphere" and isinstance(self._grasp(task), StandingWrap):
                return replace(state, is_done=True, gave_up="nothing was lifted: the object has toppled")
            return replace(state, task=task, grasp=self._grasp(task).init(with_task(observation, task)))
        return replace(state, is_done=True, gave_up=f"the object lies {distance * 100:.0f} cm from its place")


def _withdraw(state: SweepState, steering: Steering, observation: Observation) -> SweepState:
    """Back off, rise, unroll in the air, and observe."""
    pose, home = state.pose, state.T_home
    back = steering.base - BACK * pose.way
    up = np.array([back[0], back[1], home[2, 3]])
    still = replace(pose.move("stop", STOP_TIME, steering.base), milestone=Milestone.PUSHED)
    if _is_low(state, observation):  # Backing off would drag the object under the trunk along.
        off = replace(still, action="lift off", position=steering.base + np.array([0.0, 0.0, RISE]))
    else:
        off = replace(still, action="back off", position=back)
    off = replace(off, duration=travel_time(off.position - steering.base))
    climb = travel_time(up - off.position, speed=RISE_SPEED)
    rise = replace(still, action="rise", duration=climb, position=up, tension=EASE * pose.tension)
    unroll = replace(
        still, action="unroll", duration=UNROLL_TIME, position=home[:3, 3], rotation=home[:3, :3],
        tension=0.0 * pose.tension,
    )  # fmt: skip
    moves = (still, off, rise, unroll, replace(unroll, action="look over", duration=SETTLE_TIME))
    return _go_on(state, steering, moves, observation)


def _renew(state: SweepState, steering: Steering, observation: Observation) -> SweepState:
    """Rise off an object that may be jammed under the rolled trunk, and come down behind it again."""
    way = np.array([0.0, 0.0, 0.10])
    rise_time = travel_time(way) * stretch(observation.task.design)
    up = state.pose.move("rise", rise_time, steering.base + way)
    moves = (up, replace(up, action="aim", duration=AIM_TIME))
    return replace(_go_on(state, steering, moves, observation), renewals=state.renewals + 1)


def _go_on(state: SweepState, steering: Steering, moves: tuple[Move, ...], observation: Observation) -> SweepState:
    """End the push with moves that begin from its motion."""
    start = command_of(steering, state.pose)
    sequence = replace(begin(moves, observation), start=start, velocity=steering.velocity)
    return replace(state, sequence=sequence, steering=None)


def _is_low(state: SweepState, observation: Observation) -> bool:
    """Whether the object's centre is lower than the front's middle."""
    return bool(observation.task.target.position[2] < state.pose.height - state.pose.trunk.below)


def choose_grasp(task: Task) -> Strategy[Any]:
    """The tip gripper for what it can hold, a horizontal wrap for larger objects."""
    gripper, target, fingers = task.design.gripper, task.target, TipGrip()
    if gripper is None:
        return WrapHorizontal()
    may_hold = target.kind == "cone" and assess_fingers(fingers, task).feasible  # Its foot may be wider than they open.
    return fingers if target.width <= gripper.grasp_width or may_hold else WrapHorizontal()


def task_to_grasp(observation: Observation) -> Task:
    """Task of grasping the object as observed: lift, carry aside and hold as before, set down there.

    The axis, which has no sign, points as announced as far as possible. Where a handle points after the push is
    unknown. The height of an object that has not fallen over is kept as announced, which is more accurate than
    observed.
    """
    task, seen = observation.task, seen_position(observation)
    axis = task.target.axis if observation.camera is None else observation.camera.axis
    along = float(np.dot(axis, task.target.axis))
    if abs(along) > UPRIGHT:
        seen = np.array([*seen[:2], task.target.position[2]])
    target = replace(task.target, position=seen, axis=math.copysign(1.0, along) * axis, handle=None)
    return replace(task, target=target, goal=replace(task.goal, place=seen + task.goal.aside))


def with_task(observation: Observation, task: Task) -> Observation:
    """The observation with another task, the observed axis pointing as in that task."""
    camera = observation.camera
    if camera is not None and float(np.dot(camera.axis, task.target.axis)) < 0:
        camera = replace(camera, axis=-camera.axis)
    return replace(observation, task=task, camera=camera)
