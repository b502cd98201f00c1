"""Moments of a trial on which its verdict rests: as the strategy reported them, or as the ground truth shows them."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.control.loop import RunLog
from spiraltrunk.control.messages import Task
from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.sim.ground_truth import Sample

Span = tuple[float, float]

SLACK_SHARE = 0.02
"""Tension of the strings over the object's weight below which they are slack [-] (ours)."""

WAY_TOLERANCE = 0.24
"""Largest deviation of lift and carry over the goal's at which the referee lets them end [-] (ours): just inside the
verdict's tolerance."""

HOLD_TOLERANCE = 0.05
"""Time by which a hold may be shorter than the goal's [s] (ours)."""

HOLD_HEIGHT = 0.02
"""Largest deviation of a held object from its mean height [m] (ours)."""

ARM_STILL = 0.05
"""Largest range of a joint of the arm in which it counts as at rest [rad] (ours): 2 to 4 cm at the trunk's base."""

RISE_STILL = 0.02
"""Vertical speed of the object below which its lift has ended [m/s] (ours)."""

WAY_BEGUN = 0.1
"""Share of the way aside after which a carry has begun [-] (ours)."""

EVERY = 5
"""Samples from one look for a hold to the next [-] (ours)."""

REST_TIME = 0.2
"""Time over which an object at rest keeps its place [s] (ours)."""

REST_STEPS = round(REST_TIME / CONTROL_PERIOD)
"""Samples in that time [-]."""

REST_WAY = 0.002
"""Displacement that an object at rest may show in that time [m] (ours)."""


@final
@dataclass(frozen=True, kw_only=True)
class Moments:
    """Begin and end of what the strategy reported by its milestones [s]; None for what it did not report."""

    push: Span | None = None
    """From the start of the push until the trunk has withdrawn."""
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

    @classmethod
    def from_trace(cls, trace: Sequence[Sample], task: Task) -> Moments:
        """Moments of a run whose strategy reported no milestone, by a `Referee`."""
        referee = Referee(task)
        for sample in trace:
            referee.update(sample)
        return referee.moments


