"""Verdict on a grasp, from the simulator's true state alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import final

import numpy as np

from spiraltrunk.control.arm_limits import ArmLimits, find_missing_limits, velocity_bounds
from spiraltrunk.control.loop import RunLog
from spiraltrunk.control.messages import Task
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.sim.ground_truth import Sample
from spiraltrunk.sim.machine import SimMachine

Span = tuple[float, float]
Condition = tuple[bool, str]

LIFT_TOLERANCE = 0.25
"""Largest deviation of lift and carry over the commanded ones [-] (ours)."""

BEND_MOST = math.radians(33.0)
"""Largest bend that a joint of the paper's 30 deg may show; 10 % over the limit for other designs [rad] (ours)."""

PENETRATION_MOST = 0.005
"""Deepest overlap of two bodies that counts as contact and not as fault [m] (ours)."""

FALL_MOST = 0.010
"""Largest fall of a lifted object that touches neither trunk nor ground [m] (ours)."""

DROP_SPEED = 0.6
"""Largest speed of an object that is let down [m/s] (ours): that of a free fall by 18 mm; strategies lower at 0.1."""


@final
@dataclass(frozen=True, kw_only=True)
class Moments:
    """Begin and end of what the strategy reported by its milestones [s]; None for what it did not report."""

    push: Span | None = None
    """From the begin of the push until the trunk has withdrawn."""
    lift: Span | None = None
    """The lift."""
    carry: Span | None = None
    """The carry aside."""
    hold: Span | None = None
    """The hold."""

    @classmethod
    def from_log(cls, log: RunLog) -> Moments:
        """Moments of a run, by the milestones of its statuses."""
        return cls(
            push=log.milestone_span(Milestone.PUSHED), lift=log.milestone_span(Milestone.LIFTED),
            carry=log.milestone_span(Milestone.CARRIED), hold=log.milestone_span(Milestone.HELD),
        )  # fmt: skip


@final
@dataclass(frozen=True, kw_only=True)
class Evidence:
    """What a verdict rests on."""

    trace: Sequence[Sample]
    """True states of the simulation over time."""
    task: Task
    """What was to be done."""
    moments: Moments
    """When the strategy lifted, carried and held, as it reported."""
    gave_up: str | None
    """Why the strategy ended before its goal, if it did."""
    warnings: int
    """Number of warnings of the solver."""
    limits: ArmLimits
    """Limits of the arm."""

    @classmethod
    def from_run(cls, plant: SimMachine, log: RunLog) -> Evidence:
        """Evidence of a run on a simulated machine."""
        return cls(
            trace=plant.trace, task=plant.task, moments=Moments.from_log(log), gave_up=log.gave_up,
            warnings=plant.warnings, limits=plant.arm_limits,
        )  # fmt: skip

    def between(self, span: Span | None) -> list[Sample]:
        """Samples of a span of time [s]; none for None."""
        return [] if span is None else [s for s in self.trace if span[0] - 1e-9 <= s.time <= span[1] + 1e-9]


@final
@dataclass(frozen=True, kw_only=True)
class Verdict:
    """Success, or the first reason against it, and the figures that it rests on."""

    success: bool
    """Whether every condition held."""
    reason: str
    """"success", or the first condition that failed."""
    lift: float
    """Rise of the object during the lift [m]."""
    carry: float
    """Horizontal displacement of the object during the carry [m]."""
    hold: float
    """Time for which the trunk alone held the object still [s]."""
    place_error: float
    """Distance of the object from its place at the end [m]."""
    penetration: float
    """Deepest overlap of two bodies [m]."""
    bend: float
    """Largest joint bend [rad]."""
    unjudged: tuple[str, ...] = ()
    """Quantities of the arm of which no limit is known, so that none was judged."""


def evaluate_grasp(evidence: Evidence) -> Verdict:
    """Verdict on a grasp; conditions are tried in the order in which a trial would fail."""
    trace, goal, moments = evidence.trace, evidence.task.goal, evidence.moments
    lift = float(_displacement(evidence, moments.lift)[2])
    carry = float(np.linalg.norm(_displacement(evidence, moments.carry)[:2]))
    hold, aside = _time_held(evidence), float(np.linalg.norm(goal.aside))
    place_error = float(np.linalg.norm(trace[-1].object_position - goal.place))
    return decide(
        (
            *fault_conditions(evidence),
            (moments.lift is not None, "the strategy reported no lift"),
            (abs(lift / goal.lift - 1) <= LIFT_TOLERANCE, f"lifted {lift * 100:.0f} cm"),
            (moments.carry is not None, "the strategy reported no carry"),
            (abs(carry / aside - 1) <= LIFT_TOLERANCE, f"carried {carry * 100:.0f} cm aside"),
            (moments.hold is not None, "the strategy reported no hold"),
            (hold >= goal.hold - 0.05, f"held alone for {hold:.1f} s"),
            (_is_released(evidence), "not released at rest"),
            (place_error <= goal.zone, f"released {place_error * 100:.1f} cm from the target"),
            *_drop_conditions(evidence),
            *arm_conditions(evidence),
        ),
        evidence, lift=lift, carry=carry, hold=hold, place_error=place_error,
    )  # fmt: skip


def decide(
    conditions: Sequence[Condition], evidence: Evidence, *, lift: float, carry: float, hold: float, place_error: float
) -> Verdict:
    """The verdict whose reason is the first condition that fails, with figures as in `Verdict` [m], [s]."""
    reason = next((text for holds, text in conditions if not holds), "success")
    return Verdict(
        success=reason == "success", reason=reason, lift=lift, carry=carry, hold=hold, place_error=place_error,
        penetration=max(s.penetration for s in evidence.trace), bend=max(s.bend_most for s in evidence.trace),
        unjudged=find_missing_limits(evidence.limits),
    )  # fmt: skip


