"""Whether a grasp truly succeeded, from the simulator's record alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.control.arm_limits import ArmLimits, find_unjudged, velocity_bounds
from spiraltrunk.control.loop import RunLog
from spiraltrunk.control.messages import Task
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.sim.ground_truth import Sample

LIFT_TOLERANCE = 0.25
"""Part of the commanded lift and carry by which the real ones may differ [-]."""

BEND_MOST = math.radians(33.0)
"""Largest bend that a joint of the paper's 30 deg may show; 10 % over the limit for other designs [rad]."""

PENETRATION_MOST = 0.005
"""Deepest overlap of two bodies that counts as contact and not as fault [m]."""

FALL_MOST = 0.010
"""Most that a lifted object may come down while it touches neither trunk nor ground [m] (ours)."""

DROP_SPEED = 0.6
"""Greatest speed at which an object may be let down [m/s] (ours): what falls freely has it after 18 mm; the
strategies let down at 0.1."""


@final
@dataclass(frozen=True, kw_only=True)
class Moments:
    """Begin and end of what the strategy reported by its milestones [s]; None for what it did not report."""

    push: tuple[float, float] | None = None
    """From where the push begins to where the trunk has withdrawn."""
    lift: tuple[float, float] | None = None
    """The lift."""
    carry: tuple[float, float] | None = None
    """The carry aside."""
    hold: tuple[float, float] | None = None
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
    """True state of the simulation over time."""
    task: Task
    """What was to be done."""
    moments: Moments
    """When the strategy lifted, carried and held, as it reported."""
    gave_up: str | None
    """Why the strategy ended before its goal, if it did."""
    warnings: int
    """How often the solver warned."""
    limits: ArmLimits
    """What the arm may do."""


@final
@dataclass(frozen=True, kw_only=True)
class Verdict:
    """Success, or the first reason against it, and the figures that it rests on."""

    success: bool
    """Whether every condition held."""
    reason: str
    """"success", or the first condition that failed."""
    lift: float
    """Rise of the object while the arm lifted [m]."""
    carry: float
    """Horizontal way of the object while the arm carried it aside [m]."""
    hold: float
    """Time that the trunk alone held the object still [s]."""
    place_error: float
    """Distance of the object from its target at the end [m]."""
    penetration: float
    """Deepest overlap of two bodies [m]."""
    bend: float
    """Largest joint bend [rad]."""
    unjudged: tuple[str, ...] = ()
    """Quantities of the arm of which no limit is known, so that none was judged."""


def evaluate_grasp(evidence: Evidence) -> Verdict:
    """Whether a grasp succeeded; conditions are tried in the order in which a trial would fail."""
    trace, task, moments = evidence.trace, evidence.task, evidence.moments
    lift, carry = _rise(trace, moments.lift), _way(trace, moments.carry)
    hold = _held(trace, moments.hold, task)
    place_error = float(np.linalg.norm(trace[-1].object_position - task.goal.place))
    aside = float(np.linalg.norm(task.goal.aside))
    return decide(
        (
            *fault_conditions(evidence),
            (moments.lift is not None, "the strategy reported no lift"),
            (abs(lift / task.goal.lift - 1) <= LIFT_TOLERANCE, f"lifted {lift * 100:.0f} cm"),
            (moments.carry is not None, "the strategy reported no carry"),
            (abs(carry / aside - 1) <= LIFT_TOLERANCE, f"carried {carry * 100:.0f} cm aside"),
            (moments.hold is not None, "the strategy reported no hold"),
            (hold >= task.goal.hold - 0.05, f"held alone for {hold:.1f} s"),
            (_is_released(trace), "not released at rest"),
            (place_error <= task.goal.zone, f"released {place_error * 100:.1f} cm from the target"),
            *_drop_conditions(trace, moments),
            *arm_conditions(evidence),
        ),
        evidence, lift=lift, carry=carry, hold=hold, place_error=place_error,
    )  # fmt: skip


def decide(
    conditions: Sequence[tuple[bool, str]], evidence: Evidence, *, lift: float, carry: float, hold: float,
    place_error: float,
) -> Verdict:  # fmt: skip
    """The verdict whose reason is the first condition that fails, with its figures as in `Verdict` [m], [s]."""
    reason = next((text for holds, text in conditions if not holds), "success")
    return Verdict(
        success=reason == "success", reason=reason, lift=lift, carry=carry, hold=hold, place_error=place_error,
        penetration=max(s.penetration for s in evidence.trace), bend=max(s.bend_most for s in evidence.trace),
        unjudged=find_unjudged(evidence.limits),
    )  # fmt: skip


def fault_conditions(evidence: Evidence) -> list[tuple[bool, str]]:
    """What no trial may show, whatever its job: faults of the simulation, overbent joints, touches of the arm."""
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