@final
class Referee:
    """Finds a trial's moments in the ground truth, sample by sample: for policies, which report none.

    A lift ends where the object, without support by strings, table or ground, has risen by the goal's lift and rises no
    more, or is on its way aside. It begins where the object was lower by the goal's lift, or where it last had support:
    a trunk that closes round a hanging object may have raised it before. A hold is the first stretch of the goal's
    time in which the trunk alone holds the object, its height and the arm at rest, after a carry. The carry ends where
    the hold begins, and begins where the object last was the goal's way aside from there. An object that is supported
    again before it was held is lifted anew. A push ends at the last sample before the lift at which the object rested
    on the ground and the trunk did not touch it.
    """

    def __init__(self, task: Task) -> None:
        goal = task.goal
        self._task = task
        self._slack = SLACK_SHARE * task.target.mass * GRAVITY
        self._aside = float(np.linalg.norm(goal.aside))
        way = goal.place - task.target.position - goal.aside
        self._is_push = goal.ground is not None and float(np.hypot(way[0], way[1])) > 1e-9
        self.reached: dict[Milestone, float] = {}
        """Milestones that were reached, and when first [s]."""
        self._push: Span | None = None
        self._lift: Span | None = None
        self._carry: Span | None = None
        self._hold: Span | None = None
        self._from: Sample | None = None  # Last sample with support.
        self._flight: list[Sample] = []  # Samples since then.
        self._lifted: Sample | None = None  # Sample at which the lift ended.
        self._before: Sample | None = None
        self._rise = 0.0
        self._held: list[Sample] = []
        self._places: deque[np.ndarray] = deque(maxlen=REST_STEPS + 1)

    def copy(self) -> Referee:
        """A referee in the same state; samples are shared."""
        twin = copy(self)
        twin.reached, twin._flight, twin._held = dict(self.reached), list(self._flight), list(self._held)
        twin._places = self._places.copy()
        return twin

    @property
    def moments(self) -> Moments:
        """The moments so far."""
        return Moments(push=self._push, lift=self._lift, carry=self._carry, hold=self._hold)

    @property
    def rise(self) -> float:
        """Rise of the object since it was last supported [m]; 0 while it is."""
        return self._rise

    @property
    def held_time(self) -> float:
        """Time for which the object has been held so far, without a break [s]."""
        return self._held[-1].time - self._held[0].time if len(self._held) > 1 else 0.0

    @property
    def way_aside(self) -> float:
        """Horizontal distance of the object from where its lift ended [m]; 0 before."""
        return 0.0 if self._lifted is None else _distance(self._flight[-1], self._lifted)

    def update(self, sample: Sample) -> None:
        """Take the next sample into account."""
        is_supported = sample.touches_table or sample.string_tension > self._slack
        if sample.grip_force > 0.0:
            self.reached.setdefault(Milestone.TOUCHED, sample.time)
        if self._hold is not None:
            self._follow_release(sample)
        elif is_supported or self._from is None:
            self._support(sample)
        else:
            self._follow_lift(sample, self._from)
        self._places.append(sample.object_position)
        self._before = sample

    def is_at_rest(self) -> bool:
        """Whether the object kept its place over the last 0.2 s."""
        if len(self._places) <= REST_STEPS:
            return False
        return math.dist(self._places[0], self._places[-1]) <= REST_WAY

    def _support(self, sample: Sample) -> None:
        """The object is supported: a lift begins anew; where it rests untouched, a push has ended."""
        self._from, self._lift, self._lifted = sample, None, None
        self._flight.clear()
        self._held.clear()
        self._rise = 0.0
        began = self.reached.get(Milestone.TOUCHED)
        is_free = sample.touches_table and sample.grip_force == 0.0
        if self._is_push and began is not None and is_free and self.is_at_rest():
            self._push = (began, sample.time)
            self.reached.setdefault(Milestone.PUSHED, sample.time)

    def _follow_lift(self, sample: Sample, start: Sample) -> None:
        self._rise = float(sample.object_position[2] - start.object_position[2])
        self._flight.append(sample)
        if self._lift is None:
            self._find_lift(sample, start)
        if self._lift is None:
            return
        if self.way_aside >= (1.0 - WAY_TOLERANCE) * self._aside:
            self.reached.setdefault(Milestone.CARRIED, sample.time)
        if sample.grip_force > 0.0 and not sample.touches_robot:
            self._held.append(sample)
            self._find_hold()
        else:
            self._held.clear()

    def _find_lift(self, sample: Sample, start: Sample) -> None:
        """The lift ends where the object has risen far enough, and rises no more or is on its way aside."""
        before = start if self._before is None else self._before
        if self._rise < (1.0 - WAY_TOLERANCE) * self._task.goal.lift:
            return
        step = float(sample.object_position[2] - before.object_position[2])
        is_aside = _distance(sample, start) > WAY_BEGUN * self._aside
        if is_aside or abs(step) <= RISE_STILL * (sample.time - before.time):
            low = sample.object_position[2] - self._task.goal.lift
            begin = next((each for each in reversed(self._flight) if each.object_position[2] <= low), start)
            self._lift, self._lifted = (begin.time, sample.time), sample
            self.reached.setdefault(Milestone.LIFTED, sample.time)

    def _find_hold(self) -> None:
        """A hold is the latest stretch of the goal's time, where object and arm were still in it and it was carried."""
        if len(self._held) < 2:
            return
        period = self._held[-1].time - self._held[-2].time
        count = math.ceil((self._task.goal.hold - HOLD_TOLERANCE) / period - 1e-9)
        late = len(self._held) - max(count, 2)
        if late < 0 or late % EVERY != 0:
            return
        part = self._held[-count:]
        height = np.array([s.object_position[2] for s in part])
        joints = np.array([s.arm_position for s in part])
        if np.abs(height - height.mean()).max() > HOLD_HEIGHT or np.ptp(joints, axis=0).max() > ARM_STILL:
            return
        carry = self._find_carry(part[0])
        if carry is not None:
            self._carry, self._hold = carry, (part[0].time, part[-1].time)
            self.reached.setdefault(Milestone.CARRIED, part[0].time)
            self.reached.setdefault(Milestone.HELD, part[-1].time)

    def _find_carry(self, end: Sample) -> Span | None:
        """The carry that ends at a sample; None where the object was never as far away before."""
        assert self._lift is not None
        part = [each for each in self._flight if self._lift[0] <= each.time <= end.time]
        place = np.array([each.object_position[:2] for each in part])
        way = np.linalg.norm(place - end.object_position[:2], axis=1)
        most = min(float(way.max()), self._aside)
        first = int(np.flatnonzero(way >= most - REST_WAY)[-1])
        return None if most < (1.0 - WAY_TOLERANCE) * self._aside else (part[first].time, end.time)

    def _follow_release(self, sample: Sample) -> None:
        self._rise = 0.0
        if sample.touches_table:
            self.reached.setdefault(Milestone.SET_DOWN, sample.time)
            if sample.grip_force == 0.0 and self.is_at_rest():
                self.reached.setdefault(Milestone.RELEASED, sample.time)


def _distance(sample: Sample, start: Sample) -> float:
    """Horizontal distance of the object between two samples [m]."""
    x, y, _ = (sample.object_position - start.object_position).tolist()
    return math.hypot(x, y)