def fault_conditions(evidence: Evidence) -> list[Condition]:
    """Conditions of every job: no fault of the simulation, no joint bent too far, no touch of the arm."""
    trace, warnings = evidence.trace, evidence.warnings
    penetration, bend = max(s.penetration for s in trace), max(s.bend_most for s in trace)
    bend_most = evidence.task.design.joint_limit * BEND_MOST / math.radians(30.0)
    return [
        (warnings == 0, f"the solver warned {warnings} times"),
        (evidence.gave_up is None, f"{evidence.gave_up}"),
        (bend <= bend_most, f"a joint bent {math.degrees(bend):.1f} deg"),
        (penetration <= PENETRATION_MOST, f"bodies overlapped by {penetration * 1e3:.1f} mm"),
        (not any(s.touches_robot for s in trace), "the object touched housing or arm"),
        (not any(s.arm_touches_ground for s in trace), "housing or arm touched the ground"),
    ]


def arm_conditions(evidence: Evidence) -> list[Condition]:
    """Speed and torque as simulated; acceleration and jerk of the commanded path at the rate of its commands.

    A torque at its limit counts as passed, as simulated actuators, like real ones, give no more. What has no limit
    yields no condition: `find_missing_limits` names it.
    """
    trace, limits = evidence.trace, evidence.limits
    if len(trace) < 2:
        return []
    dt = trace[1].time - trace[0].time
    position, velocity, torque, command = (
        np.array([getattr(s, name) for s in trace])
        for name in ("arm_position", "arm_velocity", "arm_torque", "arm_command")
    )
    acceleration, jerk = np.diff(command, 2, axis=0) / dt**2, np.diff(command, 3, axis=0) / dt**3
    conditions = []
    if limits.velocity is not None:
        conditions.append((_is_within(velocity, velocity_bounds(limits, position)), "the arm passed its speed limit"))
    if limits.torque is not None:
        conditions.append((bool((np.abs(torque) < limits.torque).all()), "the arm passed its torque limit"))
    for name, values, most in (
        ("acceleration", acceleration, limits.acceleration),
        ("jerk", jerk, limits.jerk),
    ):
        if most is not None:
            conditions.append((_is_within(values, (-most, most)), f"the arm passed its {name} limit"))
    if limits.position is not None:
        conditions.append((_is_within(position, limits.position), "the arm passed a joint range"))
    return conditions


def _is_within(values: np.ndarray, bounds: tuple[np.ndarray, np.ndarray]) -> bool:
    return bool(((values >= bounds[0]) & (values <= bounds[1])).all())


def _displacement(evidence: Evidence, span: Span | None) -> np.ndarray:
    """Displacement of the object over a span, shape (3,) [m]; 0 for None."""
    part = evidence.between(span)
    return part[-1].object_position - part[0].object_position if part else np.zeros(3)


def _drop_conditions(evidence: Evidence) -> list[Condition]:
    """The lifted object is let down and never dropped; its places alone do not show a drop that lands well."""
    trace, lift, hold = evidence.trace, evidence.moments.lift, evidence.moments.hold
    if lift is None or hold is None or len(trace) < 2:
        return []
    after = evidence.between((lift[1], trace[-1].time))
    height = np.array([s.object_position[2] for s in after if s.time >= hold[1] - 1e-9])
    fall, speed = _longest_fall(after), float(-np.diff(height).min(initial=0.0)) / (trace[1].time - trace[0].time)
    is_carried = not any(s.touches_table for s in evidence.between((lift[1], hold[1])))
    return [
        (is_carried, "touched table or ground while it was carried"),
        (fall <= FALL_MOST, f"fell {fall * 100:.1f} cm"),
        (speed <= DROP_SPEED, f"came down at {speed:.1f} m/s"),
    ]


def _longest_fall(part: Sequence[Sample]) -> float:
    """Largest loss of height since the last touch of trunk or ground [m]; contacts flicker under rolling objects."""
    fall = held = 0.0
    for i, s in enumerate(part):
        height = float(s.object_position[2])
        held = height if i == 0 or s.grip_force > 0 or s.touches_table else held
        fall = max(fall, held - height)
    return fall


def _time_held(evidence: Evidence) -> float:
    """Longest time of the hold with strings slack, nothing else touched, the object within 2 cm of its mean height."""
    part = evidence.between(evidence.moments.hold)
    if len(part) < 2:
        return 0.0
    mean = np.mean([s.object_position[2] for s in part])
    slack = 0.02 * evidence.task.target.mass * GRAVITY
    is_held = [
        s.string_tension <= slack and s.grip_force > 0 and not s.touches_table and not s.touches_robot
        and abs(s.object_position[2] - mean) <= 0.02
        for s in part
    ]  # fmt: skip
    longest = max(len(list(run)) if holds else 0 for holds, run in groupby(is_held))
    return longest * (part[1].time - part[0].time)


def _is_released(evidence: Evidence) -> bool:
    """Whether the trunk has let go and the object lay still on table or ground over the last 0.2 s."""
    end = evidence.trace[-1].time
    part = evidence.between((end - 0.2, end))
    moved = np.ptp([s.object_position for s in part], axis=0).max()
    return moved <= 0.002 and part[-1].grip_force == 0.0 and part[-1].touches_table