def _between(trace: Sequence[Sample], span: tuple[float, float] | None) -> list[Sample]:
    return [] if span is None else [s for s in trace if span[0] - 1e-9 <= s.time <= span[1] + 1e-9]


def _rise(trace: Sequence[Sample], span: tuple[float, float] | None) -> float:
    part = _between(trace, span)
    return float(part[-1].object_position[2] - part[0].object_position[2]) if part else 0.0


def _way(trace: Sequence[Sample], span: tuple[float, float] | None) -> float:
    part = _between(trace, span)
    return float(np.linalg.norm((part[-1].object_position - part[0].object_position)[:2])) if part else 0.0


def _drop_conditions(trace: Sequence[Sample], moments: Moments) -> list[tuple[bool, str]]:
    """That the object, once lifted, is let down and never dropped: places alone do not tell a drop that lands well."""
    if moments.lift is None or moments.hold is None or len(trace) < 2:
        return []
    carried = _between(trace, (moments.lift[1], moments.hold[1]))
    after = _between(trace, (moments.lift[1], trace[-1].time))
    dt = trace[1].time - trace[0].time
    fall = _longest_fall(after)
    height = np.array([s.object_position[2] for s in after if s.time >= moments.hold[1] - 1e-9])
    fastest = float(-np.diff(height).min(initial=0.0)) / dt
    return [
        (not any(s.touches_table for s in carried), "touched table or ground while it was carried"),
        (fall <= FALL_MOST, f"fell {fall * 100:.1f} cm"),
        (fastest <= DROP_SPEED, f"came down at {fastest:.1f} m/s"),
    ]


def _longest_fall(part: Sequence[Sample]) -> float:
    """Greatest loss of height since the last touch of trunk or ground [m]; contacts flicker where things roll over."""
    fall = held = 0.0
    for i, s in enumerate(part):
        height = float(s.object_position[2])
        held = height if i == 0 or s.grip_force > 0 or s.touches_table else held
        fall = max(fall, held - height)
    return fall


def _held(trace: Sequence[Sample], span: tuple[float, float] | None, task: Task) -> float:
    """Longest time of the hold with strings slack, nothing else touched, the object within 2 cm of its mean height."""
    part = _between(trace, span)
    if len(part) < 2:
        return 0.0
    mean = np.mean([s.object_position[2] for s in part])
    slack = 0.02 * task.target.mass * GRAVITY
    longest = run = 0
    for s in part:
        is_alone = s.string_tension <= slack and not s.touches_table and not s.touches_robot and s.grip_force > 0
        run = run + 1 if is_alone and abs(s.object_position[2] - mean) <= 0.02 else 0
        longest = max(longest, run)
    return longest * (part[1].time - part[0].time)


def _is_released(trace: Sequence[Sample]) -> bool:
    """Whether the trunk has let go and the object lies still on table over the last 0.2 s."""
    part = _between(trace, (trace[-1].time - 0.2, trace[-1].time))
    moved = np.ptp([s.object_position for s in part], axis=0).max()
    return moved <= 0.002 and part[-1].grip_force == 0.0 and part[-1].touches_table


def arm_conditions(evidence: Evidence) -> list[tuple[bool, str]]:
    """Speed and torque as simulated; acceleration and jerk of the commanded path at the rate of its commands.

    A torque at its limit counts as passed, as simulated actuators, like real ones, give no more. What has no limit
    yields no condition: `find_unjudged` names it.
    """
    trace, limits = evidence.trace, evidence.limits
    if len(trace) < 2:
        return []
    dt = trace[1].time - trace[0].time
    command = np.array([s.arm_command for s in trace])
    position, velocity = (np.array([getattr(s, name) for s in trace]) for name in ("arm_position", "arm_velocity"))
    conditions = []
    if limits.velocity is not None:
        low, high = velocity_bounds(limits, position)
        conditions.append((bool(((velocity >= low) & (velocity <= high)).all()), "the arm passed its speed limit"))
    if limits.torque is not None:
        torque = np.array([s.arm_torque for s in trace])
        conditions.append((bool((np.abs(torque) < limits.torque).all()), "the arm passed its torque limit"))
    measured = (
        ("acceleration", np.diff(command, 2, axis=0) / dt**2, limits.acceleration),
        ("jerk", np.diff(command, 3, axis=0) / dt**3, limits.jerk),
    )
    conditions += [
        (bool((np.abs(values) <= most).all()), f"the arm passed its {name} limit")
        for name, values, most in measured
        if most is not None
    ]
    if limits.position is not None:
        low, high = limits.position
        conditions.append((bool(((position >= low) & (position <= high)).all()), "the arm passed a joint range"))
    return conditions
