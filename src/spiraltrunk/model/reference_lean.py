"""Compiled: bends and section ends alone of many dorsal pulls, several trunks side by side in the processor's lanes.

The arithmetic is that of `reference_bend`, step by step, so that the answers are the same to the bit.
"""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.model.reference_bend import arcsine, arcsine_narrow, rest_gap, shorten, turn
from spiraltrunk.model.reference_rest import settle
from spiraltrunk.model.reference_table import Table, compiled, unpack

_LANES = 32
"""Trunks side by side [-]."""


@compiled
def solve_points(
    asked: tuple[np.ndarray, np.ndarray],
    constants: np.ndarray,
    ends: np.ndarray,
    bend: np.ndarray,
    span: tuple[int, int],
) -> None:
    """Section ends (n, n_section, 3) [m] and bends (n_joint, n) [rad] of trunks ``span[0]`` to ``span[1]``.

    Bends are kept joint by joint, as the lanes write them at once, and section ends trunk by trunk, as they are read.

    Args:
        asked: pulls, shape (n,) [m], and theta_0, shape (n,) or (1,) [rad]; trunks at the same one in a row share rest.
        constants: numbers of the design, from `Prepared`.
        ends: filled in x and y, not a number where the rest did not converge; z is 0 before.
        bend: filled.
        span: first trunk and one beyond the last.
    """
    t, pull, tilt = unpack(constants), asked[0], asked[1]
    n_joint, is_one = t.portion.size, asked[1].size == 1
    work, rest = np.empty((5, n_joint)), np.empty(n_joint)
    gap, lanes = np.empty((n_joint, _LANES)), np.empty((7, _LANES))
    first, is_rest, before = span[0], True, math.nan
    while first < span[1]:
        theta_0 = tilt[0] if is_one else tilt[first]
        if theta_0 != before:
            is_rest, before = settle(theta_0, t, work[4], work), theta_0
            rest_gap(t, work[4], rest)
        n = 0
        while n < _LANES and first + n < span[1] and (is_one or tilt[first + n] == theta_0):
            lanes[0, n] = pull[first + n]
            n += 1
        for w in range(n, _LANES):
            lanes[0, w] = 0.0
        _shorten_lanes(t, rest, lanes[0], lanes[1], gap)
        for w in range(n):
            if lanes[1, w] > 0.0:
                _shorten_one(pull[first + w], t, rest, gap[:, w])
        answers = ends[first : first + n], bend[:, first : first + n]
        _bend_lanes(theta_0 if is_rest else math.nan, t, gap, lanes, answers)
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
        ends[w, 0, 0], ends[w, 0, 1] = x[w], y[w]
    for i in range(gap.shape[0]):
        per, length = 1.0 / t.diameter[i], t.section_length[i + 1]
        for w in range(_LANES):
            part = gap[i, w] * per
            b[w], p, q = turn(part, arcsine_narrow(part), t.limit, cos, sin)
            c[w], s[w] = c[w] * p - s[w] * q, s[w] * p + c[w] * q
            x[w] += c[w] * length
            y[w] += s[w] * length
        if sin > 0.5:
            _open_wide(gap[i], per, t.limit, sin, b)
        for w in range(ends.shape[0]):
            bend[i, w] = b[w]
        for w in range(ends.shape[0]):
            ends[w, i + 1, 0], ends[w, i + 1, 1] = x[w], y[w]


@compiled
def _open_wide(gap: np.ndarray, per: float, limit: float, sin: float, bend: np.ndarray) -> None:
    """Bends of the lanes whose opening is beyond 60 deg, for which the narrow arcsine does not hold."""
    for w in range(_LANES):
        part = gap[w] * per
        if part > 0.5:
            bend[w] = -limit if part >= sin else limit - 2.0 * arcsine(part)
