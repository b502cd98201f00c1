"""Compiled: bends and section ends alone of many dorsal pulls, several trunks side by side in the processor's lanes.

The arithmetic is that of `reference_bend`, step by step, so that the answers are the same to the bit.
"""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.model.reference_bend import rest_gap, shorten, turn
from spiraltrunk.model.reference_rest import settle
from spiraltrunk.model.reference_table import Table, compiled, unpack

_LANES = 32
"""Trunks side by side [-]."""


@compiled
def solve_points(
    asked: np.ndarray, constants: np.ndarray, ends: np.ndarray, bend: np.ndarray, span: tuple[int, int]
) -> None:
    """Section ends (n, n_section, 3) [m] and bends (n, n_joint) [rad] of trunks ``span[0]`` to ``span[1]``.

    Args:
        asked: pull [m], 0 and theta_0 [rad], shape (n, 3); trunks at the same theta_0 in a row share their rest.
        constants: numbers of the design, from `Prepared`.
        ends: filled; not a number where the rest did not converge.
        bend: filled.
        span: first trunk and one beyond the last.
    """
    t = unpack(constants)
    n_joint = t.portion.size
    work, rest = np.empty((5, n_joint)), np.empty(n_joint)
    gap, lanes = np.empty((n_joint, _LANES)), np.empty((7, _LANES))
    first, is_rest = span[0], True
    while first < span[1]:
        theta_0 = asked[first, 2]
        if first == span[0] or theta_0 != asked[first - 1, 2]:
            is_rest = settle(theta_0, t, work[4], work)
            rest_gap(t, work[4], rest)
        n = 0
        while n < _LANES and first + n < span[1] and asked[first + n, 2] == theta_0:
            lanes[0, n] = asked[first + n, 0]
            n += 1
        for w in range(n, _LANES):
            lanes[0, w] = 0.0
        _shorten_lanes(t, rest, lanes[0], lanes[1], gap)
        for w in range(n):
            if lanes[1, w] > 0.0:
                _shorten_one(asked[first + w, 0], t, rest, gap[:, w])
        _bend_lanes(theta_0 if is_rest else math.nan, t, gap, lanes, (ends[first : first + n], bend[first : first + n]))
        first += n


@compiled
def _shorten_lanes(t: Table, rest: np.ndarray, level: np.ndarray, left: np.ndarray, gap: np.ndarray) -> None:
    """The first pass of `shorten` in every lane; what joint 1 could not take goes to ``left`` [m]."""
    for i in range(rest.size - 1, -1, -1):
        portion, below, length = t.portion[i], t.below[i], rest[i]
        for w in range(_LANES):
            over = level[w] * portion - length
            gap[i, w] = max(-over, 0.0)
            level[w] += max(over, 0.0) * below
            left[w] = max(over, 0.0)


@compiled
def _shorten_one(pull: float, t: Table, rest: np.ndarray, gap: np.ndarray) -> None:
    """All passes of `shorten`, for the lane whose base could not take its share."""
    for i in range(gap.size):
        gap[i] = rest[i]
    shorten(pull, t, gap)


@compiled
def _bend_lanes(
    theta_0: float, t: Table, gap: np.ndarray, lanes: np.ndarray, answers: tuple[np.ndarray, np.ndarray]
) -> None:
    """Bends and section ends of every lane, from the base to the tip."""
    ends, bend = answers
    cos, sin = math.cos(t.limit), math.sin(t.limit)
    c, s, x, y, b = lanes[2], lanes[3], lanes[4], lanes[5], lanes[6]
    for w in range(_LANES):
        c[w], s[w] = math.cos(theta_0), -math.sin(theta_0)
        x[w], y[w] = c[w] * t.section_length[0], s[w] * t.section_length[0]
    for w in range(ends.shape[0]):
        ends[w, 0, 0], ends[w, 0, 1], ends[w, 0, 2] = x[w], y[w], 0.0
    for i in range(gap.shape[0]):
        diameter, length = t.diameter[i], t.section_length[i + 1]
        for w in range(_LANES):
            b[w], p, q = turn(gap[i, w], diameter, t.limit, cos, sin)
            c[w], s[w] = c[w] * p - s[w] * q, s[w] * p + c[w] * q
            x[w] += c[w] * length
            y[w] += s[w] * length
        for w in range(ends.shape[0]):
            ends[w, i + 1, 0], ends[w, i + 1, 1], ends[w, i + 1, 2] = x[w], y[w], 0.0
            bend[w, i] = b[w]
