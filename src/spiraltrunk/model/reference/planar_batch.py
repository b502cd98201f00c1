"""Compiled: bends and section ends alone of many dorsal pulls, vectorised over the trunks.

Every operation is that of `algorithm_1`, in the same order, so that the results are the same to the bit.
"""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.model.reference.algorithm_1 import arcsine, arcsine_narrow, bend_joint, rest_gap, shorten
from spiraltrunk.model.reference.constants import Table, alone, compiled, unpack
from spiraltrunk.model.reference.gravity_rest import solve_rest

_LANES = 256
"""Trunks per block, whose gaps just fit into the first cache [-]."""


def build_workspace(n_joint: int) -> np.ndarray:
    """Workspace of `solve_points` for one thread."""
    return np.empty(8 * n_joint + (n_joint + 4) * _LANES)


@compiled
def solve_points(
    inputs: tuple[np.ndarray, np.ndarray, np.ndarray],
    constants: np.ndarray,
    ends: np.ndarray,
    bend: np.ndarray,
    span: tuple[int, int],
) -> None:
    """Section ends (3, n_section, n) [m] and bends (n_joint, n) [rad] of trunks ``span[0]`` to ``span[1]``.

    Args:
        inputs: pulls, shape (n,) [m], theta_0, shape (n,) or (1,) [rad], and `build_workspace`. Neighbours at the same
            theta_0 share their rest.
        constants: numbers of the design, from `Prepared`.
        ends: filled in x and y, with NaN where the rest did not converge; z is 0 before.
        bend: filled.
        span: first trunk and one beyond the last.
    """
    t, pull, tilt, room = unpack(constants), inputs[0], inputs[1], inputs[2]
    n_joint, is_one = t.portion.size, tilt.size == 1
    wide = room[8 * n_joint :].reshape(n_joint + 4, _LANES)
    work, lanes, gap = room[: 8 * n_joint].reshape(8, n_joint), wide[:4], wide[4:]
    sag, rest = work[6], work[7]
    first, is_rest, before = span[0], True, math.nan
    while first < span[1]:
        theta_0 = tilt[0] if is_one else tilt[first]
        if theta_0 != before:
            is_rest, before = solve_rest(theta_0, t, sag, work), theta_0
            rest_gap(t, sag, rest)
        n = min(_LANES, span[1] - first)
        if not is_one:
            n = _same(tilt[first : first + n])
        for w in range(n):
            lanes[0, w] = pull[first + w]
        _shorten_lanes(t, rest, lanes[0, :n], lanes[1], gap)
        for w in range(n):
            if lanes[1, w] > 0.0:
                _shorten_one(pull[first + w], t, rest, gap[:, w])
        _bend_lanes(theta_0 if is_rest else math.nan, t, gap, lanes, (ends, bend, first, first + n))
        first += n


@compiled
def _same(tilt: np.ndarray) -> int:
    """Length of the run of equal numbers at the start."""
    n = 1
    while n < tilt.size and tilt[n] == tilt[0]:
        n += 1
    return n


@compiled
def _shorten_lanes(t: Table, rest: np.ndarray, level: np.ndarray, left: np.ndarray, gap: np.ndarray) -> None:
    """First pass of `shorten` for each trunk of ``level``; the excess of joint 1 goes to ``left`` [m]."""
    for i in range(rest.size - 1, -1, -1):
        _share_lanes(t.portion[i], t.below[i], rest[i], level, gap[i])
    for w in range(level.size):
        left[w] = max(level[w] * t.portion[0] - rest[0], 0.0)


@alone
def _share_lanes(portion: float, below: float, length: float, level: np.ndarray, gap: np.ndarray) -> None:
    """One joint of it, a function of its own, since the loop would not vectorise inside a loop over joints."""
    for w in range(level.size):
        over = level[w] * portion - length
        excess = max(over, 0.0)
        gap[w] = excess - over
        level[w] += excess * below


@compiled
def _shorten_one(pull: float, t: Table, rest: np.ndarray, gap: np.ndarray) -> None:
    """All passes of `shorten`, for a trunk whose joint 1 could not take its share."""
    for i in range(gap.size):
        gap[i] = rest[i]
    shorten(pull, t, gap)


@compiled
def _bend_lanes(
    theta_0: float,
    t: Table,
    gap: np.ndarray,
    lanes: np.ndarray,
    results: tuple[np.ndarray, np.ndarray, int, int],
) -> None:
    """Section ends and bends of trunks a to b, from the base to the tip, into ``results``: both arrays, a and b."""
    ends, bend, a, b = results
    x, y, c, s = ends[0, 0, a:b], ends[1, 0, a:b], lanes[2], lanes[3]
    cos, sin = math.cos(t.limit), math.sin(t.limit)
    for w in range(b - a):
        c[w], s[w] = math.cos(theta_0), -math.sin(theta_0)
        x[w], y[w] = c[w] * t.section_length[0], s[w] * t.section_length[0]
    for i in range(gap.shape[0]):
        per, length = 1.0 / t.diameter[i], t.section_length[i + 1]
        # Contiguous rows, without which the loop does not vectorise.
        row, turned, next_x, next_y = gap[i], bend[i, a:b], ends[0, i + 1, a:b], ends[1, i + 1, a:b]
        for w in range(b - a):
            part = row[w] * per
            turned[w], p, q = bend_joint(part, arcsine_narrow(part), t.limit, cos, sin)
            along, across = c[w] * p - s[w] * q, s[w] * p + c[w] * q
            c[w], s[w] = along, across
            next_x[w] = x[w] + along * length
            next_y[w] = y[w] + across * length
        if sin > 0.5:
            _open_wide(gap[i], per, t.limit, sin, turned)
        x, y = next_x, next_y


@compiled
def _open_wide(gap: np.ndarray, per: float, limit: float, sin: float, bend: np.ndarray) -> None:
    """Bends of the trunks whose joint opens beyond 60 deg, where the narrow arcsine does not hold."""
    for w in range(bend.size):
        part = gap[w] * per
        if part > 0.5:
            bend[w] = -limit if part >= sin else limit - 2.0 * arcsine(part)
