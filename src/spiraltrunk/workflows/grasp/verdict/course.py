"""Course of an object over a trial: how it rose, moved, tilted and slid, from the simulator's true state."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import final

import numpy as np

from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.workflows.grasp.verdict.evidence import Evidence
from spiraltrunk.workflows.grasp.verdict.moments import SLACK_SHARE

STANDING = math.radians(30.0)
"""Angle of an object's axis to the vertical below which it stands [rad] (ours): it stands at 0 and lies at 90 deg."""

BORNE_SHARE = 0.25
"""Sum of the normal forces over the object's weight from which the trunk bears it, and does not only touch it [-]
(ours): at friction 1.2, the largest that trials draw, it then carries up to 30 % of the weight."""

CONTACT_GAP = 0.1
"""Longest time without contact that does not end a grip [s] (ours): contacts flicker under objects that roll."""


@final
@dataclass(frozen=True, kw_only=True)
class Course:
    """What happened to the object, sample by sample; every array begins with n_sample."""

    time: np.ndarray
    """Time, shape (n_sample,) [s]."""
    rise: np.ndarray
    """Height above that at the start, shape (n_sample,) [m]."""
    shift: np.ndarray
    """Horizontal distance from where it began, shape (n_sample,) [m]."""
    tilt: np.ndarray
    """Change of the angle between its axis and the vertical, shape (n_sample,) [rad]; 0 for a sphere."""
    slide: np.ndarray
    """Way that it slid along the trunk so far, while the trunk bore it, shape (n_sample, 3) [m]."""
    curl: np.ndarray
    """Sum of the trunk's joint bends, shape (n_sample,) [rad]."""
    is_borne: np.ndarray
    """Whether the trunk bears it, gaps of up to CONTACT_GAP included, shape (n_sample,)."""
    fall: np.ndarray
    """Height lost since it last touched anything, shape (n_sample,) [m]."""
    is_supported: np.ndarray
    """Whether it touches table or ground, or its strings are taut, shape (n_sample,)."""
    width: float
    """Extent across its axis [m]."""
    stands: bool
    """Whether its axis was vertical at the start."""
    topple_angle: float
    r"""Tilt at which it falls over, :math:`\arctan(d / h)` of a solid of width d and height h [rad]."""

    @classmethod
    def from_evidence(cls, evidence: Evidence) -> Course:
        """Course of the object over a trial's trace."""
        trace, target = evidence.trace, evidence.task.target
        time, weight = np.array([s.time for s in trace]), target.mass * GRAVITY
        moved = np.array([s.object_position for s in trace]) - trace[0].object_position
        angle = np.array([compute_angle(s.object_axis) for s in trace])
        is_borne = _close_gaps(np.array([s.grip_force >= BORNE_SHARE * weight for s in trace]), time)
        steps = np.diff(time, prepend=time[0])[:, None] * [s.slip_velocity for s in trace] * is_borne[:, None]
        is_supported = np.array([s.touches_table or s.string_tension > SLACK_SHARE * weight for s in trace])
        is_touched = is_supported | np.array([s.grip_force > 0 for s in trace])
        has_axis = target.kind != "sphere"
        return cls(
            time=time, rise=moved[:, 2], shift=np.linalg.norm(moved[:, :2], axis=1),
            tilt=np.abs(angle - angle[0]) * has_axis, slide=steps.cumsum(axis=0),
            curl=np.array([float(np.sum(s.joint_bend)) for s in trace]), is_borne=is_borne,
            fall=_compute_fall(moved[:, 2], is_touched), is_supported=is_supported,
            width=target.width, stands=bool(has_axis and angle[0] < STANDING),
            topple_angle=math.atan2(target.width, target.length),
        )  # fmt: skip

    def index(self, time: float) -> int:
        """The first sample at or after a time [s]; the last one where there is none."""
        return min(int(np.searchsorted(self.time, time - 1e-9)), len(self.time) - 1)


def compute_angle(axis: np.ndarray) -> float:
    """Angle between an object's axis, shape (3,) [-], and the vertical [rad]: 0 stands, pi stands on its head."""
    return math.acos(float(np.clip(axis[2], -1.0, 1.0)))


def find_runs(holds: np.ndarray) -> list[tuple[int, int]]:
    """First sample of each run in which something holds, and the first one after it."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], np.asarray(holds, int), [0]])))
    return [(int(first), int(after)) for first, after in edges.reshape(-1, 2)]


def _compute_fall(height: np.ndarray, is_touched: np.ndarray) -> np.ndarray:
    """Height lost since the last touch, shape (n_sample,) [m]."""
    last = np.maximum.accumulate(np.where(is_touched, np.arange(len(height)), 0))
    return np.asarray(height[last] - height)


def _close_gaps(holds: np.ndarray, time: np.ndarray) -> np.ndarray:
    """The same with interruptions of up to CONTACT_GAP between two runs closed."""
    closed, runs = holds.copy(), find_runs(holds)
    for (_, end), (begin, _) in pairwise(runs):
        if time[begin] - time[end - 1] <= CONTACT_GAP + 1e-9:
            closed[end:begin] = True
    return closed
