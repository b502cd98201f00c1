"""How much of the trunk is curled, counted from the tip, and in which order its joints bend and open.

"Grasping by Spiraling" (Introduction and Results, after Dagenais et al. 2021) says of elephant and robot alike that
curvature propagates from the tip towards the base in prehension and transport, and back in release. Here that is
measured on the bends of the joints, whatever their direction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.errors import ShapeError

CURLED = 0.5
"""Bend over the joint limit above which a joint counts as curled [-]."""

MOVED = 0.25
"""Least change of a joint's bend over the joint limit for it to have a place in the order [-]."""

ORDERED = 0.75
"""Least share of pairs of joints in the claimed order [-]; half is chance."""

WAY = 0.05
"""Least way of the front over the trunk's length that counts as propagation [-]: about one section."""


@final
@dataclass(frozen=True, kw_only=True)
class Propagation:
    """Where the front was, and the order of the joints; None where a phase did not come or too few joints moved."""

    prehension_start: float | None
    """Front when prehension begins, over the trunk's length [-]."""
    transport_max: float | None
    """Largest front from then until the end of transport, over the trunk's length [-]."""
    release_end: float | None
    """Front when release ends, over the trunk's length [-]."""
    tip_first: float | None
    """Share of pairs of joints of which, until the end of transport, the one nearer the tip bent first [-]."""
    base_first: float | None
    """Share of pairs of joints of which, in release, the one nearer the base opened first [-]."""

    @property
    def is_inward(self) -> bool:
        """Whether the curl spread from the tip towards the base until the end of transport."""
        return _has_spread(self.tip_first, self.prehension_start, self.transport_max)

    @property
    def is_outward(self) -> bool:
        """Whether it went back from the base towards the tip in release."""
        return _has_spread(self.base_first, self.release_end, self.transport_max)


def compute_front(joint_bend: np.ndarray, section_length: np.ndarray, joint_limit: float) -> np.ndarray:
    """How much of the trunk is curled, from the tip to the joint where the curl ends, shape (...) [m].

    The trunk is split at that joint at which the bends on the tip's side exceed half the joint limit by most, in sum

        front = length beyond joint i,  i = argmax sum_(j >= i) (bend_j / limit - 1/2),

    and 0 where no such sum is positive. That is where a step from straight to shut fits the bends best, so one joint
    that lags within the curl, or bends alone before it, does not move it. At full curl it ends at joint 1, one section
    short of the trunk's length.

    Args:
        joint_bend: bend of each joint, base to tip, shape (..., n_joint) [rad].
        section_length: length of each section, base to tip, shape (n_joint + 1,) [m].
        joint_limit: bend at which neighbouring sections touch [rad].

    Raises:
        ShapeError: where the shapes do not fit or the limit is not positive.
    """
    bend, length = np.asarray(joint_bend, float), np.asarray(section_length, float)
    if length.ndim != 1 or bend.ndim < 1 or bend.shape[-1] != len(length) - 1:
        raise ShapeError(
            f"joint_bend has shape {bend.shape}, section_length {length.shape}; allowed: (..., n) and (n + 1,)"
        )
    if not (np.isfinite(joint_limit) and joint_limit > 0):
        raise ShapeError(f"joint_limit is {joint_limit}; allowed: finite, > 0 rad")
    excess = np.cumsum((bend / joint_limit - CURLED)[..., ::-1], axis=-1)  # From the tip inwards.
    beyond = np.cumsum(length[::-1])[:-1]
    return np.where(excess.max(axis=-1) > 0, beyond[excess.argmax(axis=-1)], 0.0)


def compute_order(joint_bend: np.ndarray, joint_limit: float, *, opens: bool) -> float | None:
    """Share of pairs of joints of which the one nearer the tip bent first, or, opening, the one nearer the base.

    A joint's time is that from which on it has done more than half of its change to the last instant for good. Joints
    that change by less than a quarter of the limit, or the other way, are left out; pairs at the same time count half.

    Args:
        joint_bend: bend of each joint at instants of a span, base to tip, shape (n, n_joint) [rad].
        joint_limit: bend at which neighbouring sections touch [rad].
        opens: whether joints are to open rather than to bend.

    Returns:
        1 where the order is strict, 0 where it is reversed, about half by chance; None with fewer than two such joints.
    """
    bend = np.asarray(joint_bend, float)
    change = bend[-1] - bend[0] if len(bend) else np.zeros(bend.shape[1])
    moved = (-change if opens else change) >= MOVED * joint_limit
    if np.count_nonzero(moved) < 2:
        return None
    is_before = (bend[:, moved] - bend[0, moved]) / change[moved] <= 0.5
    times = len(bend) - np.argmax(is_before[::-1], axis=0)
    if not opens:
        times = times[::-1]
    first, second = np.triu_indices(len(times), k=1)
    return float(np.mean((np.sign(times[second] - times[first]) + 1) / 2))


def compute_propagation(
    time: np.ndarray,
    joint_bend: np.ndarray,
    phase_spans: Sequence[tuple[str, float, float]],
    *,
    section_length: np.ndarray,
    joint_limit: float,
) -> Propagation:
    """Front and order of the joints in a run.

    Args:
        time: instants, shape (n,) [s].
        joint_bend: bend of each joint, base to tip, shape (n, n_joint) [rad].
        phase_spans: name of each phase that came, its begin and end [-, s, s].
        section_length: length of each section, base to tip, shape (n_joint + 1,) [m].
        joint_limit: bend at which neighbouring sections touch [rad].

    Raises:
        ShapeError: where the shapes do not fit.
    """
    time, bend, length = np.asarray(time), np.asarray(joint_bend, float), np.asarray(section_length, float)
    part = compute_front(bend, length, joint_limit) / length.sum()
    spans = {phase: (begin, end) for phase, begin, end in phase_spans}

    def between(first: str, last: str) -> np.ndarray:
        if first not in spans or last not in spans:
            return np.zeros(0, int)
        return np.flatnonzero((time >= spans[first][0] - 1e-9) & (time <= spans[last][1] + 1e-9))

    inward, outward = between("prehension", "transport"), between("release", "release")
    return Propagation(
        prehension_start=float(part[inward[0]]) if len(inward) else None,
        transport_max=float(part[inward].max()) if len(inward) else None,
        release_end=float(part[outward[-1]]) if len(outward) else None,
        tip_first=compute_order(bend[inward], joint_limit, opens=False),
        base_first=compute_order(bend[outward], joint_limit, opens=True),
    )


def _has_spread(order: float | None, low: float | None, high: float | None) -> bool:
    if order is None or low is None or high is None:
        return False
    return order >= ORDERED and high - low >= WAY
