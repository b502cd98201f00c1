"""Compiled: Algorithm 2, rotation of the joints that cable 1 left open, by cable 2."""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.model.reference.constants import Table, compiled

_LARGEST_TURN = math.pi / 4
"""Largest turn about a joint's axis (authors' code: 45 deg) [rad]; the faces meet earlier."""

_NOTHING = 1e-12
"""Cable that is rounding, not length [m]."""


@compiled
def pull_second(pull: float, t: Table, work: np.ndarray, rotation: np.ndarray) -> float:
    """Joint rotations after cable 2 is pulled in by ``pull`` [m] (paper, Algorithm 2); returns the unused pull [m].

    The joints nearer to the base than the first that cable 1 has shut turn about the line through their centre and the
    hole of cable 1 before them, which keeps the gap of cable 1; the others stay as cable 1 left them. Limits and shares
    come from the shape after cable 1. Rows 1 and 2 of ``work`` hold its gaps [m] and bends [rad], rows 5 to 7 are
    workspace; the rotations, shape (n_joint, 3, 3), go to ``rotation``.
    """
    gap, bend, room, share, least = work[1], work[2], work[5], work[6], work[7]
    n_open = 0
    while n_open < gap.size and gap[n_open] > 0.0:
        least[n_open] = _turn_limit(bend[n_open], t, n_open)
        gained = second_gap(0.0, bend[n_open], t, n_open) - second_gap(least[n_open], bend[n_open], t, n_open)
        room[n_open] = max(gained, 0.0)
        n_open += 1
    left = _share_out(pull, t, room, share, n_open)
    for i in range(gap.size):
        angle = 0.0
        if i < n_open and share[i] > 0.0:
            angle = least[i]
            if share[i] < room[i]:
                angle = max(_turn_to(second_gap(0.0, bend[i], t, i) - share[i], bend[i], t, i), least[i])
        _rotate(angle, bend[i], t, i, rotation[i])
    return left


@compiled
def _share_out(pull: float, t: Table, room: np.ndarray, share: np.ndarray, n_open: int) -> float:
    """Shares of ``pull`` for the open joints, at most their ``room`` [m]; returns the unused pull [m].

    The portions run in reverse, most at the base, and are normalised over the open joints, which the paper does not
    specify. A full joint passes the excess to those nearer to the base. With ``as_authors``, as in the authors' code,
    the full joint's room is instead subtracted from the pull and the normalisation still counts that joint.
    """
    total = 0.0
    for i in range(n_open):
        total += t.portion[room.size - 1 - i]
    level, nearer, given, is_full = pull, total, 0.0, True
    for i in range(n_open - 1, -1, -1):
        portion = t.portion[room.size - 1 - i]
        with_this, nearer = nearer, nearer - portion
        over = level * portion / total - room[i]
        share[i] = room[i] if over > 0.0 else level * portion / total
        given += share[i]
        is_full = is_full and over >= 0.0
        if over > 0.0 and t.as_authors:
            level, total = level - room[i], with_this
        elif over > 0.0 and i > 0:
            level += over * total / nearer
    if t.as_authors:
        return max(pull - given, 0.0) if is_full else 0.0
    return _fill(pull - given, t, room, share, n_open)


@compiled
def _fill(left: float, t: Table, room: np.ndarray, share: np.ndarray, n_open: int) -> float:
    """Distribute the excess of joint 1 [m] by portions over the joints with room; returns the unused pull [m].

    The paper does not specify this, though joint 1 has the largest share and is often full first.
    """
    while left > _NOTHING:
        total = 0.0
        for i in range(n_open):
            total += t.portion[room.size - 1 - i] if share[i] < room[i] else 0.0
        if total == 0.0:
            break
        level, left = left / total, 0.0
        for i in range(n_open):
            if share[i] < room[i]:
                over = share[i] + level * t.portion[room.size - 1 - i] - room[i]
                share[i] = room[i] + min(over, 0.0)
                left += max(over, 0.0)
    return left


@compiled
def _parts(bend: float, t: Table, i: int) -> tuple[float, float, float, float]:
    """Gap of cable 2 at turn a, gap^2 = size - 2 (fixed + along cos a + across sin a): size, fixed, across, along."""
    u, v = t.before[i, 0, 0], t.before[i, 0, 1]
    length = math.hypot(u, v)
    u, v = u / length, v / length
    c, s = math.cos(bend), math.sin(bend)
    bx, by, bz = t.before[i, 1, 0], t.before[i, 1, 1], t.before[i, 1, 2]
    px, py, z = t.beyond[i, 1, 0], t.beyond[i, 1, 1], t.beyond[i, 1, 2]
    x, y = c * px - s * py, s * px + c * py
    fixed = (bx * u + by * v) * (x * u + y * v)
    along = bx * x + by * y + bz * z - fixed
    across = u * (by * -z + bz * y) + v * (bx * z - bz * x)
    return bx * bx + by * by + bz * bz + x * x + y * y + z * z, fixed, across, along


@compiled
def second_gap(angle: float, bend: float, t: Table, i: int) -> float:
    """Gap of cable 2 at joint ``i`` bent by ``bend`` and turned by ``angle`` [m]."""
    size, fixed, across, along = _parts(bend, t, i)
    dot = fixed + along * math.cos(angle) + across * math.sin(angle)
    return math.sqrt(max(size - 2.0 * dot, 0.0))


@compiled
def _turn_to(gap: float, bend: float, t: Table, i: int) -> float:
    """First turn from 0 downwards at which the gap of cable 2 is ``gap`` [m], [rad]."""
    size, fixed, across, along = _parts(bend, t, i)
    reach = (0.5 * (size - gap * gap) - fixed) / math.hypot(along, across)
    return min(math.atan2(across, along) + math.acos(min(max(reach, -1.0), 1.0)), 0.0)


@compiled
def _turn_limit(bend: float, t: Table, i: int) -> float:
    """Turn at which the axes of the two sections enclose the limit, or at which the gap is smallest [rad].

    With the turning axis at b from the first section's axis and at b - bend from the second's, the law of cosines on
    the sphere gives cos(limit) = cos b cos(b - bend) + sin b sin(b - bend) cos(turn). In the paper's words the axes
    meet at 150 deg.
    """
    b = math.atan2(t.before[i, 0, 1], t.before[i, 0, 0])
    cos = (math.cos(t.limit) - math.cos(b) * math.cos(b - bend)) / (math.sin(b) * math.sin(b - bend))
    _, _, across, along = _parts(bend, t, i)
    least = max(-math.acos(min(max(cos, -1.0), 1.0)), -_LARGEST_TURN)
    return min(max(least, math.atan2(across, along)), 0.0)


@compiled
def _rotate(angle: float, bend: float, t: Table, i: int, out: np.ndarray) -> None:
    """Rotation of joint ``i``: first the bend about z, then the turn about the line to cable 1's hole."""
    u, v = t.before[i, 0, 0], t.before[i, 0, 1]
    length = math.hypot(u, v)
    u, v = u / length, v / length
    cos, sin = math.cos(angle), math.sin(angle)
    rest = 2.0 * math.sin(0.5 * angle) ** 2
    c, s = math.cos(bend), math.sin(bend)
    for k in range(3):
        x, y = (c, s) if k == 0 else (-s, c)
        x, y, z = (x, y, 0.0) if k < 2 else (0.0, 0.0, 1.0)
        along = (u * x + v * y) * rest
        out[0, k] = cos * x + sin * v * z + u * along
        out[1, k] = cos * y - sin * u * z + v * along
        out[2, k] = cos * z + sin * (u * y - v * x)
