"""Front of the curl along the trunk, and the order in which joints bend and open.

"Grasping by Spiraling" (Introduction and Results, after Dagenais et al. 2021) says of elephant and robot alike that
curvature propagates from the tip towards the base in prehension and transport, and back in release. Here that is
measured on the magnitudes of the joints' bends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

CURLED = 0.5
"""Bend over the joint limit above which a joint counts as curled [-]."""

MOVED = 0.25
"""Least change of a joint's bend over the joint limit for the joint to count in the order [-]."""

ORDERED = 0.75
"""Least share of pairs of joints in the claimed order [-]; half is chance."""

WAY = 0.05
"""Least travel of the front over the trunk's length that counts as propagation [-]: about one section."""


@final
@dataclass(frozen=True, kw_only=True)
class Propagation:
    """Front of the curl and order of the joints; None where a phase is missing or too few joints moved."""

    prehension_start: float | None
    """Front at the start of prehension, over the trunk's length [-]."""
    transport_max: float | None
    """Largest front in prehension and transport, over the trunk's length [-]."""
    release_end: float | None
    """Front at the end of release, over the trunk's length [-]."""
    tip_first: float | None
    """Share of pairs of joints of which the one nearer the tip bent first, in prehension and transport [-]."""
    base_first: float | None
    """Share of pairs of joints of which the one nearer the base opened first, in release [-]."""

    @property
    def is_inward(self) -> bool:
        """Whether the curl propagated from the tip towards the base in prehension and transport."""
        return _has_spread(self.tip_first, self.prehension_start, self.transport_max)

    @property
    def is_outward(self) -> bool:
        """Whether it receded from the base towards the tip in release."""
        return _has_spread(self.base_first, self.release_end, self.transport_max)


def compute_front(joint_bend: np.ndarray, section_length: np.ndarray, joint_limit: float) -> np.ndarray:
    """Length of the curled part, from the tip to the joint where the curl ends, shape (...) [m].

    It is the best fit of a step from straight to closed to the bends, robust to single joints:

        front = length beyond joint i,  i = argmax sum_(j >= i) (bend_j / limit - 1/2),

    and 0 where no such sum is positive. At full curl it is one section short of the trunk's length.

    Args:
        joint_bend: bend of each joint, base to tip, shape (..., n_joint) [rad].
        section_length: length of each section, base to tip, shape (n_joint + 1,) [m].
        joint_limit: bend at which neighbouring sections touch [rad].
    """
    bend, length = np.asarray(joint_bend, float), np.asarray(section_length, float)
    excess = np.cumsum((bend / joint_limit - CURLED)[..., ::-1], axis=-1)  # From the tip inwards.
    beyond = np.cumsum(length[::-1])[:-1]
    return np.where(excess.max(axis=-1) > 0, beyond[excess.argmax(axis=-1)], 0.0)


def compute_order(joint_bend: np.ndarray, joint_limit: float, *, opens: bool) -> float | None:
    """Share of pairs of joints of which the one nearer the tip bent first, or, with ``opens``, the one nearer the base.

    The time of a joint is the last instant at which it passes half of its total change. Joints that change by less than
    a quarter of the limit, or in the other direction, are left out; pairs at the same time count half.

    Args:
        joint_bend: bend of each joint at instants of a span, base to tip, shape (n, n_joint) [rad].
        joint_limit: bend at which neighbouring sections touch [rad].
        opens: whether the joints open.

    Returns:
        1 for a strict order, 0 for the reverse, about half by chance; None with fewer than two such joints.
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
    """Front of the curl and order of the joints in a run.

    Args:
        time: instants, shape (n,) [s].
        joint_bend: bend of each joint, base to tip, shape (n, n_joint) [rad].
        phase_spans: name, start and end of each phase [-, s, s].
        section_length: length of each section, base to tip, shape (n_joint + 1,) [m].
        joint_limit: bend at which neighbouring sections touch [rad].
    """
    time, bend, length = np.asarray(time), np.asarray(joint_bend, float), np.asarray(section_length, float)
    part = compute_front(bend, length, joint_limit) / length.sum()
    spans = {phase: (begin, end) for phase, begin, end in phase_spans}

    def between(first: str, last: str) -> np.ndarray:
        (begin, _), (_, end) = spans.get(first, (np.inf, 0.0)), spans.get(last, (0.0, -np.inf))
        return np.flatnonzero((time >= begin - 1e-9) & (time <= end + 1e-9))

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
